"""City models of every format are read completely, or refused with one clear sentence."""

import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from city_files import LOCAL, house, volume, write
from frontage.errors import FileError
from frontage.io.citymodels.citygml.write import write_citygml
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.io.citymodels.read import read_city_model
from frontage.model import CityBuilding, CityModel, Shell
from io_files import UTM
from realdata import data_path
from shape_files import FACES, GML, GOOD, VERTICES, city, cityjson, lod2_solid, lod2_surface, members, polygon

CITY = "citymodels/"
SCENE = "ingolstadt_scene/input/lod2/lod2"


def corners(model: CityModel) -> dict[str, np.ndarray]:
    """World coordinates of every polygon by name."""
    return {
        s.source_id: model.world.to_world(s.ring)
        for b in model.buildings for shell in b.shells for s in shell.surfaces
    }  # fmt: skip


@pytest.mark.parametrize("name", [n for n in GOOD if n.split(".")[-1] in ("json", "jsonl", "gml", "xml")
                                  and "fg" not in n])  # fmt: skip
def test_a_cube_of_every_format(tmp_path: Path, name: str) -> None:
    model = read_city_model(write(tmp_path / name, GOOD[name]()))
    (building,) = model.buildings
    (shell,) = building.shells
    assert (building.id, shell.lod, shell.closed, model.problems) == ("B1", "2", True, ())
    assert Counter(s.semantics for s in shell.surfaces) == {
        "WallSurface": 4, "RoofSurface": 1, "GroundSurface": 1}  # fmt: skip
    assert volume(shell) == pytest.approx(1.0)
    assert len({s.source_id for s in shell.surfaces}) == 6
    shift = [0, 0, 0] if name.endswith(("gml", "xml")) else [10, 20, 30]
    np.testing.assert_allclose(model.bounds() - model.bounds()[0], [[0, 0, 0], [1, 1, 1]])
    np.testing.assert_allclose(model.bounds()[0], shift)


def test_both_encodings_of_one_model_agree_to_a_millimetre() -> None:
    a = read_city_model(data_path(SCENE + ".city.json"), UTM)
    b = read_city_model(data_path(SCENE + ".gml"), UTM)
    one, other = corners(a), corners(b)
    assert len(one) == 105 and one.keys() == other.keys()
    assert max(np.abs(one[name] - other[name]).max() for name in one) < 1e-3
    assert [x.id for x in a.buildings] == [x.id for x in b.buildings]
    kinds = [
        Counter(s.semantics for x in m.buildings for shell in x.shells for s in shell.surfaces)
        for m in (a, b)
    ]
    assert kinds[0] == kinds[1] == {"WallSurface": 41, "RoofSurface": 58, "GroundSurface": 6}
    assert all(shell.closed and volume(shell) > 500 for x in b.buildings for shell in x.shells)


@pytest.mark.parametrize(
    ("path", "lod", "closed", "kinds"),
    [
        (
            "lod_examples/CityGMLv2/Building_LOD0-EPSG25832.gml",
            "0",
            0,
            {"GroundSurface": 1, "RoofSurface": 1},
        ),
        (
            "lod_examples/CityGMLv3/Building_LOD0-EPSG25832.gml",
            "0",
            0,
            {"GroundSurface": 1, "RoofSurface": 1},
        ),
        ("lod_examples/CityGMLv2/Building_LOD1-EPSG25832.gml", "1", 1, {"WallSurface": 4, "RoofSurface": 1}),
        ("lod_examples/CityGMLv3/Building_LOD1-LocalEngineeringCRS.gml", "1", 1, {"WallSurface": 4}),
        ("lod_examples/CityGMLv2/Building_LOD2-EPSG25832.gml", "2", 1, {"WallSurface": 4, "RoofSurface": 2}),
        ("lod_examples/CityGMLv3/Building_LOD2-EPSG25832.gml", "2", 1, {"WallSurface": 4, "RoofSurface": 2}),
        ("lod_examples/CityGMLv2/Building_LOD3-EPSG25832.gml", "3", 1, {"Window": 2, "Door": 1}),
        ("lod_examples/CityGMLv3/Building_LOD3-EPSG25832.gml", "3", 1, {"Window": 2, "Door": 1}),
        ("lod_examples/CityGMLv2/Building_LOD4-EPSG25832.gml", "4", 1, {"Window": 2, "Door": 1}),
        ("lod_examples/CityGMLv2/Building_and_garage_LOD2-EPSG25832.gml", "2", 2, {"WallSurface": 9}),
        ("lod_examples/CityGMLv3/Building_and_garage_LOD2-EPSG25832.gml", "2", 2, {"WallSurface": 9}),
        ("munich_lod2/DEBY_LOD2_4959323.gml", "2", 0, {"WallSurface": 9, "RoofSurface": 4}),
        ("ingolstadt_lod3/4018150b.xml", "3", 0, {"Window": 255, "Door": 2}),
        ("ingolstadt_lod3/4018270.xml", "3", 0, {"Window": 57, "WallSurface": 5}),
        ("delft/LOD3_model.json", "2.2", 0, {"Window": 506, "Door": 30}),
    ],
)
def test_models_as_published(path: str, lod: str, closed: int, kinds: dict[str, int]) -> None:
    model = read_city_model(data_path(CITY + path))
    (building,) = model.buildings
    assert {s.lod for s in building.shells} == {lod}
    assert sum(s.closed for s in building.shells) == closed
    found = Counter(s.semantics for shell in building.shells for s in shell.surfaces)
    assert {k: found[k] for k in kinds} == kinds
    without_area = ["I120"] if "delft" in path else []
    assert [p.code for p in model.problems] == without_area
    assert all(volume(s) > 20 for s in building.shells if s.closed)
    size = np.diff(model.bounds(), axis=0)
    assert (size >= [[3, 3, 2.9]]).all() and (size < 95).all()


