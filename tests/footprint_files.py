"""Files of footprints for tests: GeoJSON as a table, GeoPackage as GDAL writes it."""

import sqlite3
import struct
from pathlib import Path

import shapely


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
