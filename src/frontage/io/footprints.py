"""Building footprints from CityJSON, CityGML and GeoJSON: where one house ends and the next begins.

Of a city model the ground surfaces are taken; where there are none, the coarsest level seen from above.
XML is read without entities, DTDs or network.
"""

import json
import logging
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from pyproj import CRS

from frontage.errors import FileError
from frontage.geometry.arrays import Float
from frontage.io.citygml import citygml_outlines
from frontage.io.crs import parse_crs
from frontage.io.files import reading, require_file
from frontage.io.outlines import Outline, Polygons
from frontage.io.placement import Placement, Wanted
from frontage.model import WorldRef
from frontage.model.building import Footprint

log = logging.getLogger(__name__)
_SLIVER = 0.5  # m2: smaller pieces are gaps between badly joined surfaces, not buildings


def read_footprints(path: str | Path, world: WorldRef, crs: str | None = None) -> tuple[Footprint, ...]:
    """The outline of every building of a map or city model, local metres, counter-clockwise, not closed.

    A building in several separate pieces gives one footprint per piece, with "#2", ... behind its id.

    Raises FileError (missing, truncated, corrupt, no buildings), CrsError (no CRS where the world has one,
    or the other way round).
    """
    p = require_file(path)
    wanted = Wanted(p.name, world, None if world.crs is None else world.crs, crs)
    outlines, file_crs = _outlines(p)
    if not outlines:
        raise FileError(
            p, "holds no buildings with a footprint", "name a CityJSON, CityGML or GeoJSON file", code="I105"
        )
    sample = np.vstack([ring for o in outlines for ring in o.polygons])
    place = wanted.place(file_crs, sample)
    for note in place.notes:
        log.warning(note)
    found = [f for o in outlines for f in _footprints(o, place)]
    if not found:
        raise FileError(p, "holds no buildings with a footprint", "check the model", code="I105")
    return tuple(found)


def _outlines(path: Path) -> tuple[Sequence[Outline], CRS | None]:
    """Buildings of any of the three formats, told by content, and the CRS that they state."""
    with reading(path, "city model or footprint", "name a CityJSON, CityGML or GeoJSON file"):
        with open(path, "rb") as f:
            head = f.read(4096).lstrip(b"\xef\xbb\xbf \t\r\n")
        if head[:1] == b"<":
            outlines, text = citygml_outlines(path)
        elif head[:1] == b"{":
            data = json.loads(path.read_text("utf-8-sig"))
            kind = data.get("type")
            if kind == "CityJSON":
                outlines, text = list(_cityjson(data)), data.get("metadata", {}).get("referenceSystem")
            elif kind in ("FeatureCollection", "Feature"):
                outlines, text = list(_geojson(data)), _geojson_crs(data)
            else:
                raise ValueError(f"JSON of type {kind!r}")
        else:
            raise ValueError("neither XML nor JSON")
    return outlines, parse_crs(text, str(path)) if text else None


@dataclass(frozen=True)
class _Geometry:
    """One CityJSON geometry: level of detail, outer rings (k, 3) of its polygons and their classes."""

    lod: float
    rings: Polygons
    classes: tuple[str | None, ...]


def _cityjson(data: dict[str, Any]) -> Iterator[Outline]:
    """Every Building, its parts included. CityJSON 1.0, 1.1 and 2.0."""
    vertices = np.asarray(data["vertices"], np.float64).reshape(-1, 3)
    if "transform" in data:
        vertices = vertices * data["transform"]["scale"] + data["transform"]["translate"]
    objects: dict[str, Any] = data["CityObjects"]
    for key, o in objects.items():
        parents = [q for q in o.get("parents", []) if q in objects]
        if o["type"] == "Building" or (o["type"] == "BuildingPart" and not parents):
            family = [
                o,
                *(
                    objects[c]
                    for c in o.get("children", [])
                    if c in objects and objects[c]["type"] == "BuildingPart"
                ),
            ]
            geometries = [_geometry(g, vertices) for member in family for g in member.get("geometry", [])]
            polygons = _ground(geometries)
            if polygons:
                yield Outline(key, polygons, _address(o.get("attributes", {}) | _first_address(o)))


def _first_address(o: dict[str, Any]) -> dict[str, Any]:
    addresses = o.get("address") or []
    return dict(addresses[0]) if isinstance(addresses, list) and addresses else {}


