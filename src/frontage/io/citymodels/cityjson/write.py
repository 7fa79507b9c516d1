"""Writing CityJSON 2.0: buildings as solids with semantic surfaces, shared vertices in steps of 0.1 mm."""

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.io.citymodels.address import split_address
from frontage.io.citymodels.cityjson.appearance import THEME, Appearance
from frontage.io.crs import parse_crs
from frontage.io.files import whole_file
from frontage.model import Surface, WorldRef
from frontage.model.citymodel import CityBuilding, Shell

_STEP_M = 1e-4  # of the grid that vertices are rounded to
_CORNERS = 3  # of a ring, at least
_SKIPPED = {"source_id", "type", "parent", "children"}


def write_cityjson(
    path: str | Path,
    buildings: Sequence[CityBuilding],
    world: WorldRef,
    title: str,
    left_out: Sequence[str] = (),
) -> Path:
    """Write buildings whose polygons are in local metres of `world`; equal arguments give equal bytes.

    Every semantic surface has the `id` of its polygon and its attributes; polygons that share an id are one
    surface. The attribute `parent` of an opening, which is the id of its wall, becomes the relation of
    CityJSON. Shells of parts and installations become objects of their own; those of window frames become
    constructive elements, whose polygons have no semantic surfaces. Textures refer to their pictures.

    `left_out`, sentences on what the model does not show, follow the title: the schema of the metadata has no
    other place for words.

    Raises FileError when the file cannot be written, and CrsError.
    """
    vertices, appearance = _Vertices(), Appearance()
    objects = {name: thing for b in buildings for name, thing in _objects(b, vertices, appearance)}
    table = vertices.table
    extent = world.to_world(np.concatenate([table.min(0), table.max(0)]).reshape(2, 3) * _STEP_M)
    about = f"{title}. Left out: {' '.join(left_out)}" if left_out else title
    metadata: dict[str, Any] = {"title": about, "geographicalExtent": extent.ravel().round(4).tolist()}
    if code := _code(world):
        metadata["referenceSystem"] = code
    model = {
        "type": "CityJSON",
        "version": "2.0",
        "metadata": metadata,
        "transform": {"scale": [_STEP_M] * 3, "translate": [float(v) for v in world.origin]},
        "CityObjects": objects,
        **({"appearance": appearance.to_json()} if appearance else {}),
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

    def numbers(self, ring: Float) -> tuple[list[int], list[int]]:
        """The vertex numbers of a ring (k, 3) m, and which corners they are of.

        Of neighbours that round to the same point only the first is kept.
        """
        points = [tuple(p) for p in np.rint(np.asarray(ring) / _STEP_M).astype(np.int64).tolist()]
        found = [self._number.setdefault(p, len(self._number)) for p in points]
        kept = [k for k, n in enumerate(found) if n != found[k - 1]]
        return [found[k] for k in kept], kept

    @property
    def table(self) -> Int:
        """All points (v, 3) int64 in grid steps."""
        return np.array(list(self._number), np.int64).reshape(-1, 3)


def _objects(
    building: CityBuilding, vertices: _Vertices, appearance: Appearance
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the objects of a building: itself, then its parts and installations."""
    whole = _building(building)
    members: dict[str, dict[str, Any]] = {building.id: whole}
    for shell in building.shells:
        name = shell.part or building.id
        if name not in members:
            about = {"attributes": dict(shell.attributes)} if shell.attributes else {}
            members[name] = {"type": _kind(shell), "parents": [building.id], **about, "geometry": []}
            whole.setdefault("children", []).append(name)
        members[name]["geometry"].append(_geometry(shell, vertices, appearance))
    yield from members.items()


def _kind(shell: Shell) -> str:
    """The type of the object that a shell other than the building's own belongs to."""
    if shell.frame_of:
        return "BuildingConstructiveElement"
    return "BuildingInstallation" if shell.installation else "BuildingPart"


def _building(building: CityBuilding) -> dict[str, Any]:
    attributes = dict(building.attributes)
    out: dict[str, Any] = {"type": "Building"}
    if building.address:
        number, street = split_address(building.address)
        attributes["address"] = building.address
        named = {"ThoroughfareNumber": number, "ThoroughfareName": street}
        out["address"] = [{name: text for name, text in named.items() if text}]
    return {**out, "attributes": attributes, "geometry": []}


def _geometry(shell: Shell, vertices: _Vertices, appearance: Appearance) -> dict[str, Any]:
    """A Solid of one shell; a MultiSurface where it is not closed, a CompositeSurface for a window's frame.

    Polygons with fewer than three corners on the grid are left out.
    """
    boundaries, meant, shown = [], [], []
    for s in shell.surfaces:
        rings = [vertices.numbers(r) for r in (s.ring, *s.holes)]
        texture = shell.textures.get(s.source_id)
        places = appearance.polygon(texture, [kept for _, kept in rings])
        whole = [k for k, (ring, _) in enumerate(rings) if len(ring) >= _CORNERS]
        if whole:
            boundaries.append([rings[k][0] for k in whole])
            shown.append([places[k] for k in whole])
            meant.append(s)
    open_kind = "CompositeSurface" if shell.frame_of else "MultiSurface"
    geometry: dict[str, Any] = {
        "type": "Solid" if shell.closed else open_kind,
        "lod": shell.lod,
        "boundaries": [boundaries] if shell.closed else boundaries,
    }
    if shell.textures:
        geometry["texture"] = {THEME: {"values": [shown] if shell.closed else shown}}
    if not any(s.semantics for s in meant):
        return geometry
    surfaces, values = _meanings(meant, shell.about)
    return {**geometry, "semantics": {"surfaces": surfaces, "values": [values] if shell.closed else values}}


def _meanings(
    polygons: Sequence[Surface], about: Mapping[str, Mapping[str, Any]]
) -> tuple[list[dict[str, Any]], list[int]]:
    """The semantic surfaces, one per id and class, and the number of every polygon's surface."""
    number: dict[tuple[str, str], int] = {}
    surfaces: list[dict[str, Any]] = []
    values = []
    for k, s in enumerate(polygons):
        key = (s.source_id or f"#{k}", s.semantics)
        if key not in number:
            number[key] = len(surfaces)
            surfaces.append(_semantics(s.semantics, s.source_id, about.get(s.source_id, {})))
        values.append(number[key])
    of_id = {name: k for (name, _), k in number.items()}
    for (name, _), k in number.items():
        parent = of_id.get(str(about.get(name, {}).get("parent", "")))
        if parent is not None and parent != k:
            surfaces[k]["parent"] = parent
            surfaces[parent].setdefault("children", []).append(k)
    return surfaces, values


def _semantics(kind: str, number: str, about: Mapping[str, Any]) -> dict[str, Any]:
    named = {"id": number} if number else {}
    return {"type": kind, **named, **{k: v for k, v in about.items() if k not in _SKIPPED}}


def _code(world: WorldRef) -> str | None:
    """The CRS as an OGC URL; a compound CRS without a code is written as its horizontal part."""
    if world.crs is None:
        return None
    crs = parse_crs(world.crs)
    authority = crs.to_authority() or (crs.sub_crs_list[0].to_authority() if crs.sub_crs_list else None)
    return f"https://www.opengis.net/def/crs/{authority[0]}/0/{authority[1]}" if authority else None
