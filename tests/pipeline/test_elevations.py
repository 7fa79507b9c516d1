"""Elevations of a run: drawings that give back the openings, to scale."""

import base64
import json
import re
import shutil
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest

from frontage.exports.elevations import draw_elevation
from frontage.exports.elevations.draw import UNCERTAIN_M
from frontage.exports.survey import SurveyedBuilding
from frontage.geometry.arrays import Float
from frontage.io.drawings.dxf import APP, write_dxf
from frontage.io.drawings.elevation import Elevation, place_on_sheet, sheet_for
from frontage.io.drawings.pdf import MM, write_pdf
from frontage.model import Elements
from frontage.pipeline.stage import Job
from frontage.pipeline.stages import elevations as stage
from frontage.pipeline.store.store import Store
from fronts import scan_wall

TOLERANCE_M = 1e-4
NUMBER = r"-?\d*\.?\d+"


@pytest.fixture(scope="module")
def drawing(simulated_run: Path) -> Any:
    return ezdxf.readfile(simulated_run / "products" / "elevations" / "B01.dxf")


@pytest.fixture(scope="module")
def elevation(simulated_run: Path) -> Elevation:
    store = Store(simulated_run)
    job = Job(store, store.project(), "B01", stage.tasks(Job(store, store.project()))["B01"])
    return stage.work(job, stage.load(job))[0]


@pytest.fixture(scope="module")
def truth(simulated_run: Path) -> dict[str, dict[str, Any]]:
    found = json.loads((simulated_run / "facades" / "B01_F1" / "openings.json").read_text())
    return {o["id"]: o for o in found}


def facts(entity: Any) -> tuple[str, dict[str, float]]:
    """The id and the named values that a line of the drawing carries."""
    (_, name), *pairs = [(tag.code, tag.value) for tag in entity.get_xdata(APP)]
    return name, {pairs[k][1]: pairs[k + 1][1] for k in range(0, len(pairs), 2)}


def test_the_drawing_gives_back_the_openings(drawing: Any, truth: dict[str, Any]) -> None:
    space = drawing.modelspace()
    (outline,) = space.query("LWPOLYLINE[layer=='OUTLINE']")
    _, placed = facts(outline)
    assert placed["shift"] == round(placed["shift"])
    found = {}
    for line in space.query("LWPOLYLINE"):
        if line.dxf.layer.startswith("OPENING_"):
            name, about = facts(line)
            ring = np.array(line.get_points("xy")) - (placed["shift"], placed["zero"])
            np.testing.assert_allclose(ring, truth[name]["outline"], atol=TOLERANCE_M, rtol=0)
            heights = np.array(line.get_points("xy"))[:, 1]
            np.testing.assert_allclose(heights, np.array(truth[name]["outline_world"])[:, 2], atol=2e-3)
            assert about.get("depth") == pytest.approx(truth[name]["depth"], abs=TOLERANCE_M)
            found[name] = line
    assert found.keys() == truth.keys()
    for name, line in found.items():
        sigmas = [truth[name]["sigma"][side] for side in ("left", "bottom", "right", "top")]
        vague = any(s is None or s > UNCERTAIN_M for s in sigmas)
        assert (line.dxf.linetype == "FRONTAGE_DASHED") == vague
        assert line.dxf.layer == f"OPENING_{truth[name]['kind'].upper()}"
    bars = len(space.query("LWPOLYLINE[layer=='BARS']"))
    assert bars == sum(len(o["bars"]["vertical"]) + len(o["bars"]["horizontal"]) for o in truth.values())


def test_the_drawing_is_sound_and_to_scale(drawing: Any, elevation: Elevation, simulated_run: Path) -> None:
    audit = drawing.audit()
    assert not audit.errors and not audit.fixes
    assert drawing.header["$INSUNITS"] == 6
    (image,) = drawing.modelspace().query("IMAGE")
    sidecar = json.loads((simulated_run / "facades" / "B01_F1" / "ortho.json").read_text())
    width = np.linalg.norm(image.dxf.u_pixel) * image.dxf.image_size.x
    assert width == pytest.approx(sidecar["gsd"] * sidecar["width"], rel=1e-9)
    assert (simulated_run / "products" / "elevations" / image.image_def.dxf.filename).is_file()
    layout = drawing.layouts.get("B01_F1 1-50")
    main = [v for v in layout.query("VIEWPORT") if v.dxf.id != 1]
    assert main[0].dxf.view_height / main[0].dxf.height * 1000 == pytest.approx(50)
    lengths = [d.get_measurement() for d in drawing.modelspace().query("DIMENSION")]
    assert lengths == pytest.approx([d.length for d in elevation.dimensions], abs=1e-9)


def polygons(page: bytes) -> list[Float]:
    """The closed paths of a page, in points."""
    text = zlib.decompress(base64.a85decode(page, adobe=False)).decode("latin-1")
    closed = re.findall(rf"((?:{NUMBER} {NUMBER} [ml]\s+)+)h\s+S", text)
    return [np.array(re.findall(rf"({NUMBER}) ({NUMBER}) [ml]", path), np.float64) for path in closed]