def test_parts_addresses_and_attributes_of_published_models() -> None:
    garage = read_city_model(
        data_path(CITY + "lod_examples/CityGMLv3/Building_and_garage_LOD2-EPSG25832.gml")
    )
    (b,) = garage.buildings
    assert [s.part for s in b.shells] == ["", "GMLID_BUI379228_1244_301"]
    assert b.address == "1 Hermann-von-Helmholtz-Platz"
    assert (b.attributes["measuredHeight"], b.attributes["storeysAboveGround"]) == (6.0, 1)
    (munich,) = read_city_model(data_path(CITY + "munich_lod2/DEBY_LOD2_4959322.gml")).buildings
    assert munich.address == "Arcisstraße 21" and munich.attributes["roofType"] == "3100"
    (bay,) = read_city_model(data_path(CITY + "ingolstadt_lod3/4018150b.xml")).buildings
    assert [s.installation for s in bay.shells] == [False] + [True] * 8
    openings = [s.source_id for s in bay.shells[0].surfaces if s.semantics in ("Window", "Door")]
    assert len({bay.shells[0].about[name]["surface"] for name in openings}) == 12  # windows of many polygons


def test_a_local_system_is_placed_by_its_anchor() -> None:
    name = CITY + "lod_examples/CityGMLv{}/Building_LOD1-{}.gml"
    for version in (2, 3):
        a = read_city_model(data_path(name.format(version, "LocalEngineeringCRS")))
        b = read_city_model(data_path(name.format(version, "EPSG25832")))
        assert a.world.crs == b.world.crs == "EPSG:25832+5783"
        np.testing.assert_allclose(a.world.to_world(a.bounds()), b.world.to_world(b.bounds()), atol=1e-9)
        local = read_city_model(data_path(name.format(version, "LocalEngineeringCRS")), LOCAL)
        assert np.abs(local.bounds()).max() < 100  # data without a CRS stays in the local system


def test_surfaces_that_a_solid_refers_to_keep_class_and_name(tmp_path: Path) -> None:
    walls = [
        f"<bldg:boundedBy><bldg:{'RoofSurface' if k == 1 else 'WallSurface'} gml:id='S{k}'>"
        f"<bldg:lod2MultiSurface><gml:MultiSurface>{members(polygon(f, f'P{k}'))}</gml:MultiSurface>"
        "</bldg:lod2MultiSurface>"
        f"</bldg:{'RoofSurface' if k == 1 else 'WallSurface'}></bldg:boundedBy>"
        for k, f in enumerate(FACES)
    ]  # fmt: skip
    links = "".join(f'<gml:surfaceMember xlink:href="#P{k}"/>' for k in range(6))
    (b,) = read_city_model(write(tmp_path / "a.gml", city(lod2_solid(links) + "".join(walls)))).buildings
    (shell,) = b.shells
    assert [s.source_id for s in shell.surfaces] == [f"P{k}" for k in range(6)] and shell.closed
    assert shell.surfaces[1].semantics == "RoofSurface" and shell.about["P1"] == {"surface": "S1"}
    copies = lod2_solid(members(*(polygon(f) for f in FACES)))  # the solid repeats the polygons
    (b,) = read_city_model(write(tmp_path / "b.gml", city(copies + "".join(walls)))).buildings
    assert [(len(s.surfaces), s.closed) for s in b.shells] == [(6, True)]
    assert b.shells[0].surfaces[1].semantics == "RoofSurface"


