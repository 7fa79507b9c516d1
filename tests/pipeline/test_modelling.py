"""The stage `model` on facades and elements that were put in a run folder by hand."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from facade_fakes import WORLD
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.io.citymodels.read import read_city_model
from frontage.io.shapes.read import read_shapes
from frontage.model import Building, Elements, Estimate
from frontage.model.citymodel import CityBuilding, Shell
from frontage.pipeline.graph import Graph
from frontage.pipeline.progress import Silent
from frontage.pipeline.project import make_project
from frontage.pipeline.stages import STAGES, model
from frontage.pipeline.store.markers import Marker
from frontage.pipeline.store.records import BuildingRecord
from frontage.pipeline.store.results import ItemResult, ScansResult, StageResult, WorldRecord, result_to_json
from frontage.pipeline.store.store import Store
from frontage.scale import make_executor
from frontage.validation import validate_feature
from opening_fakes import opening, round_door
from solids.test_assemble import GROUND, house, protrusion, wall
from solids.test_build_host import polygons

FILES = ("lod3.city.json", "lod3.gml", "lod3_citygml3.gml", "lod3.glb", "report.json")


def folder(out: Path, names: tuple[str, ...] = ("B01", "B02")) -> Store:
    """Facades of two houses side by side, each with a window, a door and a balcony."""
    store = Store.create(out)
    records = []
    for k, name in enumerate(names):
        at = wall(at=(10.0 * k, 0, 0))
        facade = replace(at, id=f"{name}/F1", building=name)
        panes = tuple(replace(o, id=f"{name}/F1/{o.id[-4:]}") for o in (opening(), round_door()))
        balcony = replace(protrusion("balcony", (-3.5, -1.5, -1.5, -0.4), -1.0), id=f"{name}/F1/P1")
        store.save_facade(facade)
        store.save_found_elements(facade, Elements(facade.id, panes, (balcony,)))
        judged(store, name, facade.id)
        records.append(BuildingRecord.of(Building(name, np.arange(3), GROUND, f"{k + 1} Lime Street"), 3))
    store.save_building_records(records, WORLD)
    low, high = WORLD.to_world(np.array([[40.0, 850, 0], [90, 890, 30]]))
    scans = ScansResult(
        items=1,
        world=WorldRecord(WORLD.crs, tuple(int(v) for v in WORLD.origin)),
        extent=(tuple(low), tuple(high)),
        rays=True,
        looks=True,
        parts=(),
    )
    store.markers.finish("scans", "", Marker("k", result_to_json(scans)), [])
    return store


def judged(store: Store, building: str, *facades: str) -> None:
    """Markers of a building whose facades were found and judged."""
    for stage in ("facades", "openings"):
        store.markers.finish(stage, building, Marker("k", result_to_json(ItemResult(facades=facades))), [])


def made(store: Store, workers: int = 1, city: Path | None = None, addresses=(), **options) -> StageResult:
    table = {"scans": [{"path": "x.las"}], "solids": options, "addresses": addresses}
    if city is not None:
        table["model"] = {"path": str(city)}
    with make_executor(workers) as executor:
        graph = Graph(STAGES, store, make_project(table, store.out), {})
        return graph.perform(model.STAGE, executor, Silent())


def test_files_of_the_model(tmp_path: Path) -> None:
    store = folder(tmp_path)
    result = made(store)
    assert (result.items, result.buildings, result.warnings) == (2, ("B01", "B02"), ())
    assert "B01, B02: built on blocks behind their facades" in result.notes[0]
    for name in FILES:
        assert (tmp_path / "model" / name).stat().st_size > 0
    about = json.loads((tmp_path / "model" / "report.json").read_text())
    assert about["B01"]["openings_built"] == about["B01"]["openings_found"] == 2
    assert about["B02"]["installations"] == ["B02/F1/P1"] and about["B02"]["host"] == "cloud"
    assert (tmp_path / "model" / "pictures" / "B02.png").read_bytes()[:4] == b"\x89PNG"
    model = read_city_model(tmp_path / "model" / "lod3.city.json", WORLD)
    assert [(b.id, b.address) for b in model.buildings] == [
        ("B01", "1 Lime Street"),
        ("B02", "2 Lime Street"),
    ]


def test_addresses_of_the_project_file_name_what_has_none(tmp_path: Path) -> None:
    store = folder(tmp_path, ("B01",))
    index = store.buildings_folder / "index.json"
    index.write_text(index.read_text().replace('"1 Lime Street"', "null"))
    made(store, addresses={"B01": "13 rue Soufflot"})
    (building,) = read_city_model(tmp_path / "model" / "lod3.city.json", WORLD).buildings
    assert building.address == "13 rue Soufflot"


def test_an_address_for_a_building_that_does_not_exist_is_told(tmp_path: Path) -> None:
    store = folder(tmp_path / "run")
    judged(store, "B01", "B01/F1")
    result = made(store, addresses={"B99": "13 rue Soufflot"})
    (note,) = (n for n in result.notes if "Soufflot" in n)
    assert '"13 rue Soufflot" to building "B99"' in note and "B01" in note


def city_model(path: Path, wide: float, offset: float = 0.2) -> Path:
    """A city model of one house, `wide` m along the street, its front `offset` m behind the measured one."""
    at = wall(wide=wide, at=(wide / 2 - 5, offset, 0))
    surfaces = tuple(polygons(house(at, Elements("B01/F1", ())).built[0].host))
    return write_cityjson(path, [CityBuilding("M7", (Shell("2", surfaces),))], WORLD, "m")


def test_a_city_model_is_the_host_and_what_it_lacks_is_made(tmp_path: Path) -> None:
    store = folder(tmp_path)
    result = made(store, city=city_model(tmp_path / "m.city.json", 10.0))
    about = json.loads((tmp_path / "model" / "report.json").read_text())
    assert [about[n]["host"] for n in ("B01", "B02")] == ["model", "cloud"]
    assert about["B01"]["offsets"]["B01/F1/W1-1"] == pytest.approx(0.2, abs=1e-3)
    assert result.notes == ("B02: built on blocks behind their facades, for lack of a city model",)


def test_two_measured_houses_on_one_of_the_model_become_one(tmp_path: Path) -> None:
    store = folder(tmp_path)
    result = made(store, city=city_model(tmp_path / "m.city.json", 20.0))
    assert result.buildings == ("B01",)
    assert "B01, B02 stand on one building of the city model" in result.notes[0]
    about = json.loads((tmp_path / "model" / "report.json").read_text())
    assert about["B01"]["openings_built"] == 4


def test_two_houses_of_the_model_under_one_measured_one_stay_two(tmp_path: Path) -> None:
    """Neighbours in a city model reach into each other by its errors: parts of one would be invalid."""
    store = folder(tmp_path, ("B01",))
    halves = []
    for k in (0, 1):
        at = wall(wide=5.1, at=(-2.5 + 5.0 * k, 0.1, 0))
        surfaces = tuple(polygons(house(at, Elements("B01/F1", ())).built[0].host))
        halves.append(CityBuilding(f"M{k}", (Shell("2", surfaces),), f"{k + 7} Mill Lane"))
    path = write_cityjson(tmp_path / "m.city.json", halves, WORLD, "m")
    result = made(store, city=path)
    assert result.buildings == ("B01", "B01-2") and not result.warnings
    found = read_city_model(tmp_path / "model" / "lod3.city.json", WORLD).buildings
    assert [b.attributes["model_id"] for b in found] == ["M0", "M1"]
    assert [b.address for b in found] == ["7 Mill Lane", "8 Mill Lane"]
    openings = [
        {s.source_id for sh in b.shells for s in sh.surfaces if s.semantics in ("Window", "Door")}
        for b in found
    ]
    assert [len(o) for o in openings] == [1, 1] and not openings[0] & openings[1]
    _, features = read_shapes(tmp_path / "model" / "lod3.city.json")
    assert [v for f in features for v in validate_feature(f)] == []


def test_options_of_the_table(tmp_path: Path) -> None:
    store = folder(tmp_path, ("B01",))
    made(store, city=city_model(tmp_path / "m.city.json", 10.0), reseat=True)
    about = json.loads((tmp_path / "model" / "report.json").read_text())
    assert about["B01"]["offsets"]["B01/F1/W1-1"] == pytest.approx(0.0, abs=1e-3)
    made(store, depth=False)
    about = json.loads((tmp_path / "model" / "report.json").read_text())
    assert about["B01"]["installations"] == [] and about["B01"]["openings_built"] == 2


def test_without_buildings_nothing_stale_stays(tmp_path: Path) -> None:
    store = folder(tmp_path, ("B01",))
    made(store)
    store.save_building_records([], WORLD)
    assert made(store).items == 0
    assert not [p for p in (tmp_path / "model").rglob("*") if p.is_file()]


def test_a_facade_without_a_wall_is_a_warning_with_its_openings(tmp_path: Path) -> None:
    store = folder(tmp_path, ("B01",))
    behind = replace(wall(), id="B01/F2")
    pose = replace(behind.frame, t=behind.frame.apply(np.array([[0, 3.0, 0]]))[0])
    behind = replace(behind, local_from_facade=Estimate(pose, np.eye(6) * 1e-8, 9.0))
    store.save_facade(behind)
    store.save_found_elements(behind, Elements("B01/F2", (replace(opening(), id="B01/F2/W0-1"),)))
    judged(store, "B01", "B01/F1", "B01/F2")
    (warning,) = made(store, city=city_model(tmp_path / "m.city.json", 10.0)).warnings
    assert (warning.item, warning.code) == ("B01", "S310")
    assert "B01/F2: no wall of the host lies where it was measured; left out: B01/F2/W0-1" in warning.message
