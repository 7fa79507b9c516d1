"""The stage `crossbars`: bars in openings.json, photos named once, what is kept, and what a failure costs."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

import frontage.pipeline.stages.crossbars as stage
from bar_fakes import COARSE, UNSEEN, stand_in
from facade_fakes import facade
from frontage.cli.main import main
from frontage.crossbars import FoundBars
from frontage.errors import FileError
from frontage.io.photos.photoset import PhotoSet
from frontage.model import Elements, Opening
from frontage.pipeline.project import Project, load_project
from frontage.pipeline.run import run, run_stage
from frontage.pipeline.stage import Job
from frontage.pipeline.store.store import Store
from frontage.queries.runfolder import open_run
from opening_fakes import opening
from pipeline.test_run import Told


@pytest.fixture(scope="module")
def barred(simulated: Path, simulated_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run of the tiny scene with bars of the stand-in, and its scene, in a folder of their own."""
    top = tmp_path_factory.mktemp("barred")
    shutil.copytree(simulated, top / "scene")
    out = Path(shutil.copytree(simulated_run, top / "out"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stage, "find_bars", stand_in)
        run(load_project(top / "scene" / "project.toml", {"crossbars": {"min_pane": 0.13}}), out)
    return top


@pytest.fixture
def copy(barred: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(stage, "find_bars", stand_in)
    out = Path(shutil.copytree(barred / "out", tmp_path / "copy"))
    manifest = json.loads((out / "manifest.json").read_text())
    text = json.dumps(manifest).replace(str(barred / "scene"), str(tmp_path / "scene"))
    (out / "manifest.json").write_text(text)
    shutil.copytree(barred / "scene", tmp_path / "scene")
    return out


def project_of(copy: Path, **changes: dict[str, Any]) -> Project:
    return load_project(copy.parent / "scene" / "project.toml", {"crossbars": {"min_pane": 0.13}} | changes)


def openings(out: Path) -> list[Opening]:
    elements = open_run(out).openings("B01/F1")
    assert elements is not None
    return list(elements.openings)


def pictures(out: Path) -> set[str]:
    return {path.stem for path in (out / "facades" / "B01_F1" / "bars").glob("*.jpg")}


def forbidden(*_: Any) -> FoundBars:
    raise AssertionError("bars are looked for again")


def test_bars_come_into_openings_json_pictures_and_report(barred: Path) -> None:
    out = barred / "out"
    found = openings(out)
    windows = [o for o in found if o.kind == "window"]
    resolved = [o for o in windows if o.glazing is not None and o.glazing.resolved]
    assert resolved and all(len(o.bars) == 2 for o in resolved)
    assert all(o.glazing is None for o in found if o.kind != "window")
    record = next(r for r in json.loads((out / "facades/B01_F1/openings.json").read_text())
                  if r["id"] == resolved[0].id)  # fmt: skip
    (mullion,), (transom,) = record["bars"]["vertical"], record["bars"]["horizontal"]
    assert (mullion["width"], mullion["sigma"], mullion["provenance"]) == (0.06, 0.002, "measured")
    assert transom["sigma_width"] is None and record["glazing"]["frame_width"]["value"] == 0.06
    assert pictures(out) == {o.id.rpartition("/")[2] for o in windows if o.photos}
    told = Store(out).manifest().stages["crossbars"]
    assert told.items == len(resolved)
    assert Store(out).manifest().to_json()["stages"]["crossbars"]["bars"] == 2 * len(resolved)
    page = (out / "report.html").read_text()
    summary = f"Window bars: {len(resolved)} of {len(windows)} windows decided, {2 * len(resolved)} bars"
    assert summary in page and "1 mullion, 1 transom" in page
    assert f'href="facades/B01_F1/bars/{resolved[0].id.rpartition("/")[2]}.jpg"' in page


def test_what_was_not_resolved_is_counted_in_a_note(barred: Path) -> None:
    windows = [o for o in openings(barred / "out") if o.glazing is not None]
    reasons = [o.glazing.note for o in windows if o.glazing is not None and not o.glazing.resolved]
    (note,) = (n for n in Store(barred / "out").manifest().notes if "was not decided" in n)
    assert f"the layout of {len(reasons)} of {len(windows)} windows" in note
    for reason in (COARSE, UNSEEN):
        assert (f"{reasons.count(reason)} x {reason}" in note) == (reason in reasons)
    assert "window bars of B01/F1: a note on all windows" in Store(barred / "out").manifest().notes


def test_many_reasons_are_told_in_one_short_sentence() -> None:
    ids = [f"B01/F1/W1-{k}" for k in range(1, 8)]
    text = stage.unresolved_note({"too dark": ids} | {f"reason {k}": ["B02/F1/W1-1"] for k in range(9)}, 40)
    assert text.startswith(
        "window bars: the layout of 16 of 40 windows was not decided: 7 x too dark (B01/F1/W1-1"
    )
    assert text.endswith("1 x reason 2 (B02/F1/W1-1); 6 for other reasons") and "and 3 more)" in text


def test_another_pixel_size_draws_anew_and_looks_for_nothing(
    copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stage, "find_bars", forbidden)
    monkeypatch.setattr(stage, "name_photos", forbidden)
    before, told = (copy / "facades/B01_F1/openings.json").read_bytes(), Told()
    drawing = (copy / "facades/B01_F1/openings.png").read_bytes()
    run(project_of(copy, ortho={"gsd": 0.08}), copy, progress=told)
    assert told.kept["crossbars"] and not told.kept["ortho"] and not told.kept["drawings"]
    assert (copy / "facades/B01_F1/openings.json").read_bytes() == before
    assert (copy / "facades/B01_F1/openings.png").read_bytes() != drawing
    assert not Store(copy).manifest().warnings


def test_the_drawing_shows_the_bars(copy: Path) -> None:
    path = copy / "facades/B01_F1/openings.png"
    barred = cv2.imread(str(path)).astype(int)
    assert CliRunner().invoke(main, ["crossbars", str(copy), "--method", "none", "-q"]).exit_code == 0
    changed = np.abs(cv2.imread(str(path)).astype(int) - barred).max(2) > 20
    assert 0 < changed.mean() < 0.2


def test_switched_off_windows_keep_their_photos_and_nothing_else(copy: Path) -> None:
    before = {o.id: o.photos for o in openings(copy)}
    run(project_of(copy, crossbars={"method": "none"}), copy)
    assert {o.id: o.photos for o in openings(copy)} == before and any(before.values())
    assert not any(o.glazing or o.bars for o in openings(copy)) and pictures(copy) == set()
    assert not (copy / "facades/B01_F1/bars").exists()
    assert "Window bars" not in (copy / "report.html").read_text()
    assert not any("window bars" in note for note in Store(copy).manifest().notes)


def test_without_photos_the_scan_is_searched(copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = list[Any]()

    def scanned(*given: Any) -> FoundBars:
        asked.append(given)
        return stand_in(*given)

    monkeypatch.setattr(stage, "find_bars", scanned)
    run(project_of(copy).model_copy(update={"photos": None}), copy)
    ((f, elements, photos, _, scan, options),) = asked
    assert photos == [] and len(scan) > f.support.max() and options.min_pane == 0.13
    assert not any(o.photos for o in elements.openings)
    assert {o.glazing.note for o in openings(copy) if o.glazing} == {UNSEEN} and pictures(copy) == set()
    assert f"{len([o for o in openings(copy) if o.glazing])} × {UNSEEN}" in (copy / "report.html").read_text()


def test_pixels_that_cannot_be_read_are_one_sentence_and_change_nothing(
    copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = (copy / "facades/B01_F1/openings.json").read_bytes()

    def unreadable(_: PhotoSet, name: str) -> None:
        raise FileError(name, "cannot be decoded", "copy it again")

    monkeypatch.setattr(PhotoSet, "image", unreadable)
    result = CliRunner().invoke(main, ["crossbars", str(copy)])
    assert result.exit_code == 1 and ".jpg: cannot be decoded" in result.stderr
    assert len(result.stderr.splitlines()) == 1 and "Traceback" not in result.stderr
    assert (copy / "facades/B01_F1/openings.json").read_bytes() == before


@pytest.mark.parametrize(
    "damage", [shutil.rmtree, lambda folder: next(folder.glob("*.jpg")).write_bytes(b"")]
)
def test_photos_that_are_gone_or_damaged_are_told_and_the_scan_remains(
    copy: Path, damage: Callable[[Path], object]
) -> None:
    damage(copy.parent / "scene" / "photos")
    summary = run_stage(copy, "crossbars")
    (note,) = (n for n in summary.notes if "could not be read" in n)
    assert note.startswith("the photos could not be read, openings and bars are without them: ")
    assert not any(o.photos for o in openings(copy)) and not summary.warnings


def test_a_facade_that_fails_keeps_its_openings_and_stops_no_other(monkeypatch: pytest.MonkeyPatch) -> None:
    fronts = tuple((facade(f"B01/F{k}"), Elements(f"B01/F{k}", (opening(f"B01/F{k}/W1-1"),))) for k in (1, 2))
    project = Project.model_validate({"scans": [{"path": "/a.laz"}]})
    job = Job(Store.__new__(Store), project, "B01", stage.Photos(PhotoSet((), {})))

    def failing(f: Any, *given: Any) -> FoundBars:
        if f.id == "B01/F1":
            raise ZeroDivisionError("of all things")
        return stand_in(f, *given)

    broken: list[tuple[str, Callable[..., Any]]] = [("find_bars", failing), ("window_tile", forbidden)]
    for name, function in broken:
        with monkeypatch.context() as patch:
            patch.setattr(stage, "find_bars", stand_in)
            patch.setattr(stage, name, function)
            one, two = stage.work(job, stage.JudgedBuilding(fronts, None, None))
        assert [o.id for o in one.elements.openings] == ["B01/F1/W1-1"]
        assert two.failed is None and two.elements.openings[0].glazing is not None
        assert (one.failed is not None and one.failed.code == "E999") == (name == "find_bars")


def test_a_step_that_fails_costs_a_warning_but_no_openings(
    copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    photos = {o.id: o.photos for o in openings(copy)}

    def broken(*_: Any) -> None:
        raise ZeroDivisionError("of all things")

    for name, kept, glazed in (
        ("name_photos", False, False),
        ("find_bars", True, False),
        ("window_tile", True, True),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(stage, name, broken)
            summary = run_stage(copy, "crossbars")
        assert [(told, w.item, w.code) for told, w in summary.warnings if told == "crossbars"] == [
            ("crossbars", "B01/F1", "E999")
        ]
        assert ({o.id: o.photos for o in openings(copy)} == photos) == kept
        assert any(o.glazing for o in openings(copy)) == glazed and pictures(copy) == set()


def test_locate_tells_the_bars(barred: Path) -> None:
    run_folder = open_run(barred / "out")
    asked = next(o for o in openings(barred / "out") if o.bars)
    found = run_folder.locate(asked.id)
    assert found.glazing is not None and found.glazing.layout == "1 mullion, 1 transom"
    assert (found.glazing.vertical, found.glazing.horizontal) == (1, 1)
    (first, last), wall = found.glazing.bars[0].ends, run_folder.plane("B01/F1")
    xyz = wall.frame.inverse.apply(wall.world.to_local(np.array([first, last])))
    np.testing.assert_allclose(xyz[:, 0], asked.bars[0].position, atol=1e-3)
    np.testing.assert_allclose(xyz[:, 2], asked.bars[0].extent, atol=1e-3)
    np.testing.assert_allclose(xyz[:, 1], 0.15, atol=1e-3)
    words = CliRunner().invoke(main, ["locate", str(barred / "out"), asked.id]).output
    assert "window bars: 1 mullion, 1 transom, sigma at most 0.003 m, confidence 0.97" in words
    table = json.loads(CliRunner().invoke(main, ["locate", str(barred / "out"), asked.id, "--json"]).output)
    assert table["glazing"]["bars"][1]["axis"] == "horizontal"
    lost = next(o for o in openings(barred / "out") if o.glazing and not o.glazing.resolved)
    words = CliRunner().invoke(main, ["locate", str(barred / "out"), lost.id]).output
    assert f"window bars: not resolved: {lost.glazing.note if lost.glazing else ''}" in words
    assert run_folder.locate(lost.id).glazing.vertical is None  # type: ignore[union-attr]


def test_bars_are_chosen_on_the_command_line(copy: Path) -> None:
    scene = copy.parent / "scene" / "project.toml"
    result = CliRunner().invoke(main, ["run", str(scene), "-o", str(copy), "--bars", "none", "--quiet"])
    assert result.exit_code == 0, result.output
    assert Store(copy).project().crossbars.method == "none"
    assert CliRunner().invoke(main, ["crossbars", str(copy), "--method", "guess"]).exit_code == 2
