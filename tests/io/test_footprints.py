"""Footprints of maps, with heights and without."""

import sqlite3
import struct
from pathlib import Path

import numpy as np
import pytest
import shapely

from city_files import volume, write
from frontage.errors import FileError
from frontage.io.citymodels.read import read_city_model
from io_files import UTM


def geojson(**properties: object) -> dict:
    square = [[0, 0], [10, 0], [10, 8], [0, 8], [0, 0]]
    hole = [[2, 2], [2, 4], [4, 4], [4, 2], [2, 2]]
    rings = [[[x + 678000, y + 5403000] for x, y in ring] for ring in (square, hole)]
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::25832"}}
    feature = {
        "type": "Feature",
        "properties": properties,
        "geometry": {"type": "Polygon", "coordinates": rings},
    }
    return {"type": "FeatureCollection", "features": [feature], "crs": crs}


def geopackage(path: Path, tables: tuple[str, ...] = ("footprints",), z: bool = False) -> Path:
    """As GDAL writes it: header with an envelope, WKB."""
    outer = shapely.box(678000, 5403000, 678010, 5403008, ccw=False)
    shape = shapely.Polygon(
        outer.exterior.coords, [[(678002, 5403002), (678004, 5403002), (678004, 5403004)]]
    )
    if z:
        shape = shapely.force_3d(shape, 371.5)
    blob = (
        b"GP\x00\x03" + struct.pack("<i4d", 25832, 678000, 678010, 5403000, 5403008) + shapely.to_wkb(shape)
    )
    with sqlite3.connect(path) as db:
        db.execute(
            "CREATE TABLE gpkg_spatial_ref_sys "
            "(srs_name, srs_id, organization, organization_coordsys_id, definition)"
        )
        db.execute(
            "CREATE TABLE gpkg_geometry_columns (table_name, column_name, geometry_type_name, srs_id, z, m)"
        )
        db.execute("INSERT INTO gpkg_spatial_ref_sys VALUES ('x', 25832, 'EPSG', 25832, '')")
        for name in tables:
            db.execute(
                "INSERT INTO gpkg_geometry_columns VALUES (?, 'geom', 'MULTIPOLYGON', 25832, 0, 0)", (name,)
            )
            db.execute(
                f'CREATE TABLE "{name}" (fid INTEGER PRIMARY KEY, geom BLOB, street, housenumber, height)'
            )
            db.execute(f'INSERT INTO "{name}" VALUES (7, ?, ?, ?, 12.5)', (blob, "rue Soufflot", "13"))
            db.execute(f'INSERT INTO "{name}" VALUES (8, NULL, NULL, NULL, NULL)')
    db.close()
    return path


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
