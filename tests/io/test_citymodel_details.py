"""Rarer features of city models: implicit geometries, attributes, addresses, groups, reading in pieces."""

import json
from pathlib import Path

import numpy as np
import pytest

import frontage.io.citymodels.jsonstream as jsonstream
from city_files import volume, write
from frontage.io.citymodels.jsonstream import members as json_members
from frontage.io.citymodels.read import read_city_model
from shape_files import FACES, GML, GOOD, city, cityjson, lod2_solid, lod2_surface, members, polygon

CUBE = lod2_solid(members(*(polygon(f) for f in FACES)))
GEN = 'xmlns:gen="http://www.opengis.net/citygml/generics/2.0"'


def test_an_implicit_geometry_stands_where_its_matrix_puts_it(tmp_path: Path) -> None:
    def balcony(name: str, x: float, shape: str) -> str:
        return (
            f"<bldg:outerBuildingInstallation><bldg:BuildingInstallation gml:id='{name}'>"
            "<bldg:lod2ImplicitRepresentation><ImplicitGeometry>"
            "<transformationMatrix>2 0 0 0 0 2 0 0 0 0 2 1 0 0 0 1</transformationMatrix>"
            f"<relativeGMLGeometry{shape}<referencePoint><gml:Point><gml:pos>{x} 0 0</gml:pos></gml:Point>"
            "</referencePoint></ImplicitGeometry></bldg:lod2ImplicitRepresentation>"
            "</bldg:BuildingInstallation></bldg:outerBuildingInstallation>"
        )

    shape = f"<gml:MultiSurface gml:id='proto'>{members(*(polygon(f) for f in FACES))}</gml:MultiSurface>"
    first = balcony("one", 10, f">{shape}</relativeGMLGeometry>")
    second = balcony("two", 20, ' xlink:href="#proto"/>')
    lost = balcony("three", 30, ' xlink:href="http://elsewhere/tree.gml"/>')
    model = read_city_model(write(tmp_path / "m.gml", city(CUBE + first + second + lost)))
    (b,) = model.buildings
    assert [(s.part, s.installation) for s in b.shells] == [("", False), ("one", True), ("two", True)]
    for shell, x in zip(b.shells[1:], (10, 20), strict=True):
        corners = model.world.to_world(np.concatenate([s.ring for s in shell.surfaces]))
        np.testing.assert_allclose([corners.min(0), corners.max(0)], [[x, 0, 1], [x + 2, 2, 3]])
    assert "a reference to another file" in model.problems[0].message


def test_attributes_and_addresses_of_citygml(tmp_path: Path) -> None:
    inside = (
        "<bldg:function>31001_1000</bldg:function><bldg:storeysAboveGround>4</bldg:storeysAboveGround>"
        "<bldg:measuredHeight uom='m'>n/a</bldg:measuredHeight>"
        f"<gen:stringAttribute {GEN} name='owner'><gen:value>city</gen:value></gen:stringAttribute>"
        f"<gen:intAttribute {GEN} name='flats'><gen:value>7</gen:value></gen:intAttribute>"
        f"<gen:doubleAttribute {GEN} name='share'><gen:value>0.5</gen:value></gen:doubleAttribute>"
        "<genericAttribute><IntAttribute><name>lifts</name><value>2</value></IntAttribute></genericAttribute>"
    )
    addresses = "".join(
        "<bldg:address><Address><xalAddress><Locality><LocalityName>Town</LocalityName><Thoroughfare>"
        f"<ThoroughfareName>Am Markt</ThoroughfareName>{number}</Thoroughfare></Locality></xalAddress>"
        "</Address></bldg:address>"
        for number in (
            "<ThoroughfareNumber>3 a</ThoroughfareNumber>",
            "<ThoroughfareNumber>5</ThoroughfareNumber>",
        )
    )
    (b,) = read_city_model(write(tmp_path / "m.gml", city(inside + CUBE + addresses))).buildings
    assert b.address == "3 a Am Markt"
    assert b.attributes == {
        "function": "31001_1000", "storeysAboveGround": 4, "measuredHeight": "n/a", "owner": "city",
        "flats": 7, "share": 0.5, "lifts": 2, "further_addresses": "5 Am Markt"}  # fmt: skip


def test_interior_objects_are_not_part_of_the_shell(tmp_path: Path) -> None:
    room = f"<bldg:interiorRoom><bldg:Room>{CUBE.replace('lod2', 'lod4')}</bldg:Room></bldg:interiorRoom>"
    hidden = (
        "<buildingInstallation><BuildingInstallation><relationToConstruction>inside</relationToConstruction>"
        f"{CUBE}</BuildingInstallation></buildingInstallation>"
    )
    (b,) = read_city_model(write(tmp_path / "m.gml", city(CUBE + room + hidden))).buildings
    assert [(s.lod, len(s.surfaces)) for s in b.shells] == [("2", 6)]