def _geometry(g: dict[str, Any], vertices: Float) -> _Geometry:
    """Outer rings of a MultiSurface, CompositeSurface, Solid or MultiSolid, with their classes."""
    surfaces, values = g.get("boundaries", []), g.get("semantics", {}).get("values")
    depth = {"MultiSurface": 0, "CompositeSurface": 0, "Solid": 1, "MultiSolid": 2, "CompositeSolid": 2}.get(
        g["type"]
    )
    if depth is None:
        return _Geometry(float(g.get("lod", 0)), (), ())
    for _ in range(depth):
        surfaces = [s for shell in surfaces for s in shell]
        values = None if values is None else [v for shell in values for v in (shell or [])]
    names = [s.get("type") for s in g.get("semantics", {}).get("surfaces", [])]
    classes = tuple(None if v is None else names[v] for v in values) if values else (None,) * len(surfaces)
    if len(classes) != len(surfaces):
        classes = (None,) * len(surfaces)
    rings = tuple(vertices[np.asarray(s[0], np.int64)] for s in surfaces)
    return _Geometry(float(g.get("lod", 0)), rings, classes)


def _ground(geometries: Sequence[_Geometry]) -> Polygons:
    """Ground surfaces of the coarsest geometries that have them, else the whole coarsest geometry."""
    ordered = sorted(geometries, key=lambda g: g.lod)
    for lod in dict.fromkeys(g.lod for g in ordered):
        rings = tuple(
            r
            for g in ordered
            if g.lod == lod
            for r, c in zip(g.rings, g.classes, strict=True)
            if c == "GroundSurface"
        )
        if rings:
            return rings
    filled = [g for g in ordered if g.rings]
    return tuple(r for g in filled if g.lod == filled[0].lod for r in g.rings)


def _geojson(data: dict[str, Any]) -> Iterator[Outline]:
    """Polygons and MultiPolygons of a FeatureCollection."""
    for k, f in enumerate(data["features"] if data["type"] == "FeatureCollection" else [data]):
        geometry, properties = f.get("geometry") or {}, f.get("properties") or {}
        if geometry.get("type") not in ("Polygon", "MultiPolygon"):
            continue
        single = geometry["type"] == "Polygon"
        parts = [geometry["coordinates"]] if single else geometry["coordinates"]
        rings = tuple(_three(part[0]) for part in parts)
        named = next(
            (properties[n] for n in ("id", "gml_id", "fid", "osm_id", "ID") if properties.get(n)), None
        )
        number = f.get("id") if f.get("id") is not None else named
        yield Outline(str(number if number is not None else k + 1), rings, _address(properties))


def _three(ring: Any) -> Float:
    """A GeoJSON ring as (k, 3), heights 0 where it has none."""
    a = np.array([list(p[:3]) + [0.0] * (3 - len(p[:3])) for p in ring], np.float64)
    return a.reshape(-1, 3)


def _geojson_crs(data: dict[str, Any]) -> str:
    """The old "crs" member where there is one, else longitude and latitude (RFC 7946)."""
    name = (data.get("crs") or {}).get("properties", {}).get("name")
    return str(name) if name else "OGC:CRS84"


def _address(properties: dict[str, Any]) -> str | None:
    """A readable address from the usual attribute names, or None."""
    p = {str(k).lower(): v for k, v in properties.items() if isinstance(v, str | int) and str(v).strip()}
    if "address" in p:
        return str(p["address"])
    street = p.get("addr:street", p.get("thoroughfarename", p.get("street")))
    number = p.get("addr:housenumber", p.get("thoroughfarenumber", p.get("housenumber")))
    return " ".join(str(v) for v in (number, street) if v is not None) or None if street else None


def _footprints(o: Outline, place: Placement) -> Iterator[Footprint]:
    """The union of an outline's polygons seen from above, piece by piece, largest first."""
    flat = [shapely.Polygon(place.to_local(ring)[:, :2]) for ring in o.polygons if len(ring) >= 3]
    whole = shapely.union_all([shapely.make_valid(q) for q in flat if q.area > 0])
    pieces = [q for q in shapely.get_parts(whole) if q.geom_type == "Polygon" and q.area >= _SLIVER]
    for k, piece in enumerate(sorted(pieces, key=lambda q: -q.area), 1):
        closed = shapely.get_coordinates(shapely.get_exterior_ring(piece))
        ring = closed[:-1] if shapely.is_ccw(shapely.get_exterior_ring(piece)) else closed[:0:-1]
        yield Footprint(o.id if k == 1 else f"{o.id}#{k}", ring, o.address)
