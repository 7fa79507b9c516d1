"""Footprints of maps, with heights and without."""

from pathlib import Path

import numpy as np
import pytest

from city_files import volume, write
from footprint_files import geojson, geopackage
from frontage.errors import FileError
from frontage.io.citymodels.read import read_city_model
from io_files import UTM


@pytest.mark.parametrize("kind", ["geojson", "gpkg"])
def test_footprints_with_heights_become_blocks(tmp_path: Path, kind: str) -> None:
    if kind == "geojson":
        path = write(
            tmp_path / "f.geojson",
            geojson(height="12.5 m", ground_z=371.5, id=7, street="rue Soufflot", housenumber=13),
        )
    else:
        path = geopackage(tmp_path / "f.gpkg", z=True)
    model = read_city_model(path, UTM)
    (b,) = model.buildings
    assert (b.id, b.address) == ("7", "13 rue Soufflot")
    assert next((s.lod, s.closed, len(s.surfaces)) for s in b.shells) == ("0", False, 1)
    block = b.level()[0]
    walls = 4 + (4 if kind == "geojson" else 3)
    area = 80 - (4 if kind == "geojson" else 2)
    assert block.lod == "1" and block.closed and len(block.surfaces) == walls + 2
    assert volume(block) == pytest.approx(area * 12.5)
    z = model.world.to_world(model.bounds())[:, 2]
    np.testing.assert_allclose(z, [371.5, 384.0])


def test_footprints_without_a_usable_height_stay_flat(tmp_path: Path) -> None:
    for text in ("", "high", None, True):
        model = read_city_model(write(tmp_path / "f.geojson", geojson(height=text)), UTM)
        assert [s.lod for s in model.buildings[0].shells] == ["0"] and model.problems == ()
    model = read_city_model(write(tmp_path / "f.geojson", geojson(height=-3)), UTM)
    assert [s.lod for s in model.buildings[0].shells] == ["0"] and "-3 m" in model.problems[0].message


def test_a_geopackage_must_say_which_layer(tmp_path: Path) -> None:
    assert (
        len(read_city_model(geopackage(tmp_path / "a.gpkg", ("parcels", "Buildings_2024")), UTM).buildings)
        == 1
    )
    with pytest.raises(FileError, match="which of its layers of polygons holds the buildings: a, b"):
        read_city_model(geopackage(tmp_path / "b.gpkg", ("a", "b")), UTM)
    with pytest.raises(FileError, match="no layer of polygons"):
        read_city_model(geopackage(tmp_path / "c.gpkg", ()), UTM)
    whole = (tmp_path / "a.gpkg").read_bytes()
    (tmp_path / "d.gpkg").write_bytes(whole[: len(whole) // 3])
    with pytest.raises(FileError, match="not a readable city model"):
        read_city_model(tmp_path / "d.gpkg", UTM)
