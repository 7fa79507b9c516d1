"""The stage `openings`: within the chain and alone, by either method, and where a facade cannot be judged."""

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

import frontage.pipeline.stages.drawings as drawings
import frontage.pipeline.stages.openings as stage
from facade_fakes import facade
from frontage.evaluation.metric import Absent
from frontage.model import Building, Failed, OrthoImage
from frontage.openings import FoundOpenings, OpeningOptions, find_openings
from frontage.pipeline.notes import shared_notes
from frontage.pipeline.project import load_project
from frontage.pipeline.run import run, run_stage
from frontage.pipeline.stages.openings import options_at
from frontage.pipeline.store.elements import FOUND, PRODUCT, load_elements
from frontage.pipeline.store.results import OpeningsItemResult
from frontage.pipeline.store.store import Store
from frontage.studies.score import score


@pytest.fixture
def copy(simulated_run: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(simulated_run, tmp_path / "copy"))


def test_the_chain_finds_the_openings_of_the_street(simulated_run: Path, simulated: Path) -> None:
    part = score(simulated_run, simulated).parts["openings"]
    assert not isinstance(part, Absent)
    assert 0.6 < (part.figures["recall_visible_50"].value or 0) <= 1
    assert 0 < (part.figures["border_median"].value or 9) < 0.03
    assert part.figures["bars_exact"].n > 0  # of the windows whose layout was decided
    store = Store(simulated_run)
    (name,) = store.facade_ids("openings")
    found = load_elements(store.facade_folder(name), name)
    assert [o.id.split("/")[1] for o in found.openings] == ["F1"] * len(found.openings)
    assert store.manifest().stages["openings"].items == len(found.openings) > 3


def test_the_stage_alone_takes_the_method(copy: Path) -> None:
    store = Store(copy)
    (name,) = store.facade_ids("openings")
    path = store.facade_folder(name) / "openings.json"
    before = path.read_bytes()
    run_stage(copy, "openings", options={"method": "paper"})
    assert path.read_bytes() != before
    assert any("method 'paper'" in note for note in store.manifest().notes)
    assert pictures(path.parent) == {"openings", "evidence", "cells_before", "cells"}
    run_stage(copy, "openings", options={"method": "evidence"})
    assert path.read_bytes() == before
    assert pictures(path.parent) == {"openings", "evidence"}


def pictures(folder: Path) -> set[str]:
    return {path.stem for path in folder.glob("*.png")}


def test_openings_without_an_ortho_image_are_drawn_on_the_evidence(copy: Path) -> None:
    store = Store(copy)
    (name,) = store.facade_ids("openings")
    folder = store.facade_folder(name)
    photograph = cv2.imread(str(folder / "openings.png"))
    (copy / ".done" / "ortho.B01.json").unlink()
    run_stage(copy, "openings")
    drawn, evidence = (cv2.imread(str(folder / f"{stem}.png")) for stem in ("openings", "evidence"))
    assert drawn.shape == evidence.shape != photograph.shape
    assert 0.5 < (drawn == evidence).all(2).mean() < 1.0


def test_another_pixel_size_draws_openings_anew_and_finds_none(
    copy: Path, simulated: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = Store(copy).facade_folder("B01/F1")
    kept = {
        path.name: path.read_bytes()
        for path in folder.iterdir()
        if path.name in (*FOUND, PRODUCT, "evidence.png")
    }
    before = cv2.imread(str(folder / "openings.png"))
    monkeypatch.setattr(stage, "find_openings", None)
    run(load_project(simulated / "project.toml", {"ortho": {"gsd": 0.08}}), copy)
    assert {name: (folder / name).read_bytes() for name in kept} == kept and len(kept) == 5
    assert cv2.imread(str(folder / "openings.png")).shape != before.shape
    assert not Store(copy).manifest().warnings


def test_photos_serve_where_the_scans_do_not_tell_how_walls_look(
    copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    marker = copy / ".done" / "scans.json"
    told = json.loads(marker.read_text())
    assert told["result"]["looks"]
    pictures_of: list[OrthoImage | None] = []

    def find(*given: Any) -> FoundOpenings | Failed:
        pictures_of.append(given[3])
        return find_openings(*given)

    monkeypatch.setattr(stage, "find_openings", find)
    run_stage(copy, "openings")
    assert pictures_of and not any(pictures_of)
    told["result"]["looks"] = False
    marker.write_text(json.dumps(told))
    run_stage(copy, "openings")
    assert pictures_of[-1] is not None and pictures_of[-1].photos > 0


def test_photos_that_are_taken_away_are_named_no_more(copy: Path, simulated: Path) -> None:
    run(load_project(simulated / "project.toml").model_copy(update={"photos": None}), copy)
    openings = load_elements(Store(copy).facade_folder("B01/F1"), "B01/F1").openings
    assert openings and not any(o.photos for o in openings)


def test_a_picture_that_cannot_be_drawn_costs_no_openings(
    copy: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def broken(*_: Any) -> None:
        raise ZeroDivisionError("of all things")

    caplog.set_level("INFO", "frontage")  # what -v asks for

    monkeypatch.setattr(drawings, "opening_picture", broken)
    monkeypatch.setattr(stage, "evidence_pictures", broken)
    summary = run_stage(copy, "openings")
    assert [(stage, w.code) for stage, w in summary.warnings] == [("openings", "E999"), ("drawings", "E999")]
    assert "of all things" in caplog.text and "Traceback" in caplog.text
    (name,) = Store(copy).facade_ids("openings")
    folder = Store(copy).facade_folder(name)
    assert (folder / "openings.json").is_file() and pictures(folder) == set()


def test_a_facade_that_cannot_be_judged_is_a_warning_and_leaves_no_files(
    copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (name,) = Store(copy).facade_ids("openings")
    folder = Store(copy).facade_folder(name)

    def few(*_: Any) -> Failed:
        return Failed("F401", "too few points", "scan again")

    def broken(*_: Any) -> Failed:
        raise ZeroDivisionError("of all things")

    for found, code in ((few, "F401"), (broken, "E999")):
        monkeypatch.setattr(stage, "find_openings", found)
        summary = run_stage(copy, "openings")
        told = [(w.item, w.code) for _, w in summary.warnings]
        assert told == [(name, code)]
        assert Store(copy).facade_ids("openings") == [] and not any(
            (folder / file).exists() for file in (*FOUND, PRODUCT)
        )
        assert pictures(folder) == set()


def test_the_ground_is_told_in_the_facade_s_own_frame() -> None:
    f = facade(lean=0.05)
    building = Building("B01", np.arange(3), ground_z=12.5)
    z = options_at(f, building, OpeningOptions()).ground_z
    assert z is not None
    assert f.frame.apply(np.array([[3.0, 0.0, z]]))[0, 2] == pytest.approx(12.5, abs=1e-12)
    assert options_at(f, building, OpeningOptions(ground_z=0.25)).ground_z == 0.25
    unknown = replace(building, ground_z=float("inf"))
    assert options_at(f, unknown, OpeningOptions()).ground_z is None


def test_notes_are_told_once_with_their_facades() -> None:
    results = [
        OpeningsItemResult(notes={"B01/F1": ("sensors unknown", "facade B01/F1: too dark")}),
        OpeningsItemResult(notes={f"B02/F{k}": ("sensors unknown",) for k in range(1, 6)}),
    ]
    assert shared_notes(results) == [
        "openings of B01/F1, B02/F1, B02/F2, B02/F3 and 2 more: sensors unknown",
        "openings of B01/F1: too dark",
    ]
