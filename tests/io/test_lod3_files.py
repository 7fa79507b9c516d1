"""LoD3 files are valid by their schemas and hold the same buildings when they are read back."""

import importlib.util
import json
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from lxml import etree

from facade_fakes import WORLD
from frontage.exports.lod3 import city_building
from frontage.io.citymodels.citygml.write import write_citygml
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.io.citymodels.info import city_model_info
from frontage.io.citymodels.openings import read_city_openings
from frontage.io.citymodels.read import read_city_model
from frontage.io.shapes.read import read_shapes
from frontage.model import Building, Elements
from frontage.model.citymodel import CityBuilding
from frontage.solids import BuildOptions, assemble
from frontage.validation import validate_feature
from opening_fakes import opening, round_door
from realdata import citygml_schema, data_path
from solids.test_assemble import GROUND, protrusion, wall, window

CJIO = Path(sys.executable).with_name("cjio")


def lod3(name: str = "B01", bars: bool = True) -> CityBuilding:
    """A house with two windows, one of them on an oriel, a flush round door, a balcony and an awning."""
    elements = Elements(
        "B01/F1",
        (opening(), window("B01/F1/W1-2", (2.2, 0, 3.8, 1.5), 0.2), round_door()),
        (
            protrusion("oriel", (2, -1, 4, 2), -0.8),
            protrusion("balcony", (-3.5, -1.5, -1.5, -0.4), -1.0),
            protrusion("awning", (-4, -2, 0, -1.6), -1.2),
        ),
    )
    building = Building(name, np.arange(3), GROUND, "13 rue Soufflot")
    made = assemble(building, [(wall(), elements)], (), WORLD, BuildOptions(bars=bars))
    assert made
    return city_building(building, made, [(wall(), elements)])


def written(folder: Path, kind: str, bars: bool = True) -> Path:
    houses = [lod3(bars=bars)]
    if kind == "city.json":
        return write_cityjson(folder / "lod3.city.json", houses, WORLD, "one house")
    return write_citygml(folder / "lod3.gml", houses, WORLD, "one house", "2.0" if kind == "gml2" else "3.0")


KINDS = ["city.json", "gml2", "gml3"]


@pytest.mark.parametrize("kind", KINDS)
def test_written_models_are_read_back(tmp_path: Path, kind: str) -> None:
    model = read_city_model(written(tmp_path, kind), WORLD)
    (read,), wrote = model.buildings, lod3()
    assert model.problems == model.notes == ()
    assert (read.id, read.address) == ("B01", "13 rue Soufflot")
    assert read.attributes["host"] == "cloud" and read.attributes["measuredHeight"] == 6.2
    assert sorted((s.lod, s.closed, s.installation) for s in read.shells) == sorted(
        (s.lod, s.closed, s.installation) for s in wrote.shells
    )
    hanging = [s for s in read.shells if s.installation and not s.frame_of]
    assert [s.attributes["kind"] for s in hanging] == ["balcony", "awning"]
    for one, other in zip(*(sorted(b.shells, key=_order) for b in (wrote, read)), strict=True):
        rings = [{_key(s.ring): s.semantics for s in shell.surfaces} for shell in (one, other)]
        assert rings[0] == rings[1]


def _order(shell) -> tuple:
    return shell.lod, shell.installation, len(shell.surfaces), round(shell.surfaces[0].ring.mean(), 2)


def _key(ring: np.ndarray) -> tuple:
    return tuple(sorted(map(tuple, np.rint(ring * 1e4).astype(int).tolist())))


@pytest.mark.parametrize("kind", KINDS)
def test_openings_keep_their_attributes(tmp_path: Path, kind: str) -> None:
    found = {
        o.about["id"] if kind == "city.json" else _named(o): o
        for o in read_city_openings(written(tmp_path, kind))
    }
    assert set(found) == {"B01/F1/W1-1", "B01/F1/W1-2", "B01/F1/D0-1"}
    a = found["B01/F1/W1-1"].about
    assert (a["depth"], a["sigma_depth"], a["n_vertical"], a["n_horizontal"]) == (0.12, 0.007, 1, 1)
    assert (a["provenance"], a["confidence"], a["floor"], a["kind"]) == ("measured", 0.9375, 1, "window")
    assert 0.003 < a["sigma_border"] < 0.006 and a["offset"] == pytest.approx(0, abs=1e-3)
    door = found["B01/F1/D0-1"]
    assert door.kind == "Door" and "depth" not in door.about and door.about["provenance"] == "inferred"
    parents = {o.about["parent"] for o in found.values()}
    assert len(parents) == 2, "the window of the oriel stands in the oriel's front"


def _named(opening) -> str:
    clean = opening.about["surface"]
    return {"B01_F1_W1-1": "B01/F1/W1-1", "B01_F1_W1-2": "B01/F1/W1-2", "B01_F1_D0-1": "B01/F1/D0-1"}[clean]


