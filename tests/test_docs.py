"""The generated parts of the documentation are complete, and no page loads anything from the network."""

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def generate() -> ModuleType:
    spec = importlib.util.spec_from_file_location("generate", DOCS / "_site" / "generate.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_marked_section_has_a_generator_and_every_generator_a_page(generate: ModuleType) -> None:
    marked: list[str] = []
    for page in DOCS.rglob("*.md"):
        marked += re.findall(r"^\{\{ generated: (\S+) \}\}$", page.read_text("utf-8"), re.M)
    assert sorted(marked) == sorted(generate.SECTIONS)


def test_the_command_line_reference_names_every_command_and_flag(generate: ModuleType) -> None:
    from frontage.cli.main import COMMANDS

    text = generate.command_line()
    assert [f"## frontage {name}" for name in COMMANDS] == re.findall(r"^## .*$", text, re.M)
    for flag in ("--photo-offset", "--max-offset", "--require", "--floor", "--snap-tol"):
        assert f"`{flag}`" in text


def test_the_project_reference_describes_every_key(generate: ModuleType) -> None:
    text = generate.project_file()
    assert "## `[[scans]]`" in text and "| `gsd` | number | `0.01` |" in text
    rows = [line.split(" | ") for line in text.splitlines() if line.startswith("| `")]
    assert len(rows) > 60
    undescribed = [row[0] for row in rows if len(row[-1].strip(" |")) < 5]
    assert not undescribed


def test_the_reference_of_codes_explains_every_code(generate: ModuleType) -> None:
    pytest.importorskip("frontage.errors.codes")
    text = generate.error_codes()
    for code in ("F101", "I103", "R201", "S310", "W100", "X100"):
        assert f">{code}</span> | " in text
    linked = {
        code
        for page in DOCS.rglob("*.md")
        for code in re.findall(r"errors\.md#(\w+)", page.read_text("utf-8"))
    }
    assert linked <= set(re.findall(r'<span id="(\w+)">', text))


def test_the_gallery_shows_what_every_example_printed(generate: ModuleType) -> None:
    text = generate.examples()
    scripts = sorted((ROOT / "examples").glob("plot_*.py"))
    assert text.count("## ") >= len(scripts) >= 4
    for script in scripts:
        printed = (DOCS / "_site" / "outputs" / f"{script.stem}.txt").read_text("utf-8")
        assert len(printed.splitlines()) >= 3 and printed.rstrip() in text


def test_pages_load_nothing_from_the_network() -> None:
    config = (ROOT / "mkdocs.yml").read_text("utf-8")
    assert "font: false" in config and "://" not in config
    for page in DOCS.rglob("*.md"):
        assert not re.search(r"(?:!\[[^\]]*\]\(|src=.?)https?:", page.read_text("utf-8")), page


def test_equations_are_balanced() -> None:
    """An odd number of dollar signs outside code would turn text into an equation."""
    for page in DOCS.rglob("*.md"):
        text = re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text("utf-8"), flags=re.S)
        assert text.count("$") % 2 == 0, page
