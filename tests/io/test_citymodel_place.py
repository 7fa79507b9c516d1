"""City models outside the bounds, with other axis orders, or damaged: notes and errors are clear."""

import json
from pathlib import Path

import numpy as np
import pytest

from city_files import LOCAL, house, write
from frontage.errors import CrsError, FileError
from frontage.io.citymodels.citygml.write import write_citygml
from frontage.io.citymodels.read import read_city_model
from frontage.model import CityModel
from io_files import UTM
from shape_files import FACES, GOOD, city, cityjson, lod2_surface, members, polygon


@pytest.mark.parametrize(
    ("srs", "first", "second", "note"),
    [
        ("urn:ogc:def:crs:EPSG::4326", 48.76, 11.42, False),  # as its authority says: latitude first
        ("EPSG:4326", 11.42, 48.76, False),
        ("http://www.opengis.net/def/crs/OGC/1.3/CRS84", 11.42, 48.76, False),
        ("EPSG:4326", 48.76, 11.42, True),  # only this order lies where the world's CRS is used
        ("urn:ogc:def:crs:EPSG::31468", 5403000.0, 4457600.0, False),  # Gauss-Krueger: northing first
        ("urn:ogc:def:crs:EPSG::31468", 4457600.0, 5403000.0, True),
        ("urn:ogc:def:crs,crs:EPSG::25832,crs:EPSG::7837", 678000.0, 5403000.0, False),
        ("EPSG:25832", 5403000.0, 678000.0, True),
        ("urn:adv:crs:ETRS89_UTM32*DE_DHHN2016_NH", 678000.0, 5403000.0, False),
    ],
)
def test_the_order_of_the_axes(tmp_path: Path, srs: str, first: float, second: float, note: bool) -> None:
    scale = 1e-4 if first < 100 else 1.0
    ring = [
        f"{first + scale * a} {second + scale * b} {c}"
        for a, b, c in [[0, 0, 0], [0, 9, 0], [9, 9, 5], [0, 0, 0]]
    ]
    cube = polygon(FACES[0])
    inside = cube.replace(cube.split("posList>")[1], " ".join(ring) + "</gml:")
    text = city(lod2_surface(members(inside)))
    text = text.replace("<gml:MultiSurface>", f'<gml:MultiSurface srsName="{srs}">')
    model = read_city_model(write(tmp_path / "m.gml", text), UTM)
    low, high = model.world.to_world(model.bounds())
    assert (np.abs(low[:2] - [678000, 5403000]) < 3000).all() and (high - low)[:2].max() < 120
    told = [n for n in model.notes if "fit" in n]
    assert bool(told) == note and all("before" in n for n in told)


def test_a_model_outside_the_bounds_is_refused_with_advice(tmp_path: Path) -> None:
    near = (5.0, 100.0, 9.0, 110.0)
    path = write_citygml(tmp_path / "m.gml", [house("A", 0.0)], LOCAL, "t")
    assert len(read_city_model(path, LOCAL, bounds=(8.0, 5.0, 9.0, 9.0)).buildings) == 1
    with pytest.raises(
        FileError, match=r"m\.gml: .* x 0 to 8, y 0 to 6, 94 m away: check the CRS of the model"
    ):
        read_city_model(path, LOCAL, bounds=near)
    path = write_citygml(tmp_path / "n.gml", [house("A", 100.0)], LOCAL, "t")
    with pytest.raises(FileError, match=r"x and y are swapped: write the file with east before north"):
        read_city_model(path, LOCAL, bounds=near)
    path = write_citygml(tmp_path / "o.gml", [house("A", -20.0), house("B", 20.0)], LOCAL, "t")
    with pytest.raises(FileError, match=r"x -20 to 28, y 0 to 6, all around the bounds: check the bounds"):
        read_city_model(path, LOCAL, bounds=(0.0, 0.0, 5.0, 5.0))
    with pytest.raises(ValueError, match="no polygons"):
        CityModel((), LOCAL).bounds()


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.json", "{"), ("b.json", "[]"), ("c.json", '{"type": "Topology"}'),
        ("d.json", json.dumps(cityjson(CityObjects={}))),
        ("e.json", json.dumps(cityjson())[:-40]),
        ("f.json", json.dumps(cityjson(vertices=[[1, 2]]))),
        ("g.json", json.dumps(cityjson(vertices="no"))),
        ("h.city.jsonl", GOOD["cube.city.jsonl"]() + '{"type": "Something"}'),
        ("i.city.jsonl", GOOD["cube.city.jsonl"]() + "{"),
        ("j.gml", city("")), ("k.gml", city("<a>")),
        ("l.gml", f"<!DOCTYPE CityModel [<!ENTITY x 'y'>]>{city('&x;')}"),
        ("m.gml", "<html/>"), ("n.txt", "no model"),
        ("o.json", '{"type": "FeatureCollection", "features": [1]}'),
        ("p.json", '{"type": "CityJSON", "version": "2.0", "transform": 5, "CityObjects": 3}'),
    ],
)  # fmt: skip
def test_bad_files_are_refused_in_one_sentence(tmp_path: Path, name: str, text: str) -> None:
    with pytest.raises(FileError) as e:
        read_city_model(write(tmp_path / name, text))
    said = str(e.value)
    assert said.count(name) >= 1 and said.count(";") >= 1 and "\n" not in said and len(said) < 400


def test_a_model_without_crs_in_a_world_with_one_is_taken_to_be_in_it_or_refused(tmp_path: Path) -> None:
    model = cityjson(transform={"scale": [1, 1, 1], "translate": [678000, 5403000, 400]})
    found = read_city_model(write(tmp_path / "m.city.json", model), UTM)
    assert any("taken to be in the project's" in n for n in found.notes)
    with pytest.raises(CrsError, match="has no CRS, but the project is in EPSG:25832"):
        read_city_model(write(tmp_path / "n.city.json", cityjson()), UTM)
    with pytest.raises(CrsError, match="unknown CRS"):
        read_city_model(
            write(tmp_path / "o.city.json", cityjson(metadata={"referenceSystem": "EPSG:0"})), UTM
        )