def test_a_polygon_of_another_building_is_found_anywhere_in_the_file(tmp_path: Path) -> None:
    whole = [polygon(f, f"P{k}") for k, f in enumerate(FACES)]
    shared = members(*whole[:5]) + '<gml:surfaceMember xlink:href="#P5"/>'
    lost = (
        members(*(polygon(f, f"Q{k}") for k, f in enumerate(FACES))) + '<gml:surfaceMember xlink:href="#no"/>'
    )
    text = "".join(
        f"<cityObjectMember><bldg:Building gml:id='{name}'>{inside}</bldg:Building></cityObjectMember>"
        for name, inside in (
            ("A", lod2_solid(shared)), ("B", lod2_surface(members(whole[5]))), ("C", lod2_solid(lost)))
    )  # fmt: skip
    model = read_city_model(write(tmp_path / "m.gml", f"<CityModel {GML}>{text}</CityModel>"))
    by_id = {b.id: b for b in model.buildings}
    assert volume(by_id["A"].shells[0]) == pytest.approx(1) and len(by_id["B"].shells[0].surfaces) == 1
    assert [p.message for p in model.problems] == [
        "C: a reference to #no, which is not in the file; 6 of 6 polygons used"]  # fmt: skip


@pytest.mark.parametrize("kind", ["gml", "city.json"])
def test_only_malformed_polygons_are_left_out(tmp_path: Path, kind: str) -> None:
    bad = [[0, 1, 1], [0, 0, 0], [0, 1]]
    if kind == "gml":
        nan = polygon(FACES[0]).replace("0 0 0", "NaN 0 0", 1)
        broken = polygon(FACES[0]).replace("0 0 0", "x 0 0", 1)
        odd = polygon(FACES[0]).replace("0 0 0", "0 0", 1)
        inside = lod2_solid(members(*(polygon(f) for f in (*FACES, *bad)), nan, broken, odd))
        rest = city(lod2_solid(members(polygon(bad[0]))), "B2").split("<cityObjectMember>")[1]
        text = city(inside).replace("</CityModel>", f"<cityObjectMember>{rest}")
    else:
        model = cityjson()
        model["CityObjects"]["B1"]["geometry"][0]["boundaries"][0] += [[f] for f in (*bad, [0, 1, 99], "no")]
        model["CityObjects"]["B2"] = {"type": "Building", "geometry": [
            {"type": "MultiSurface", "lod": "1", "boundaries": [[bad[0]]]}]}  # fmt: skip
        text = json.dumps(model)
    found = read_city_model(write(tmp_path / f"m.{kind}", text))
    assert [b.id for b in found.buildings] == ["B1"]
    assert len(found.buildings[0].shells[0].surfaces) == 6
    codes = {p.message.split(":")[0]: p.code for p in found.problems}
    assert codes == {"B1": "I120", "B2": "I121"}
    assert all(p.message.count(";") == 1 and p.hint for p in found.problems)
    assert "3 x a polygon with fewer than 3 corners" in found.problems[0].message


def test_a_solid_turned_inside_out_is_turned_back(tmp_path: Path) -> None:
    text = city(lod2_solid(members(*(polygon(f[::-1]) for f in FACES))))
    (b,) = read_city_model(write(tmp_path / "a.gml", text)).buildings
    assert volume(b.shells[0]) == pytest.approx(1)
    assert Counter(s.semantics for s in b.shells[0].surfaces)["GroundSurface"] == 1


