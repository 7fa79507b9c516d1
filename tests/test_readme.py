"""Every command that the README shows runs, on a smaller street, and prints lines of the kind it shows."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from frontage.cli.main import main
from frontage.simulate.spec import SceneSpec, parse_spec
from frontage.studies.demo import SPEC
from frontage.studies.simulate import simulate

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text("utf-8")
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), ROOT / "CONTRIBUTING.md"]


def console() -> list[tuple[str, list[str]]]:
    """The commands of the tour with the output shown under each."""
    out: list[tuple[str, list[str]]] = []
    for block in re.findall(r"```console\n(.*?)```", README, re.S):
        for line in block.splitlines():
            if line.startswith("$ "):
                out.append((line[2:], []))
            else:
                out[-1][1].append(line)
    return out


def kind(line: str) -> str:
    """A line with its numbers taken out: what must be the same on any street."""
    line = re.sub(r"\[.*?\]  n = ", "", line)  # a figure of a single item has no interval
    words = re.sub(r"B\d\d(?:/F\d)?|[\d.,:\s-]+", " ", line).split()
    return " ".join(word for word in words if word not in ("relief", "plane", "measured", "pooled"))


def printed_by(command: list[str]) -> str:
    """What a command of ours prints. Other tests start the program as a process of its own, as users do."""
    assert command[0] == "frontage"
    done = CliRunner().invoke(main, command[1:])
    assert done.exit_code == 0, f"{command}: {done.output}"
    return done.output


def coarse_demo() -> SceneSpec:
    """The street of the demo, measured coarsely."""
    spec = parse_spec(SPEC)
    scanner = spec.scanners[0].model_copy(update={"spacing": 0.09, "subrays": 1})
    camera = spec.cameras[0].model_copy(update={"width": 300, "height": 360, "samples": 1, "most": 2})
    output = spec.output.model_copy(update={"gsd": 0.04})
    return spec.model_copy(update={"scanners": (scanner,), "cameras": (camera,), "output": output})


def test_the_tour_runs_and_prints_what_it_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    simulate(coarse_demo(), tmp_path / "demo-out" / "street")
    commands = console()
    assert len(commands) >= 5
    for command, shown in commands:
        printed = {kind(line) for line in printed_by(shlex.split(command)).splitlines()}
        missing = [line for line in shown if kind(line) not in printed]
        assert not missing, f"{command} no longer prints {missing}; it printed {sorted(printed)}"
    (snippet,) = re.findall(r"```python\n(.*?)```", README, re.S)
    done = subprocess.run([sys.executable, "-c", snippet], capture_output=True, text=True, check=True)
    assert float(done.stdout.split()[0]) == pytest.approx(4.0, abs=0.05)


def test_the_make_targets_that_are_shown_exist() -> None:
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.M))
    for page in PAGES:
        assert set(re.findall(r"^make ([a-z]+)", page.read_text("utf-8"), re.M)) <= targets, page.name
    assert {"demo", "test"} <= set(re.findall(r"^make ([a-z]+)", README, re.M))


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text("utf-8")):
        if "://" not in target:
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_every_page_is_in_the_navigation() -> None:
    listed = set(re.findall(r"([\w/-]+\.md)$", (ROOT / "mkdocs.yml").read_text("utf-8"), re.M))
    assert listed == {page.relative_to(ROOT / "docs").as_posix() for page in PAGES[1:-1]}


def test_commands_on_the_pages_use_flags_that_exist() -> None:
    """Data for the commands of docs/guides/real-data.md may be absent; their flags must be known anyway."""
    from frontage.cli.run import command

    known = {option for parameter in command.params for option in parameter.opts}
    text = (ROOT / "docs" / "guides" / "real-data.md").read_text("utf-8")
    lines = re.findall(r"^frontage run .*$", text, re.M)
    assert len(lines) >= 7
    for line in lines:
        flags = {word for word in line.split() if word.startswith("-")}
        assert flags <= known, line


def test_the_picture_is_small() -> None:
    (name,) = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README)
    assert 20_000 < (ROOT / name).stat().st_size < 300_000