def test_the_pdf_measures_as_the_openings_do(
    elevation: Elevation, simulated_run: Path, truth: dict[str, Any]
) -> None:
    pdf = (simulated_run / "products" / "elevations" / "B01.pdf").read_bytes()
    box = re.findall(rb"/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \]", pdf)
    sides = np.array([[float(side) / MM for side in page] for page in box])
    np.testing.assert_allclose(sides, [elevation.sheet.size] * 2, atol=1e-3)
    pages = [p for p in re.findall(rb"stream\r?\n(.*?)~>endstream", pdf, re.S) if polygons_or_none(p)]
    assert len(pages) == 2  # without and with the ortho-image
    at = np.array(place_on_sheet(elevation))
    for page in pages:
        found = polygons(page)
        for record in truth.values():
            ring = np.array(record["outline"]) + np.array([0.0, elevation.zero])
            on_paper = (at + (ring - elevation.bounds[:2]) * 1000 / 50) * MM
            gaps = [np.abs(p - on_paper).max() for p in found if p.shape == on_paper.shape]
            assert min(gaps) / MM * 50 / 1000 < TOLERANCE_M


def polygons_or_none(page: bytes) -> bool:
    try:
        return len(polygons(page)) > 3
    except (ValueError, zlib.error):
        return False


def test_the_levels_are_heights_of_the_openings(elevation: Elevation, truth: dict[str, Any]) -> None:
    named = {level.name: level.height for level in elevation.levels}
    assert named["ground"] < named["top of wall"]
    assert [level.height for level in elevation.levels] == sorted(named.values())
    sills = [
        min(p[2] for p in o["outline_world"])
        for o in truth.values()
        if o["floor"] == 1 and o["kind"] == "window" and o["sigma"]["bottom"] <= UNCERTAIN_M
    ]
    assert named["sill, floor 1"] == pytest.approx(np.median(sills), abs=1e-9)


def test_chains_of_dimensions_add_up(elevation: Elevation) -> None:
    chains: dict[tuple[str, float], list[float]] = {}
    for d in elevation.dimensions:
        chains.setdefault((d.axis, d.at), []).append(d.length)
    for axis in ("x", "h"):
        sums = [sum(lengths) for (own, _), lengths in chains.items() if own == axis]
        assert len(sums) >= 2
    x = [sum(lengths) for (own, _), lengths in chains.items() if own == "x"]
    assert x == pytest.approx([x[-1]] * len(x), abs=2e-3)


@pytest.mark.parametrize(
    ("size", "paper", "scale"), [((8.0, 5.0), "A4", 50), ((30.0, 20.0), "A1", 50), ((90.0, 20.0), "A0", 100)]
)
def test_the_smallest_sheet_that_holds_a_facade(size: Any, paper: str, scale: int) -> None:
    sheet = sheet_for(*size)
    assert (sheet.paper, sheet.scale) == (paper, scale)
    assert sheet.size[0] > size[0] * 1000 / scale and sheet.size[1] > size[1] * 1000 / scale


def test_a_facade_without_openings_and_picture_says_so(tmp_path: Path) -> None:
    facade, _ = scan_wall([])
    building = SurveyedBuilding("B01", "5 Ďáblická", None, None, "", ((facade, None),))
    made = draw_elevation(building, facade, None, None, "above the zero of the scans")
    assert {line.layer for line in made.lines} == {"OUTLINE"}
    assert [text for text in made.title if text.startswith("Left out")] == [
        "Left out: openings, which were not found or not looked for.",
        "Left out: the ortho-image, which there is none of.",
    ]
    write_dxf(tmp_path / "a.dxf", [made, replace(made, facade="B01/F2")])
    write_pdf(tmp_path / "a.pdf", [made], "B01")
    again = ezdxf.readfile(tmp_path / "a.dxf")
    assert not again.audit().errors
    lines = again.modelspace().query("LWPOLYLINE[layer=='OUTLINE']")
    edges = [np.array(line.get_points("xy"))[:, 0] for line in lines]
    assert edges[0].max() < edges[1].min()
    empty = draw_elevation(building, facade, Elements(facade.id, ()), None, "")
    assert not any(text.startswith("Left out: openings") for text in empty.title)


def test_drawings_are_the_same_every_time(simulated_run: Path, tmp_path: Path) -> None:
    out = Path(shutil.copytree(simulated_run, tmp_path / "copy"))
    store = Store(out)
    job = Job(store, store.project(), "B01", stage.tasks(Job(store, store.project()))["B01"])
    stage.save(job, stage.work(job, stage.load(job)))
    for name in ("B01.dxf", "B01.pdf"):
        path = Path("products") / "elevations" / name
        assert (out / path).read_bytes() == (simulated_run / path).read_bytes()
