"""Lost, cut and flipped result files are noticed and made again with the same bytes."""

import hashlib
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from frontage.pipeline.graph import Graph
from frontage.pipeline.inputs import hash_inputs
from frontage.pipeline.project import load_project
from frontage.pipeline.run import run
from frontage.pipeline.stages import STAGES
from frontage.pipeline.store.store import Store


def delete(path: Path) -> None:
    path.unlink()


def truncate(path: Path) -> None:
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])


def flip(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0x10
    path.write_bytes(bytes(data))


DAMAGES = pytest.mark.parametrize("damage", [delete, truncate, flip])


@pytest.fixture
def copy(simulated_run: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(simulated_run, tmp_path / "copy"))


def results(out: Path) -> list[Path]:
    """Every file of a run but the manifest and the markers."""
    files = (p for p in sorted(out.rglob("*")) if p.is_file() and ".done" not in p.parts)
    return [p for p in files if p.name != "manifest.json"]


def contents(out: Path) -> dict[str, str]:
    return {str(p.relative_to(out)): hashlib.sha256(p.read_bytes()).hexdigest() for p in results(out)}


def graph_of(out: Path, project: Path) -> Graph:
    loaded = load_project(project)
    return Graph(STAGES, Store(out), loaded, hash_inputs(loaded))


def not_kept(graph: Graph, thorough: bool) -> list[str]:
    """The stages that would be done again."""
    needed = (stage for stage in STAGES if stage.needed(graph.project))
    return [stage.name for stage in needed if graph.kept(stage, thorough=thorough) is None]


def damaged(out: Path, damage: Callable[[Path], None]) -> Iterator[Path]:
    """Damage one file after the other; each is put back afterwards."""
    for path in results(out):
        whole = path.read_bytes()
        damage(path)
        yield path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(whole)


@DAMAGES
def test_the_damage_of_any_single_file_is_noticed(
    copy: Path, simulated: Path, damage: Callable[[Path], None]
) -> None:
    graph = graph_of(copy, simulated / "project.toml")
    assert not_kept(graph, thorough=True) == []
    noticed = 0
    for path in damaged(copy, damage):
        assert len(not_kept(graph, thorough=damage is flip)) == 1, path
        noticed += 1
    assert noticed > 30
    assert not_kept(graph, thorough=True) == []


@DAMAGES
def test_what_is_damaged_is_made_again_with_the_same_bytes(
    copy: Path, simulated: Path, damage: Callable[[Path], None]
) -> None:
    before = contents(copy)
    for path in results(copy)[::2]:
        damage(path)
    assert contents(copy) != before
    run(load_project(simulated / "project.toml"), copy, verify=damage is flip)
    assert contents(copy) == before


def test_files_that_a_killed_run_left_half_written_are_removed(copy: Path, simulated: Path) -> None:
    before = contents(copy)
    torn = copy / "facades" / "B01_F1" / ".ortho.tif.7583.part"
    torn.write_bytes(b"half")
    run(load_project(simulated / "project.toml"), copy)
    assert not torn.exists() and contents(copy) == before


def test_a_whole_facade_folder_that_is_gone_is_made_again(copy: Path, simulated: Path) -> None:
    before = contents(copy)
    shutil.rmtree(copy / "facades" / "B01_F1")
    run(load_project(simulated / "project.toml"), copy)
    assert contents(copy) == before


@pytest.mark.parametrize("text", ["", "{", "[]", '{"stages": 3}'])
def test_a_damaged_manifest_is_written_anew_and_nothing_is_lost(
    copy: Path, simulated: Path, text: str
) -> None:
    before = contents(copy)
    (copy / "manifest.json").write_text(text)
    run(load_project(simulated / "project.toml"), copy)
    assert contents(copy) == before
    assert Store(copy).manifest().stages["openings"].items > 0


def test_an_unreadable_intermediate_ends_the_stage_and_deletes_nothing(copy: Path) -> None:
    from frontage.errors import FileError
    from frontage.pipeline.run import run_stage

    points = copy / "facades" / "B01_F1" / "points.npz"
    points.write_bytes(b"x" * points.stat().st_size)
    before = contents(copy)
    with pytest.raises(FileError, match=r"points\.npz"):
        run_stage(copy, "ortho")
    assert contents(copy) == before


def test_a_moved_project_and_run_stay_current(simulated: Path, simulated_run: Path, tmp_path: Path) -> None:
    scene = Path(shutil.copytree(simulated, tmp_path / "elsewhere" / "scene"))
    out = Path(shutil.copytree(simulated_run, tmp_path / "there"))
    assert not_kept(graph_of(out, scene / "project.toml"), thorough=True) == []
