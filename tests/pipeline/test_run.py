"""The run folder: complete, resumable at any point, the same bytes at any number of workers."""

import hashlib
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from frontage.errors import FileError, InputError, WorkspaceError
from frontage.io.rasters.ortho import read_ortho, write_ortho
from frontage.model import Failed
from frontage.pipeline.project import load_project
from frontage.pipeline.run import run, run_stage
from frontage.pipeline.stages import buildings, export, facades, ortho, report
from frontage.pipeline.store import elements as elementfiles
from frontage.pipeline.store import store as storage
from frontage.pipeline.store.store import Store
from frontage.queries.runfolder import open_run


class Told:
    """Remembers which stages were kept."""

    def __init__(self) -> None:
        self.kept: dict[str, bool] = {}

    def begin(self, stage: str, total: int) -> None: ...

    def advance(self, stage: str) -> None: ...

    def end(self, stage: str, seconds: float, kept: bool, items: int) -> None:
        self.kept[stage] = kept


@pytest.fixture
def finished(pair_run: Path) -> Path:
    return pair_run


def contents(out: Path) -> dict[str, str]:
    """Every file's hash but the manifest's, which holds timings."""
    files = (p for p in sorted(out.rglob("*")) if p.is_file() and p.name != "manifest.json")
    return {str(p.relative_to(out)): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def test_a_run_leaves_what_the_design_names(finished: Path) -> None:
    facade = Store(finished).facade_ids()[0].replace("/", "_")
    for name in (
        "manifest.json",
        "report.html",
        "model/facades.glb",
        "model/facades.obj",
        "model/lod3.city.json",
        "model/lod3.gml",
        "model/lod3_citygml3.gml",
        "model/lod3.glb",
        "model/report.json",
        "model/pictures/B01.png",
        "buildings/B01.laz",
    ):
        assert (finished / name).stat().st_size > 0, name
    for name in ("ortho.tif", "ortho.json", "depth.tif", "sources.tif", "ortho.jpg", "facade.json",
                 "openings.json", "protrusions.json", "openings.png", "evidence.png"):  # fmt: skip
        assert (finished / "facades" / facade / name).stat().st_size > 0, name
    assert not list(finished.rglob("*.part"))
    manifest = json.loads((finished / "manifest.json").read_text())
    assert manifest["seed"] == 0 and manifest["world"]["crs"] == "EPSG:25832"
    assert len(manifest["inputs"]["photos"]) >= 4  # two photos, cameras.txt, images.txt
    assert all(len(entry["sha256"]) == 64 for group in manifest["inputs"].values() for entry in group)
    assert {"seconds", "key", "items"} <= manifest["stages"]["ortho"].keys()
    assert manifest["project"]["ortho"]["gsd"] == 0.04


def test_two_workers_give_the_same_bytes(finished: Path, project: Path, tmp_path: Path) -> None:
    run(load_project(project), tmp_path / "two", workers=2)
    assert contents(tmp_path / "two") == contents(finished)


def test_a_second_run_keeps_everything(finished: Path, project: Path, tmp_path: Path) -> None:
    out, told = tmp_path / "out", Told()
    shutil.copytree(finished, out)
    run(load_project(project), out, progress=told)
    assert told.kept and all(told.kept.values())
    assert contents(out) == contents(finished)


def test_a_changed_option_redoes_its_stage_and_what_follows(
    finished: Path, project: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    shutil.copytree(finished, out)
    told = Told()
    run(load_project(project, {"ortho": {"gsd": 0.08}}), out, progress=told)
    assert told.kept == {
        "scans": True, "buildings": True, "facades": True, "ortho": False, "openings": True,
        "crossbars": True, "drawings": False, "model": False,
        "export": False, "tables": False, "elevations": False, "bim": True, "qgis": False,
        "report": False,
    }  # fmt: skip
    facade = Store(out).facade_ids()[0]
    assert open_run(out).facade(facade).sidecar.gsd == 0.08


class _Killed(BaseException):
    """Stands for SIGKILL: nothing in between catches it."""


def killed_at(call: int, true: Callable[..., Any]) -> Callable[..., Any]:
    """`true`, but the process dies at the given call (1 = the first)."""
    calls: list[int] = []

    def dying(*args: Any) -> Any:
        calls.append(1)
        if len(calls) == call:
            raise _Killed
        return true(*args)

    return dying


def test_a_run_killed_again_and_again_comes_to_the_same_result(
    finished: Path, project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    deaths: list[tuple[Any, str, int]] = [
        (storage, "save_scan", 1),
        (buildings, "find_buildings", 1),
        (storage, "write_las", 1),
        (storage, "write_las", 2),
        (storage, "save_facade", 1),
        (storage, "save_facade", 2),
        (storage, "write_ortho", 1),
        (storage, "write_ortho", 2),
        (elementfiles, "save_elements", 1),
        (elementfiles, "save_elements", 2),
        (elementfiles, "save_product", 1),
        (export, "write_glb", 1),
        (export, "write_obj", 1),
        (report, "render_report", 1),
    ]
    for module, name, call in deaths:
        with monkeypatch.context() as patch:
            patch.setattr(module, name, killed_at(call, getattr(module, name)))
            with pytest.raises(_Killed):
                run(load_project(project), out)
        if name == "write_ortho" and call == 2:
            assert list((out / ".done").glob("ortho.B*.json"))  # the building before is not done again
    run(load_project(project), out)
    assert contents(out) == contents(finished)


def test_a_building_that_fails_is_a_warning_with_its_code(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    true = facades.find_facades

    def picky(scan: Any, building: Any, *rest: Any) -> Any:
        if building.id == "B01":
            return (Failed("F199", "no wall here", "look elsewhere"),)
        return true(scan, building, *rest)

    def broken(facade: Any, *rest: Any) -> Any:
        raise ZeroDivisionError("of all things")

    monkeypatch.setattr(facades, "find_facades", picky)
    summary = run(load_project(project), tmp_path / "a")
    assert [w.code for _, w in summary.warnings] == ["F199"] and summary.facades
    assert "no wall here" in (tmp_path / "a" / "report.html").read_text()
    monkeypatch.setattr(ortho, "make_ortho", broken)
    with pytest.raises(Exception, match="no ortho-image could be made"):
        run(load_project(project), tmp_path / "b")
    assert any(w.code == "E999" for _, w in Store(tmp_path / "b").manifest().warnings)


def test_an_ortho_image_that_cannot_be_made_again_is_gone_whole(
    finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    shutil.copytree(finished, out)
    folder = Store(out).facade_folder(Store(out).facade_ids()[0])
    write_ortho(tmp_path / "alone", read_ortho(folder))
    written = {path.name for path in (tmp_path / "alone").iterdir()}
    assert {"ortho.json", "gsd.tif"} <= written <= {path.name for path in folder.iterdir()}
    monkeypatch.setattr(ortho, "make_ortho", lambda *_: Failed("F399", "too dark", "wait for the day"))
    run_stage(out, "ortho")
    assert Store(out).facade_ids("ortho") == []
    assert not written & {path.name for path in folder.iterdir()} and (folder / "facade.json").is_file()


def test_a_bad_photo_leaves_earlier_results_intact(finished: Path, project: Path, tmp_path: Path) -> None:
    inputs, out = tmp_path / "in", tmp_path / "out"
    shutil.copytree(project.parent, inputs)
    shutil.copytree(finished, out)
    run(load_project(inputs / project.name), out)  # the same files elsewhere: little is made again
    before = contents(out)
    photo = next((inputs / "photos").glob("*.jpg"))
    photo.write_bytes(photo.read_bytes()[:500])
    with pytest.raises(FileError, match=photo.name):
        run(load_project(inputs / project.name), out)
    assert contents(out) == before


def test_a_stage_alone_takes_options_and_refuses_what_is_not_ready(finished: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(finished, out)
    summary = run_stage(out, "ortho", options={"gsd": 0.1})
    assert summary.facades == tuple(Store(out).facade_ids())
    assert open_run(out).facade(summary.facades[0]).sidecar.gsd == 0.1
    run_stage(out, "buildings")
    run_stage(out, "facades")
    assert Store(out).facade_ids("ortho") == []  # they showed other planes
    assert Store(out).facade_ids("openings") == [] and not list((out / "facades").rglob("openings.json"))
    (out / ".done" / "facades.json").unlink()
    with pytest.raises(WorkspaceError, match="'facades' is not finished"):
        run_stage(out, "ortho")
    with pytest.raises(InputError, match="gsd"):
        run_stage(out, "ortho", options={"gsd": -1})


def test_buildings_that_are_gone_take_their_files_along(
    finished: Path, project: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    shutil.copytree(finished, out)
    before = {record.id for record in Store(out).building_records()}
    assert len(before) > 1
    run(load_project(project, {"buildings": {"split": False}}), out)
    after = {record.id for record in Store(out).building_records()}
    assert len(after) < len(before)
    for gone in before - after:
        assert not list(out.rglob(f"{gone}*"))


def test_pixels_and_world_round_trip_on_relief_and_plane(finished: Path) -> None:
    pixels = open_run(finished).facade(Store(finished).facade_ids()[0])
    w, h = pixels.size
    cr = np.random.default_rng(1).uniform(0, 1, (200, 2)) * (w, h)
    for relief in (True, False):
        xyz, y, used = pixels.world_from_pixels(cr, relief)
        back, depth = pixels.pixels_from_world(xyz)
        assert np.abs(back - cr).max() < 1e-6
        assert np.abs(depth - y).max() < 1e-7
        assert used.any() == relief
    rows, columns = np.nonzero(np.isfinite(pixels.depth))
    k = len(rows) // 2
    point = pixels.pixel_to_world(columns[k] + 0.5, rows[k] + 0.5)
    assert point.surface == "relief" and point.depth == pytest.approx(
        float(pixels.depth[rows[k], columns[k]])
    )
    back = pixels.world_to_pixel(point.x, point.y, point.z)
    assert (back.column, back.row) == pytest.approx(
        (columns[k] + 0.5, rows[k] + 0.5), abs=1e-6
    ) and back.inside
    assert pixels.pixel_to_world(columns[k] + 0.5, rows[k] + 0.5, relief=False).surface == "plane"
    with pytest.raises(InputError, match="outside"):
        pixels.pixel_to_world(w + 1, 0)


def test_an_unknown_facade_is_told_with_the_known_ones(finished: Path) -> None:
    with pytest.raises(InputError, match=r"B99/F1.*known: B01/F1"):
        open_run(finished).facade("B99/F1")
    assert open_run(finished).facade("B01_F1").size == open_run(finished).facade("B01/F1").size