def test_aggregates_turned_surfaces_and_inner_shells(tmp_path: Path) -> None:
    turned = "".join(
        f"<gml:surfaceMember><gml:OrientableSurface orientation='-'><gml:baseSurface>{polygon(f[::-1])}"
        "</gml:baseSurface></gml:OrientableSurface></gml:surfaceMember>"
        for f in FACES
    )
    shell = f"<gml:CompositeSurface>{turned}</gml:CompositeSurface>"
    solid = f"<gml:Solid><gml:exterior>{shell}</gml:exterior><gml:interior>{shell}</gml:interior></gml:Solid>"
    many = f"<gml:MultiSolid><gml:solidMember>{solid}</gml:solidMember></gml:MultiSolid>"
    model = read_city_model(write(tmp_path / "m.gml", city(f"<bldg:lod2Solid>{many}</bldg:lod2Solid>")))
    (only,) = model.buildings[0].shells
    assert only.closed and volume(only) == pytest.approx(1) and len(only.surfaces) == 6
    assert "an inner shell of a solid" in model.problems[0].message

    cube = cityjson()["CityObjects"]["B1"]["geometry"][0]["boundaries"]
    meaning = {"surfaces": [{"type": "WallSurface", "id": "w"}], "values": [None, [[0] * 6]]}
    two = {"type": "MultiSolid", "lod": "1.3", "boundaries": [cube, cube], "semantics": meaning}
    objects = {"B1": {"type": "Building", "geometry": [two]}}
    (b,) = read_city_model(write(tmp_path / "m.json", cityjson(CityObjects=objects))).buildings
    assert [(s.lod, s.closed, len(s.surfaces)) for s in b.shells] == [("1.3", True, 6)] * 2
    assert [s.source_id for s in b.shells[1].surfaces][:2] == ["w", "w#2"]
    assert {s.semantics for s in b.shells[1].surfaces} == {"WallSurface"}


def test_buildings_in_groups_and_other_objects(tmp_path: Path) -> None:
    surface = lod2_surface(members(polygon(FACES[0])))
    road = f"<cityObjectMember><Road gml:id='r'>{surface}</Road></cityObjectMember>"
    group = (
        "<cityObjectMember><CityObjectGroup><groupMember>"
        f"<bldg:Building gml:id='in'>{CUBE}</bldg:Building>"
        "</groupMember></CityObjectGroup></cityObjectMember>"
    )
    plain = f"<cityObjectMember><bldg:Building>{CUBE}</bldg:Building></cityObjectMember>"
    text = f"<CityModel {GML}>{road}{group}{plain}</CityModel>"
    found = read_city_model(write(tmp_path / "m.gml", text))
    assert [b.id for b in found.buildings] == ["in", "building2"] and found.problems == ()


def test_parts_far_from_their_building_come_with_it(tmp_path: Path) -> None:
    """Only the part touches the bounds; it stands first in the file and the building last."""
    model = cityjson(transform={"scale": [1, 1, 1], "translate": [0, 0, 0]})
    cube = model["CityObjects"]["B1"]["geometry"]
    model["vertices"] += [[x + 100, y, z] for x, y, z in model["vertices"]]
    shifted = json.loads(json.dumps(cube))
    shifted[0]["boundaries"] = [[[[i + 8 for i in f]] for f in FACES]]
    model["CityObjects"] = {
        "part": {"type": "BuildingPart", "parents": ["H"], "geometry": shifted},
        "other": {"type": "Building", "geometry": cube},
        "H": {"type": "Building", "children": ["part"], "geometry": cube},
    }
    path = write(tmp_path / "m.json", model)
    (b,) = read_city_model(path, bounds=(99, 0, 103, 3)).buildings
    assert b.id == "H" and sorted(s.part for s in b.shells) == ["", "part"]


@pytest.mark.parametrize("step", [1, 7, 64])
def test_json_is_read_in_pieces_of_any_size(
    tmp_path: Path, step: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(jsonstream, "_STEP", step)
    values = {
        "a": -12.5e3,
        "b": 'x"]}\\',
        "many": [1, [2, {}], None, True],
        "named": {"k": 1, "l": []},
        "none": [],
    }
    path = write(tmp_path / "a.json", json.dumps(values, indent=1))
    found: dict = {}
    for _, name, key, value in json_members(path, ("many", "named", "none")):
        if key is None:
            found[name] = value
        elif isinstance(key, int):
            found.setdefault(name, []).append(value)
        else:
            found.setdefault(name, {})[key] = value
    assert found | {"none": []} == values
    sequence = write(tmp_path / "b.city.jsonl", "\x1e" + GOOD["cube.city.jsonl"]().replace("\n", "\n\n"))
    assert [b.id for b in read_city_model(sequence).buildings] == ["B1"]
    for text in ('{"a": 1', '{"a": [1, 2}', '{"a": 1} 5', "[1]", '{"a" 1}', '{"many": [1 2]}'):
        with pytest.raises(ValueError, match="at character"):
            list(json_members(write(tmp_path / "c.json", text), ("many",)))
