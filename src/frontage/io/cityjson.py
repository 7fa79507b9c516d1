"""Writing CityJSON 2.0: buildings as solids with semantic surfaces, vertices shared and in 0.1 mm."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.io.address import split_address
from frontage.io.crs import parse_crs
from frontage.io.files import whole_file
from frontage.model import WorldRef
from frontage.model.citymodel import CityBuilding, Shell

_STEP = 1e-4  # m: the grid that vertices are shared on
_SKIPPED = {"source_id", "type"}


def write_cityjson(path: str | Path, buildings: Sequence[CityBuilding], world: WorldRef, title: str) -> Path:
    """Write buildings whose polygons are in local metres of `world`.

    Every semantic surface carries the `id` of its polygon and its attributes. The bytes depend on the
    arguments alone.

    Raises FileError (cannot be written), CrsError.
    """
    vertices = _Vertices()
    objects = {b.id: _object(b, vertices) for b in buildings}
    table = vertices.table
    extent = world.to_world(np.concatenate([table.min(0), table.max(0)]).reshape(2, 3) * _STEP)
    metadata: dict[str, Any] = {"title": title, "geographicalExtent": extent.ravel().round(4).tolist()}
    if code := _code(world):
        metadata["referenceSystem"] = code
    model = {
        "type": "CityJSON",
        "version": "2.0",
        "metadata": metadata,
        "transform": {"scale": [_STEP] * 3, "translate": [float(v) for v in world.origin]},
        "CityObjects": objects,
        "vertices": table.tolist(),
    }
    p = Path(path)
    with whole_file(p) as temporary:
        temporary.write_text(json.dumps(model, ensure_ascii=False, separators=(",", ":")) + "\n", "utf-8")
    return p


class _Vertices:
    """Points on the grid, each once, numbered in the order of their first use."""

    def __init__(self) -> None:
        self._number: dict[tuple[int, ...], int] = {}

    def numbers(self, ring: Float) -> list[int]:
        """Vertex numbers of a ring (k, 3) m; neighbours that fall on one place are one."""
        points = [tuple(p) for p in np.rint(np.asarray(ring) / _STEP).astype(np.int64).tolist()]
        found = [self._number.setdefault(p, len(self._number)) for p in points]
        return [n for n, before in zip(found, [found[-1], *found[:-1]], strict=True) if n != before]

    @property
    def table(self) -> Int:
        """All points (v, 3) int64 in grid steps."""
        return np.array(list(self._number), np.int64).reshape(-1, 3)


def _object(building: CityBuilding, vertices: _Vertices) -> dict[str, Any]:
    attributes = dict(building.attributes)
    out: dict[str, Any] = {"type": "Building"}
    if building.address:
        number, street = split_address(building.address)
        attributes["address"] = building.address
        named = {"ThoroughfareNumber": number, "ThoroughfareName": street}
        out["address"] = [{name: text for name, text in named.items() if text}]
    out["attributes"] = attributes
    out["geometry"] = [_solid(shell, vertices) for shell in building.shells]
    return out


def _solid(shell: Shell, vertices: _Vertices) -> dict[str, Any]:
    """A Solid of one shell; polygons that the grid made too small to have three corners are left out."""
    boundaries, surfaces = [], []
    for s in shell.surfaces:
        rings = [ring for r in (s.ring, *s.holes) if len(ring := vertices.numbers(r)) >= 3]
        if rings:
            boundaries.append(rings)
            surfaces.append(_semantics(s.semantics, s.source_id, shell.about.get(s.source_id, {})))
    return {
        "type": "Solid",
        "lod": shell.lod,
        "boundaries": [boundaries],
        "semantics": {"surfaces": surfaces, "values": [list(range(len(surfaces)))]},
    }


def _semantics(kind: str, number: str, about: Mapping[str, Any]) -> dict[str, Any]:
    named = {"id": number} if number else {}
    return {"type": kind, **named, **{k: v for k, v in about.items() if k not in _SKIPPED}}


def _code(world: WorldRef) -> str | None:
    """The CRS as OGC URL; of a compound CRS its horizontal part's code, when it has no code of its own."""
    if world.crs is None:
        return None
    crs = parse_crs(world.crs)
    authority = crs.to_authority() or (crs.sub_crs_list[0].to_authority() if crs.sub_crs_list else None)
    return f"https://www.opengis.net/def/crs/{authority[0]}/0/{authority[1]}" if authority else None
