"""What holds for every file of the project: its size, its contract and what it must not speak of."""

import ast
import re
import subprocess
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[1]
MODULES = sorted((ROOT / "src").rglob("*.py"))
TEXT = {".py", ".md", ".toml", ".txt", ".in", ".html", ".css", ".cfg", ".yml", ".yaml", ".json", ""}

# Spelled in pieces so that this file does not match itself.
FORBIDDEN = {
    "a path of one machine": re.compile("/" + r"(?:home|root|Users|opt|work|tmp)" + r"/\w"),
    "a package host": re.compile(r"p" + r"ypi\.|files\.python" + r"hosted|index-" + r"url|conda\.an" + "a"),
    "who wrote it": re.compile(r"\b(?:Cla" + r"ude|Anthro" + r"pic|Chat" + r"GPT|Co-Aut" + r"hored)", re.I),
    "unfinished work": re.compile(r"\b(?:TO" + r"DO|FIX" + r"ME|X" + r"XX)\b|Not" + "ImplementedError"),
}  # fmt: skip


def tracked() -> list[Path]:
    """The files that git knows, or all text files when this is not a checkout."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("not a git checkout")
    return [ROOT / name for name in listed.stdout.splitlines() if (ROOT / name).is_file()]


@pytest.mark.parametrize("what", FORBIDDEN)
def test_no_tracked_file_speaks_of(what: str) -> None:
    found, paths = [], [path for path in tracked() if path.suffix in TEXT]
    assert set(MODULES) <= set(paths)
    for path in paths:
        for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
            if FORBIDDEN[what].search(line):
                found.append(f"{path.relative_to(ROOT)}:{number}: {line.strip()[:90]}")
    assert not found, "\n".join(found)


def test_the_citation_names_this_version() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    cited = re.search(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text("utf-8"), re.M)
    assert cited is not None and cited[1] == project["version"]


def test_modules_stay_under_300_lines() -> None:
    assert len(MODULES) > 100
    long = {
        str(p.relative_to(ROOT)): n for p in MODULES if (n := len(p.read_text("utf-8").splitlines())) > 300
    }
    assert not long


def test_functions_stay_under_40_lines_without_their_docstrings() -> None:
    long = []
    for path in MODULES:
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.FunctionDef):
                first = node.body[1:] if ast.get_docstring(node) and len(node.body) > 1 else node.body
                length = node.end_lineno - first[0].lineno + 1  # type: ignore[operator]
                if length > 40:
                    long.append(f"{path.relative_to(ROOT)}:{node.lineno} {node.name}: {length} lines")
    assert not long, "\n".join(long)


def test_requirements_are_pinned_hashed_and_name_no_host() -> None:
    for name in ("requirements.txt", "requirements-dev.txt", "requirements-docs.txt"):
        text = (ROOT / name).read_text()
        pins = re.findall(r"^([\w.-]+)(?:\[[\w,-]+\])?==", text, re.M)
        blocks = re.split(r"\n(?=\w)", text.strip())
        assert len(pins) == len(blocks) > 20
        assert all("--hash=sha256:" in block for block in blocks)
        assert "://" not in text
        declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
        wanted = {re.match(r"[\w-]+", d).group() for d in declared}  # type: ignore[union-attr]
        assert wanted <= {p.lower() for p in pins}


def test_requirements_name_the_extras_that_others_ask_for() -> None:
    """Otherwise pip 23 looks for the newest release with the extra, which no hash is pinned for."""
    for name in ("requirements.txt", "requirements-dev.txt"):
        text = (ROOT / name).read_text()
        pinned = {p: set(e.split(",")) for p, e in re.findall(r"^([\w.-]+)\[([\w,-]+)\]==", text, re.M)}
        asked = 0
        for package in re.findall(r"^([\w.-]+)(?:\[[\w,-]+\])?==", text, re.M):
            try:
                needs = metadata.requires(package) or []
            except metadata.PackageNotFoundError:
                continue  # for another system or version of Python
            for need in (Requirement(n) for n in needs if "extra ==" not in n):
                if need.extras and (need.marker is None or need.marker.evaluate()):
                    assert need.extras <= pinned.get(need.name.lower(), set()), f"{package}: {need}"
                    asked += 1
        assert asked or name == "requirements.txt"
