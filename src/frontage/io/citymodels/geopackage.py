"""Footprints of a GeoPackage (OGC 12-128) as drafts of buildings, read with SQLite, without curves."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.io.citymodels.deferred import DeferredPlacement
from frontage.io.citymodels.draft import BuildingDraft
from frontage.io.citymodels.footprintdraft import footprint_draft
from frontage.io.citymodels.wkb import polygons_of

_POLYGONS = ("POLYGON", "MULTIPOLYGON", "SURFACE", "MULTISURFACE", "GEOMETRY", "GEOMETRYCOLLECTION")
_NAMED = ("building", "footprint", "gebaeude", "gebäude", "pand", "batiment", "bâtiment", "edifici")
_ENVELOPES = {0: 0, 1: 32, 2: 48, 3: 48, 4: 64}  # bytes, by the kind in the flags (12-128r18, table 6)
_HEAD = 8


@dataclass(frozen=True)
class _Layer:
    """A feature table: its name, its geometry column, its primary key, its CRS ("EPSG:25832" or WKT)."""

    table: str
    column: str
    key: str | None
    crs: str | None


def read_geopackage(path: Path, place: DeferredPlacement) -> Iterator[BuildingDraft]:
    """Yield the polygons of the layer of buildings that touch the bounds.

    Of several layers of polygons, the one whose name contains a word for buildings or footprints is taken.

    Raises sqlite3.DatabaseError on damaged files, and ValueError when no layer or several layers qualify.
    """
    uri = f"file:{quote(str(path.resolve()))}?mode=ro&immutable=1"
    with closing(sqlite3.connect(uri, uri=True)) as database:
        database.row_factory = sqlite3.Row
        layer = _chosen(_layers(database))
        place.state_crs(layer.crs)
        rows = database.execute(f"SELECT * FROM {_quoted(layer.table)}")
        for number, row in enumerate(rows, 1):
            properties = {k: row[k] for k in row.keys() if k not in (layer.column, layer.key)}  # noqa: SIM118
            name = next((properties[n] for n in ("id", "gml_id", "osm_id") if properties.get(n)), None)
            if name is None and layer.key:
                name = row[layer.key]
            polygons, problems = _polygons(row[layer.column])
            draft = footprint_draft(str(number if name is None else name), polygons, properties)
            draft.problems += problems
            if (polygons or problems) and place.touches(draft.points()):
                yield draft


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


def _layers(database: sqlite3.Connection) -> list[_Layer]:
    """The feature tables that may hold polygons."""
    rows = database.execute(
        "SELECT g.table_name, g.column_name, g.geometry_type_name, s.organization, "
        "s.organization_coordsys_id, s.definition FROM gpkg_geometry_columns g "
        "LEFT JOIN gpkg_spatial_ref_sys s ON g.srs_id = s.srs_id ORDER BY g.table_name"
    ).fetchall()
    layers = []
    for table, column, kind, authority, code, definition in rows:
        if str(kind).upper() in _POLYGONS:
            keys = database.execute(f"PRAGMA table_info({_quoted(table)})").fetchall()
            key = next((k["name"] for k in keys if k["pk"]), None)
            layers.append(_Layer(table, column, key, _crs(authority, code, definition)))
    return layers


def _crs(authority: str | None, code: int | None, definition: str | None) -> str | None:
    """The name of a CRS; None for the two undefined ones (srs_id 0 and -1)."""
    if authority is None or str(authority).upper() == "NONE":
        return None
    return f"{authority}:{code}" if str(authority).upper() == "EPSG" else definition


def _chosen(layers: list[_Layer]) -> _Layer:
    named = [layer for layer in layers if any(word in layer.table.lower() for word in _NAMED)]
    if len(layers) == 1:
        return layers[0]
    if len(named) == 1:
        return named[0]
    if not layers:
        raise ValueError("it has no layer of polygons")
    names = ", ".join(layer.table for layer in layers)
    raise ValueError(f"which of its layers of polygons holds the buildings: {names}? name that one buildings")


def _polygons(blob: Any) -> tuple[list[list[Float]], list[str]]:
    """The rings (k, 3) of a geometry's polygons, NaN for missing heights, and what is wrong with it."""
    if blob is None:
        return [], []
    short = not isinstance(blob, bytes) or len(blob) < _HEAD or blob[:2] != b"GP"
    if short or (blob[3] >> 1) & 7 not in _ENVELOPES:
        return [], ["a geometry that is not a GeoPackage's"]
    try:
        parts = polygons_of(blob[_HEAD + _ENVELOPES[(blob[3] >> 1) & 7] :])
    except ValueError as problem:
        return [], [str(problem)]
    return [[_ring(r) for r in (p.exterior, *p.interiors)] for p in parts], []


def _ring(ring: Any) -> Float:
    return np.asarray(shapely.get_coordinates(ring, include_z=True), np.float64)
