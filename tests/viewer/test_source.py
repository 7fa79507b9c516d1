"""What holds for the source of the viewer: pinned packages, small modules, a page that asks nobody else."""

import json
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
WEB = ROOT / "web"


def test_packages_are_pinned_by_hashes_and_no_host_is_named() -> None:
    lock = json.loads((WEB / "package-lock.json").read_text("utf-8"))
    packages = {name: about for name, about in lock["packages"].items() if name}
    assert len(packages) > 5
    assert all(about["integrity"].startswith("sha512-") for about in packages.values())
    assert not any("resolved" in about for about in packages.values())
    about = json.loads((WEB / "package.json").read_text("utf-8"))
    pinned = about["dependencies"] | about["devDependencies"]
    assert all(re.fullmatch(r"\d+\.\d+\.\d+(-[\w.]+)?", version) for version in pinned.values())


def test_modules_are_small_and_typed() -> None:
    modules = [*(WEB / "src").rglob("*.ts"), WEB / "src" / "style.css"]
    assert len(modules) > 15
    assert not {m.name: n for m in modules if (n := len(m.read_text("utf-8").splitlines())) > 300}
    for module in modules:
        assert not re.search(r"\bas any\b|: any\b|@ts-", module.read_text("utf-8")), module.name
    assert '"strict": true' in (WEB / "tsconfig.json").read_text("utf-8")


def test_the_page_lets_nothing_in_from_elsewhere() -> None:
    page = (WEB / "index.html").read_text("utf-8")
    assert "default-src 'self'" in page and "unsafe" not in page and "://" not in page