@pytest.mark.parametrize("kind", KINDS)
def test_written_solids_are_valid(tmp_path: Path, kind: str) -> None:
    _, features = read_shapes(written(tmp_path, kind))
    assert sum(len(f.shapes) for whole in features for f in (whole, *whole.parts)) >= 4
    assert [v for f in features for v in validate_feature(f)] == []


def test_cityjson_is_valid_by_its_schema_and_openings_have_parents(tmp_path: Path) -> None:
    import jsonschema

    model = json.loads(written(tmp_path, "city.json").read_text())
    house = model["CityObjects"]["B01"]
    assert [g["lod"] for g in house["geometry"]] == ["2", "3"]
    surfaces = house["geometry"][1]["semantics"]["surfaces"]
    for number, s in enumerate(surfaces):
        if s["type"] in ("Window", "Door"):
            wall_of = surfaces[s["parent"]]
            assert wall_of["type"] == "WallSurface" and number in wall_of["children"]
    types = [model["CityObjects"][name]["type"] for name in house["children"]]
    assert types == ["BuildingInstallation"] * 2 + ["BuildingConstructiveElement"] * 2
    schema = json.loads(data_path("schemas/cityjson/cityjson.min.schema.json").read_text())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        jsonschema.validate(model, schema)


@pytest.mark.parametrize(
    ("kind", "modules"), [("gml2", ("building", "generics")), ("gml3", ("building", "generics"))]
)
def test_citygml_is_valid_by_its_schema(tmp_path: Path, kind: str, modules: tuple[str, ...]) -> None:
    version = "2.0" if kind == "gml2" else "3.0"
    schema = citygml_schema(tmp_path, version, modules)
    tree = etree.parse(str(written(tmp_path, kind)))
    assert schema.validate(tree), schema.error_log.last_error
    solid = next(e for e in tree.iter() if str(e.tag).endswith("lod3Solid"))
    solid.getparent().append(solid)  # out of its place in the sequence
    assert not schema.validate(tree)


@pytest.mark.parametrize("kind", KINDS)
def test_window_frames_are_objects_of_their_own(tmp_path: Path, kind: str) -> None:
    (read,) = read_city_model(written(tmp_path, kind), WORLD).buildings
    frames = {s.frame_of: s for s in read.shells if s.frame_of}
    assert set(frames) == {"B01/F1/W1-1", "B01/F1/W1-2"}
    one = frames["B01/F1/W1-1"]
    assert not one.closed and one.installation and {s.semantics for s in one.surfaces} == {""}
    assert max(len(s.holes) for s in one.surfaces) == 4
    about = one.attributes
    assert (about["kind"], about["n_vertical"], about["frame_width"]) == ("window frame", 1, 0.07)
    assert city_model_info(written(tmp_path, kind))["window_frames"] == 2


@pytest.mark.parametrize("kind", KINDS)
def test_without_frames_the_counts_stay(tmp_path: Path, kind: str) -> None:
    (read,) = read_city_model(written(tmp_path, kind, bars=False), WORLD).buildings
    assert not any(s.frame_of for s in read.shells)
    counts = [a["n_vertical"] for s in read.shells for a in s.about.values() if "n_vertical" in a]
    assert counts == [1, 1]


def test_citygml_3_relates_frames_to_their_windows(tmp_path: Path) -> None:
    tree = etree.parse(str(written(tmp_path, "gml3")))
    href = "{http://www.w3.org/1999/xlink}href"
    ids = {e.get("{http://www.opengis.net/gml/3.2}id"): e for e in tree.iter() if isinstance(e.tag, str)}
    related = [ids[e.get(href)[1:]] for e in tree.iter("{*}relatedTo") if e.get(href)]
    assert [etree.QName(e).localname for e in related] == ["WindowSurface"] * 2


@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
def test_readers_that_count_windows_are_not_misled(tmp_path: Path) -> None:
    source = data_path("ingolstadt_scene/score_scene.py")
    spec = importlib.util.spec_from_file_location("score_scene", source)
    assert spec and spec.loader
    scorer = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(scorer)
    found, walls = scorer.read_cityjson(str(written(tmp_path, "city.json")))
    bare, bare_walls = scorer.read_cityjson(str(written(tmp_path, "city.json", bars=False)))
    assert sorted(o["kind"] for o in found) == ["Door", "Window", "Window"]
    assert [(o["kind"], o.get("depth")) for o in found] == [(o["kind"], o.get("depth")) for o in bare]
    assert len(walls) == len(bare_walls)


def test_cjio_can_read_and_rewrite_the_file(tmp_path: Path) -> None:
    path = written(tmp_path, "city.json")
    out = tmp_path / "again.city.json"
    subprocess.run(
        [str(CJIO), str(path), "vertices_clean", "save", str(out)], check=True, capture_output=True
    )
    again = {o.about["id"]: o for o in read_city_openings(out)}
    for o in read_city_openings(path):
        assert again[o.about["id"]].about == o.about
        np.testing.assert_allclose(again[o.about["id"]].ring, o.ring, atol=6e-4)
