"""Writes a GeoPackage (OGC 12-128r18) with SQLite: one feature table per layer, columns described."""

import sqlite3
import struct
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import shapely
from pyproj import CRS

from frontage.io.crs import parse_crs
from frontage.io.files import whole_file
from frontage.io.tables.table import Column, Table

_APPLICATION_ID, _USER_VERSION = 0x47504B47, 10300  # "GPKG", version 1.3
_UNKNOWN_CRS, _OWN_CRS = -1, 100_000  # srs_id of "undefined Cartesian", and of a CRS without a code
_NEVER = "1970-01-01T00:00:00.000Z"  # the same run gives the same bytes, so the time of writing is not kept
_TYPES = {"text": "TEXT", "real": "DOUBLE", "whole": "INTEGER"}
_SYSTEM = """
CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER PRIMARY KEY,
  organization TEXT NOT NULL, organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL,
  description TEXT);
CREATE TABLE gpkg_contents (table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL,
  identifier TEXT UNIQUE, description TEXT DEFAULT '',
  last_change DATETIME NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')),
  min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER,
  CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id));
CREATE TABLE gpkg_geometry_columns (table_name TEXT NOT NULL, column_name TEXT NOT NULL,
  geometry_type_name TEXT NOT NULL, srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT NOT NULL,
  CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name),
  CONSTRAINT uk_gc_table_name UNIQUE (table_name),
  CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name),
  CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys (srs_id));
CREATE TABLE gpkg_extensions (table_name TEXT, column_name TEXT, extension_name TEXT NOT NULL,
  definition TEXT NOT NULL, scope TEXT NOT NULL,
  CONSTRAINT ge_tce UNIQUE (table_name, column_name, extension_name));
CREATE TABLE gpkg_data_columns (table_name TEXT NOT NULL, column_name TEXT NOT NULL, name TEXT,
  title TEXT, description TEXT, mime_type TEXT, constraint_name TEXT,
  CONSTRAINT pk_gdc PRIMARY KEY (table_name, column_name),
  CONSTRAINT gdc_tn UNIQUE (table_name, name));
CREATE TABLE gpkg_data_column_constraints (constraint_name TEXT NOT NULL, constraint_type TEXT NOT NULL,
  value TEXT, min NUMERIC, min_is_inclusive BOOLEAN, max NUMERIC, max_is_inclusive BOOLEAN,
  description TEXT, CONSTRAINT gdcc_ntv UNIQUE (constraint_name, constraint_type, value));
"""


def write_geopackage(path: Path, tables: Sequence[Table], crs: str | None) -> None:
    """Write every table as a layer of one GeoPackage; an older file of this name is replaced.

    crs  name of the CRS of geometries in the world; None, and for all others, an undefined Cartesian one

    Raises FileError when the file cannot be written, CrsError for an unknown CRS.
    """
    system = None if crs is None else parse_crs(crs)
    with whole_file(path) as temporary:
        temporary.unlink(missing_ok=True)
        with closing(sqlite3.connect(temporary)) as database, database:
            database.execute(f"PRAGMA application_id = {_APPLICATION_ID}")
            database.execute(f"PRAGMA user_version = {_USER_VERSION}")
            database.executescript(_SYSTEM)
            srs = _write_systems(database, system)
            _write_extension(database)
            for table in tables:
                _write_layer(database, table, srs if table.in_world else _UNKNOWN_CRS)


def _write_systems(database: sqlite3.Connection, system: CRS | None) -> int:
    """Write the three systems that the standard demands and the one of the data; return its srs_id."""
    rows = [
        ("Undefined Cartesian SRS", -1, "NONE", -1, "undefined", "undefined Cartesian coordinates"),
        ("Undefined geographic SRS", 0, "NONE", 0, "undefined", "undefined geographic coordinates"),
        _system_row(CRS.from_epsg(4326), 4326),
    ]
    srs = _UNKNOWN_CRS
    if system is not None:
        srs = system.to_epsg(min_confidence=100) or _OWN_CRS
        rows += [_system_row(system, srs)] if srs != 4326 else []
    database.executemany("INSERT INTO gpkg_spatial_ref_sys VALUES (?, ?, ?, ?, ?, ?)", rows)
    return srs


def _system_row(system: CRS, srs: int) -> tuple[str, int, str, int, str, str]:
    organization = "NONE" if srs == _OWN_CRS else "EPSG"
    return system.name, srs, organization, srs, system.to_wkt("WKT1_GDAL"), system.name


def _write_extension(database: sqlite3.Connection) -> None:
    """Declare the extension "schema", which describes columns."""
    definition = "http://www.geopackage.org/spec121/#extension_schema"
    rows = [
        (name, None, "gpkg_schema", definition, "read-write")
        for name in ("gpkg_data_columns", "gpkg_data_column_constraints")
    ]
    database.executemany("INSERT INTO gpkg_extensions VALUES (?, ?, ?, ?, ?)", rows)


def _write_layer(database: sqlite3.Connection, table: Table, srs: int) -> None:
    columns = ", ".join(f'"{c.name}" {_TYPES[c.kind]}' for c in table.columns)
    database.execute(
        f'CREATE TABLE "{table.name}" (fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, '
        f"geom {table.geometry}, {columns})"
    )
    places = [g for g in table.geometries if g is not None]
    bounds = shapely.total_bounds(places).tolist() if places else [None] * 4
    database.execute(
        "INSERT INTO gpkg_contents VALUES (?, 'features', ?, ?, ?, ?, ?, ?, ?, ?)",
        (table.name, table.name, table.about, _NEVER, *bounds, srs),
    )
    database.execute(
        "INSERT INTO gpkg_geometry_columns VALUES (?, 'geom', ?, ?, ?, 0)",
        (table.name, table.geometry, srs, int(table.height)),
    )
    _write_descriptions(database, table.name, table.columns)
    marks = ", ".join("?" * (len(table.columns) + 1))
    names = ", ".join(["geom", *(f'"{c.name}"' for c in table.columns)])
    rows = (
        (None if place is None else _blob(place, srs), *row)
        for place, row in zip(table.geometries, table.rows, strict=True)
    )
    database.executemany(f'INSERT INTO "{table.name}" ({names}) VALUES ({marks})', rows)


def _write_descriptions(database: sqlite3.Connection, layer: str, columns: Sequence[Column]) -> None:
    rows = [(layer, c.name, c.name, c.name.replace("_", " "), c.description, None, None) for c in columns]
    database.executemany("INSERT INTO gpkg_data_columns VALUES (?, ?, ?, ?, ?, ?, ?)", rows)


def _blob(place: shapely.Geometry, srs: int) -> bytes:
    """The standard's binary form: magic, version, flags (little-endian, envelope x y), envelope, ISO WKB."""
    x0, y0, x1, y1 = place.bounds
    head = struct.pack("<2sBBi4d", b"GP", 0, 0b0000_0011, srs, x0, x1, y0, y1)
    wkb: bytes = shapely.to_wkb(place, byte_order=1, flavor="iso")
    return head + wkb
