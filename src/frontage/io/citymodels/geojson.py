"""Footprints of GeoJSON (RFC 7946, its older "crs" member, sequences of RFC 8142) as drafts of buildings."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from frontage.geometry.arrays import Float
from frontage.io.citymodels.deferred import DeferredPlacement
from frontage.io.citymodels.draft import BuildingDraft
from frontage.io.citymodels.footprintdraft import footprint_draft
from frontage.io.citymodels.jsonstream import members

_NAMES = ("id", "gml_id", "fid", "osm_id", "ID")
_BAD = (IndexError, TypeError, KeyError, ValueError)


def read_geojson(path: Path, place: DeferredPlacement) -> Iterator[BuildingDraft]:
    """Yield the Polygons and MultiPolygons that touch the bounds. Raises ValueError on damaged files."""
    large = ("features",)
    stated = (value for _, name, key, value in members(path, large) if name == "crs" and key is None)
    place.state_crs(_crs(next(stated, None)), east_first=True)
    for number, feature in enumerate(_features(path), 1):
        geometry = feature.get("geometry") or {}
        if geometry.get("type") not in ("Polygon", "MultiPolygon"):
            continue
        properties = feature.get("properties") or {}
        name = feature["id"] if feature.get("id") is not None else _named(properties)
        problems: list[str] = []
        polygons = _polygons(geometry, problems)
        draft = footprint_draft(str(number if name is None else name), polygons, properties)
        draft.problems += problems
        if place.touches(draft.points()):
            yield draft


def _features(path: Path) -> Iterator[Mapping[str, Any]]:
    """Yield the features of a collection, of a single feature, or of a sequence of features."""
    single: dict[str, Any] = {}
    last = 0
    for document, name, key, value in members(path, ("features",)):
        if document > last:
            yield single
            single, last = {}, document
        if name == "features" and key is not None:
            yield value if isinstance(value, dict) else {}
        else:
            single[name] = value
    yield single


def _named(properties: Mapping[str, Any]) -> Any:
    return next((properties[n] for n in _NAMES if properties.get(n)), None)


def _polygons(geometry: Mapping[str, Any], problems: list[str]) -> list[list[Float]]:
    """The rings (k, 3) of every polygon, with NaN for heights that the file does not state."""
    found = []
    try:
        parts = geometry["coordinates"] if geometry["type"] == "MultiPolygon" else [geometry["coordinates"]]
        for part in parts:
            found.append([_ring(ring) for ring in part])
    except _BAD:
        problems.append("a broken list of coordinates")
    return found


def _ring(points: Any) -> Float:
    rows = np.array([[*p[:3], *[np.nan] * (3 - len(p))] for p in points], np.float64)
    return rows.reshape(-1, 3)


def _crs(member: Any) -> str:
    """The CRS of the older "crs" member where there is one, else longitude and latitude (RFC 7946)."""
    name = ((member or {}).get("properties") or {}).get("name")
    return str(name) if name else "OGC:CRS84"