@pytest.mark.parametrize("kind", ["city.json", "gml"])
def test_written_models_are_read_back(tmp_path: Path, kind: str) -> None:
    write_model = write_cityjson if kind == "city.json" else write_citygml
    path = write_model(tmp_path / f"m.{kind}", [house("A", 0), house("B", 8.123)], UTM, "two houses")
    model = read_city_model(path, UTM)
    assert model.problems == model.notes == () and [b.id for b in model.buildings] == ["A", "B"]
    for wrote, read in zip([house("A", 0), house("B", 8.123)], model.buildings, strict=True):
        assert read.address == "12 Lime Street" and read.attributes["measuredHeight"] == 5.0
        assert read.shells[0].closed
        for a, b in zip(wrote.shells[0].surfaces, read.shells[0].surfaces, strict=True):
            assert a.semantics == b.semantics
            np.testing.assert_allclose(a.ring, b.ring, atol=1e-4)
    again = write_model(tmp_path / f"n.{kind}", model.buildings, model.world, "two houses")
    second = read_city_model(again, UTM)
    for a, b in zip(model.buildings, second.buildings, strict=True):
        assert [s.semantics for s in a.shells[0].surfaces] == [s.semantics for s in b.shells[0].surfaces]
    if kind == "city.json":
        assert model.buildings[0].shells[0].about == {"A/s2": {"sigma": 0.004}}
        assert again.read_bytes() == path.read_bytes()


def test_levels_of_detail() -> None:
    shells = [
        Shell(lod, (), part=part) for lod, part in (("1", ""), ("2.2", ""), ("2.2", "p"), ("3", ""), ("", ""))
    ]
    b = CityBuilding("B", tuple(shells))
    assert b.level() == (shells[3],) and b.level("2") == (shells[1], shells[2])
    assert b.level("1.3") == (shells[0],) and b.level("0") == (shells[4],)
    assert CityBuilding("B", (shells[3],)).level("2") == (shells[3],)
    assert CityBuilding("B", ()).level() == ()


def test_cityjson_versions_templates_and_parts(tmp_path: Path) -> None:
    old = cityjson("1.0", vertices=VERTICES)
    del old["transform"]
    old["CityObjects"]["B1"] |= {"address": {"ThoroughfareName": "rue Soufflot", "ThoroughfareNumber": "13"}}
    (b,) = read_city_model(write(tmp_path / "old.json", old)).buildings
    assert b.address == "13 rue Soufflot"
    with pytest.raises(FileError, match=r"version '3\.0' is not supported"):
        read_city_model(write(tmp_path / "x.json", cityjson("3.0")))
    missing = cityjson("1.1")
    del missing["transform"]
    with pytest.raises(FileError, match="transform is missing"):
        read_city_model(write(tmp_path / "x.json", missing))

    model = cityjson()
    cube = {"type": "MultiSurface", "lod": "2", "boundaries": [[f] for f in FACES]}
    model["geometry-templates"] = {"templates": [cube], "vertices-templates": VERTICES}
    matrix = np.diag([2.0, 2, 2, 1])
    matrix[:3, 3] = [0, 0, 5]
    instance = {
        "type": "GeometryInstance",
        "template": 0,
        "boundaries": [6],
        "transformationMatrix": matrix.ravel().tolist(),
    }
    model["CityObjects"] = {
        "balcony": {"type": "BuildingInstallation", "parents": ["part"], "geometry": [instance]},
        "tree": {"type": "SolitaryVegetationObject", "geometry": [instance]},
        "part": {"type": "BuildingPart", "parents": ["H"], "children": ["balcony"],
                 "geometry": model["CityObjects"]["B1"]["geometry"]},
        "H": {"type": "Building", "children": ["part"]},
    }  # fmt: skip
    found = read_city_model(write(tmp_path / "t.json", model))
    (b,) = found.buildings
    assert [(s.part, s.installation, s.closed) for s in b.shells] == [
        ("balcony", True, False), ("part", False, True)]  # fmt: skip
    balcony = np.concatenate([s.ring for s in b.shells[0].surfaces])
    np.testing.assert_allclose(balcony.min(0), [11, 21, 36])
    np.testing.assert_allclose(balcony.max(0), [13, 23, 38])


def test_only_buildings_that_touch_the_bounds_are_read(tmp_path: Path) -> None:
    row = [house(f"B{k}", 10.0 * k) for k in range(20)]
    x, y = UTM.origin[:2]
    near = (x + 95.0, y + 1.0, x + 121.0, y + 2.0)
    for path in (
        write_cityjson(tmp_path / "m.city.json", row, UTM, "t"),
        write_citygml(tmp_path / "m.gml", row, UTM, "t"),
    ):
        model = read_city_model(path, UTM, bounds=near)
        assert [b.id for b in model.buildings] == ["B9", "B10", "B11", "B12"]
        above = (*near[:2], 90.0, *near[2:], 99.0)
        with pytest.raises(
            FileError, match=r"no buildings within the bounds; they lie at x .* check the CRS"
        ):
            read_city_model(path, UTM, bounds=above)
