"""Reading faces and solids for validation: every format gives the same cube; damaged files one sentence."""

import json
from pathlib import Path

import numpy as np
import pytest

from frontage.errors import FileError, InputError, OptionError, UnsupportedFormat
from frontage.io.shapes.read import read_shapes
from frontage.model import Feature, Polygons
from shape_files import (
    FACES,
    GOOD,
    VERTICES,
    city,
    cityjson,
    lod2_solid,
    lod2_surface,
    members,
    obj,
    off,
    poly,
    polygon,
)

OGC = "https://www.opengis.net/def/crs"


def shell(features: list[Feature]) -> Polygons:
    (shape,) = features[0].shapes
    assert shape.kind == "Solid"
    ((surfaces,),) = shape.solids
    return surfaces


def write(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.write_text(text)
    return path


@pytest.mark.parametrize("name", GOOD)
def test_every_format_gives_the_same_cube(name: str, tmp_path: Path) -> None:
    _, features = read_shapes(write(tmp_path, name, GOOD[name]()))
    surfaces = shell(features)
    assert len(features) == 1 and len(surfaces) == 6
    closed = surfaces.explicit
    assert closed == (name in ("cube.fg.json", "cube.gml", "pos.gml", "coordinates.xml"))
    expected = np.array([VERTICES[i] for f in FACES for i in ((*f, f[0]) if closed else f)], np.float64)
    packed = name in ("cube.city.json", "cube.city.jsonl", "cube11.json")
    shift = (10, 20, 30) if packed else (0, 0, 0)
    assert np.allclose(surfaces.points, expected + shift, atol=1e-12)
    assert np.diff(surfaces.rings).tolist() == [5 if closed else 4] * 6


def test_references_and_turned_surfaces(tmp_path: Path) -> None:
    """Walls stand in boundedBy, one of them turned; the solid only refers to them."""
    walls = [polygon(f if k != 2 else f[::-1], f"p{k}") for k, f in enumerate(FACES)]
    bounded = lod2_surface(members(*walls))
    refer = "".join(
        f'<gml:surfaceMember xlink:href="#p{k}"/>' if k != 2 else
        '<gml:surfaceMember><gml:OrientableSurface orientation="-"><gml:baseSurface xlink:href="#p2"/>'
        "</gml:OrientableSurface></gml:surfaceMember>"
        for k in range(6)
    )  # fmt: skip
    _, features = read_shapes(write(tmp_path, "m.gml", city(bounded + lod2_solid(refer))))
    surfaces = shell(features)
    assert surfaces.names == ("p0", "p1", "p2", "p3", "p4", "p5")
    ring = surfaces.points[surfaces.rings[2] : surfaces.rings[3]]
    start = ring.tolist().index(VERTICES[0])
    assert np.roll(ring[:-1], -start, axis=0).tolist() == [VERTICES[i] for i in FACES[2]]


def test_parts_and_installations(tmp_path: Path) -> None:
    def of(kind: str, name: str, inside: str = "") -> str:
        body = lod2_solid(members(*map(polygon, FACES)))
        return f"<bldg:{kind} gml:id='{name}'>{body}{inside}</bldg:{kind}>"

    text = city(
        f"<bldg:consistsOfBuildingPart>{of('BuildingPart', 'P1')}</bldg:consistsOfBuildingPart>"
        f"<bldg:consistsOfBuildingPart>{of('BuildingPart', 'P2')}</bldg:consistsOfBuildingPart>"
        f"<bldg:outerBuildingInstallation>{of('BuildingInstallation', 'I1')}</bldg:outerBuildingInstallation>"
    )
    _, features = read_shapes(write(tmp_path, "m.gml", text))
    assert [(f.id, f.kind) for f in features] == [("B1", "Building")]
    assert sorted(p.id for p in features[0].parts) == ["I1", "P1", "P2"]
    assert features[0].parts[0].shapes[0].lod == "2"


def test_cityjson_parts_templates_and_kinds(tmp_path: Path) -> None:
    faces = [[f] for f in FACES]
    data = cityjson()
    data["CityObjects"] = {
        "B": {"type": "Building", "children": ["P"]},
        "P": {"type": "BuildingPart", "parents": ["B"], "geometry": [
            {"type": "MultiSurface", "lod": "1", "boundaries": faces},
            {"type": "CompositeSolid", "lod": "2", "boundaries": [[faces], [faces]]},
            {"type": "MultiPoint", "lod": "0", "boundaries": [0, 1]},
        ]},
        "T": {"type": "SolitaryVegetationObject", "geometry": [{
            "type": "GeometryInstance", "template": 0, "boundaries": [6],
            "transformationMatrix": [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1],
        }]},
    }  # fmt: skip
    template = {"type": "Solid", "lod": "2", "boundaries": [faces]}
    data["geometry-templates"] = {"templates": [template], "vertices-templates": VERTICES}
    kind, features = read_shapes(write(tmp_path, "m.json", json.dumps(data)))
    assert kind == "CityJSON 2.0" and [f.id for f in features] == ["B", "T"]
    assert [(s.kind, len(s.solids)) for s in features[0].parts[0].shapes] == [
        ("MultiSurface", 1),
        ("CompositeSolid", 2),
    ]
    tree = shell([features[1]])
    assert tree.points.min(0).tolist() == [11, 21, 31] and tree.points.max(0).tolist() == [13, 23, 33]


def test_objects_of_one_obj_file_are_features(tmp_path: Path) -> None:
    text = obj() + "\no second\n" + "\n".join("f " + " ".join(str(i - 8) for i in f) for f in FACES)
    _, features = read_shapes(write(tmp_path, "two.obj", text))
    assert [f.id for f in features] == ["house", "second"]
    assert shell([features[0]]).points.tolist() == shell([features[1]]).points.tolist()


def test_inner_shells_go_with_faces_only(tmp_path: Path) -> None:
    outer, inner = write(tmp_path, "a.off", off()), write(tmp_path, "b.poly", poly())
    _, features = read_shapes(outer, "Solid", [inner])
    assert [len(s) for s in features[0].shapes[0].solids[0]] == [6, 6]
    with pytest.raises(OptionError, match="MultiSurface"):
        read_shapes(outer, "MultiSurface", [inner])
    with pytest.raises(OptionError, match="--inner"):
        read_shapes(write(tmp_path, "c.json", json.dumps(cityjson())), "Solid", [inner])


@pytest.mark.parametrize("name", GOOD)
def test_truncated_files_are_one_sentence(name: str, tmp_path: Path) -> None:
    text = GOOD[name]()
    for share in (0.03, 0.5, 0.9):
        path = write(tmp_path, name, text[: int(len(text) * share)])
        try:
            _, features = read_shapes(path)
        except FileError as error:
            assert sentence(error, path)
        else:  # an OBJ has no end mark
            assert path.suffix == ".obj" and len(shell(features).points) < 24


def sentence(error: InputError, path: Path) -> str:
    text = str(error)
    assert path.name in text and "\n" not in text and len(text) < 400
    return text


BAD: dict[str, tuple[str, str]] = {
    "broken transform": ("m.json", json.dumps({**cityjson(), "transform": {"scale": [1], "translate": []}})),
    "no scale": (
        "m.json",
        json.dumps({**cityjson(), "transform": {"scale": [0, 1, 1], "translate": [0] * 3}}),
    ),
    "negative count": ("m.off", off().replace("8 6 0", "-1 6 0")),
    "unknown version": ("m.json", json.dumps(cityjson("7.0"))),
    "no city objects": ("m.json", json.dumps({**cityjson(), "CityObjects": None})),
    "no vertices": ("m.json", json.dumps({k: v for k, v in cityjson().items() if k != "vertices"})),
    "boundaries of another type": ("m.json", json.dumps(cityjson()).replace('"Solid"', '"MultiSolid"')),
    "a vertex that is not there": ("m.json", json.dumps(cityjson(vertices=[[0, 0, 0]]))),
    "not a number": ("m.off", off().replace("1 1 1", "1 nan 1")),
    "a number beyond all measure": ("m.off", off().replace("1 1 1", "1 1e200 1")),
    "a word for a number": ("m.off", off().replace("1 1 1", "1 one 1")),
    "reference to nowhere": ("m.gml", city(lod2_solid("<gml:surfaceMember xlink:href='#no'/>"))),
    "a circle of references": (
        "m.gml",
        city(
            "<gml:MultiSurface gml:id='a'><gml:surfaceMember>"
            "<gml:CompositeSurface gml:id='b'><gml:surfaceMember xlink:href='#a'/></gml:CompositeSurface>"
            "</gml:surfaceMember></gml:MultiSurface>"
        ),
    ),
    "a document type": ("m.gml", "<!DOCTYPE x [<!ENTITY y 'z'>]>" + city("")),
    "a broken list": (
        "m.gml",
        city(lod2_solid(members(polygon(FACES[0]).replace("0 0 0 ", "0 0 ", 1)))),
    ),
    "an arc": (
        "m.gml",
        city(
            lod2_surface(
                "<gml:surfaceMember><gml:Polygon><gml:exterior><gml:Ring><gml:curveMember><gml:Arc>"
                "<gml:posList>0 0 0 1 1 0 2 0 0</gml:posList></gml:Arc></gml:curveMember></gml:Ring>"
                "</gml:exterior></gml:Polygon></gml:surfaceMember>"
            )
        ),
    ),
    "a list for an object": ("m.json", "[1, 2]"),
    "a number": ("m.json", "7"),
    "a facet too few": ("m.poly", poly().replace("6 0\n", "9 0\n")),
    "vertices of two dimensions": ("m.poly", poly().replace("8 3 0 0", "8 2 0 0")),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_files_are_one_sentence(name: str, tmp_path: Path) -> None:
    file, text = BAD[name]
    path = write(tmp_path, file, text)
    with pytest.raises(FileError) as caught:
        read_shapes(path)
    sentence(caught.value, path)


def test_missing_empty_and_unknown_files(tmp_path: Path) -> None:
    for path in (tmp_path / "none.json", tmp_path, write(tmp_path, "empty.gml", "")):
        with pytest.raises(FileError):
            read_shapes(path)
    for name, text in (
        ("x.txt", "hello"),
        (
            "g.json",
            json.dumps({"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": None}]}),
        ),
        ("o.json", json.dumps({"type": "Topology"})),
        ("d.json", json.dumps(cityjson(metadata={"referenceSystem": f"{OGC}/EPSG/0/4979"}))),
        (
            "d.gml",
            city(lod2_solid("")).replace("<gml:Solid", "<gml:Solid srsName='urn:ogc:def:crs:EPSG::4979'"),
        ),
    ):
        path = write(tmp_path, name, text)
        with pytest.raises(UnsupportedFormat) as caught:
            read_shapes(path)
        sentence(caught.value, path)
