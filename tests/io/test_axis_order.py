"""The order of the axes: the authority's under a URN in CityGML, east first in every other case."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lxml import etree
from pyproj import CRS, Transformer

from city_files import house, write
from footprint_files import geojson
from frontage.io.citymodels.citygml.write import write_citygml
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.io.citymodels.read import read_city_model
from frontage.model import WorldRef

# EPSG code -> a place in it, longitude and latitude, and whether EPSG's register puts north first
PLACES = {
    3006: (18.07, 59.33, True),
    2180: (19.02, 52.20, True),
    31467: (9.18, 48.78, True),
    31468: (11.42, 48.76, True),
    25832: (11.42, 48.76, False),
    2154: (2.35, 48.85, False),
}


def world_in(code: int) -> WorldRef:
    longitude, latitude, _ = PLACES[code]
    x, y = Transformer.from_crs(4326, code, always_xy=True).transform(longitude, latitude)
    return WorldRef(np.array([int(x), int(y), 100]), f"EPSG:{code}")


def first_corner(path: Path) -> list[float]:
    lower = next(etree.parse(str(path)).getroot().iter("{*}lowerCorner"))
    return [float(v) for v in str(lower.text).split()]


@pytest.mark.parametrize("code", PLACES)
def test_the_places_are_of_the_register(code: int) -> None:
    axes = CRS.from_epsg(code).axis_info
    assert (axes[0].direction == "north") == PLACES[code][2]


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("code", PLACES)
def test_citygml_is_written_and_read_as_its_urn_says(tmp_path: Path, code: int, version: Any) -> None:
    world = world_in(code)
    path = write_citygml(tmp_path / "m.gml", [house("A", 0.0)], world, "t", version)
    text = path.read_text()
    assert f'srsName="urn:ogc:def:crs:EPSG::{code}"' in text
    east, north = world.origin[:2]
    expected = [north, east] if PLACES[code][2] else [east, north]
    assert first_corner(path)[:2] == pytest.approx(expected)
    rings = [e.text.split()[:2] for e in etree.parse(str(path)).getroot().iter("{*}posList")]
    assert np.abs(np.array(rings, float) - expected).max() < 20
    for target in (None, world):
        model = read_city_model(path, target)
        assert not model.notes
        low, _ = model.world.to_world(model.bounds())
        assert low == pytest.approx([east, north, 100])


@pytest.mark.parametrize("code", PLACES)
def test_plain_names_and_json_are_east_first(tmp_path: Path, code: int) -> None:
    world = world_in(code)
    east, north = world.origin[:2]
    gml = write_citygml(tmp_path / "m.gml", [house("A", 0.0)], WorldRef(world.origin, None), "t")
    plain = gml.read_text().replace("<gml:Envelope", f'<gml:Envelope srsName="EPSG:{code}"')
    table = geojson()
    ring = table["features"][0]["geometry"]["coordinates"][0]
    table["features"][0]["geometry"]["coordinates"] = [
        [[x - 678000 + int(east), y - 5403000 + int(north)] for x, y in ring]
    ]
    table["crs"]["properties"]["name"] = f"urn:ogc:def:crs:EPSG::{code}"
    paths = (
        write(tmp_path / "plain.gml", plain),
        write_cityjson(tmp_path / "m.city.json", [house("A", 0.0)], world, "t"),
        write(tmp_path / "m.geojson", table),
    )
    for path in paths:
        for target in (None, world):
            model = read_city_model(path, target)
            assert not [n for n in model.notes if "axes" in n], path
            low, _ = model.world.to_world(model.bounds())
            assert low[:2] == pytest.approx([east, north]), path
