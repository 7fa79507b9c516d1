"""The coarse solid that a facade is put into: a building of a city model, or a block made from a facade."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from scipy.spatial import cKDTree
from shapely.geometry import Polygon

from frontage.geometry.arrays import Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import polygon_ring
from frontage.model import Face, Failed, Solid, Surface, WorldRef
from frontage.solids.hosts.repair import flattened, grounded, noded
from frontage.solids.hosts.sewing import lidded, sewn
from frontage.solids.log import Log
from frontage.solids.relief import GRID
from frontage.solids.rims import normal, unmatched, volume6, without_repeats

_WELD = 10  # 0.1 mm: vertices this close are one, as for the validator
_UP = 0.5  # vertical part of the normal of a roof or ground of a block


@dataclass(frozen=True, eq=False)
class Host:
    """A closed coarse solid, and what had to be done to get it."""

    solid: Solid
    notes: tuple[str, ...] = ()


def host_solid(
    building: str, surfaces: Sequence[Surface], world: WorldRef, lod: str = "2", lid: bool = False
) -> Host | Failed:
    """The polygons of a building (rings (k, 3) m local, counter-clockwise from outside) as a closed solid.

    Vertices go to the grid of 0.1 mm and are not moved otherwise. Repaired with a note: vertices up to 1 mm
    apart, vertices on edges of others, faces that all look inwards, a missing ground, faces that are not
    flat, free edges up to 0.1 m apart (`sewing.sewn`); with `lid` also a roof that does not meet its walls,
    which is replaced (`sewing.lidded`). Everything else is S302 (no faces) or S303 (not closed).
    """
    log = Log()
    vertices, faces = _welded(surfaces, log, building)
    if len(faces) < 4:
        hint = "use another level of detail, or a block made from the facade"
        return Failed("S302", f"{building}: only {len(faces)} usable polygons, no solid", hint)
    solid = noded(Solid(building, vertices, world.origin, tuple(faces), lod), log)
    solid = grounded(solid, log)
    if unmatched(solid.faces):
        solid = sewn(solid, log)
    if lid and unmatched(solid.faces):
        solid = lidded(solid, log)
    loose = unmatched(solid.faces)
    if loose:
        x, y, z = (vertices[loose[0][0]] / GRID + world.origin).tolist()
        where = f"{len(loose)} edges have no partner, one at {x:.2f} {y:.2f} {z:.2f}"
        hint = "repair the model, or use a block made from the ground or the facade"
        return Failed("S303", f"{building}: the host is not closed, {where}", hint)
    if volume6(solid) < 0:
        log.notes.append(f"{building}: all faces looked inwards and have been turned")
        turned = [Face(f.ring[::-1], f.semantics, tuple(h[::-1] for h in f.holes)) for f in solid.faces]
        solid = replace(solid, faces=tuple(turned))
    return Host(flattened(solid, log), tuple(log.notes))


def _welded(surfaces: Sequence[Surface], log: Log, building: str) -> tuple[Int, list[Face]]:
    """Vertices on the grid, those within the snap tolerance joined, and faces without repeated vertices."""
    rings = [r for s in surfaces for r in (s.ring, *s.holes)]
    if not rings:
        return np.zeros((0, 3), np.int64), []
    grid = np.rint(np.concatenate(rings) * GRID).astype(np.int64)
    unique, number = np.unique(grid, axis=0, return_inverse=True)
    joined = _joined(unique)
    if (joined != np.arange(len(joined))).any():
        log.notes.append(f"{building}: vertices up to {_WELD / GRID:g} m apart have been joined")
    number = joined[number.ravel()]
    faces, start = [], 0
    for surface in surfaces:
        own = []
        for ring in (surface.ring, *surface.holes):
            own.append(without_repeats(number[start : start + len(ring)].tolist()))
            start += len(ring)
        if len(own[0]) > 2:
            faces.append(Face(own[0], surface.semantics, tuple(h for h in own[1:] if len(h) > 2)))
    return unique, faces


def _joined(grid: Int) -> Int:
    """For every vertex the first one within the tolerance of it."""
    first = np.arange(len(grid))
    pairs = cKDTree(grid.astype(np.float64)).query_pairs(_WELD, output_type="ndarray")
    for a, b in sorted(map(tuple, np.sort(pairs, axis=1).tolist())):
        first[b] = min(first[b], first[a])
    return first


def ground_block(
    building: str, surfaces: Sequence[Surface], world: WorldRef, top: float | None = None
) -> Host | Failed:
    """An upright block over a building's one ground polygon, up to `top` (m local; None: its highest wall).

    The host where a model's walls and roof do not close: walls in plan as in the model, the roof flat.
    """
    grounds = [s for s in surfaces if s.semantics == "GroundSurface"]
    walls = [s.ring[:, 2].max() for s in surfaces if s.semantics == "WallSurface"]
    if len(grounds) != 1 or (top is None and not walls):
        hint = "use a block made from the facade"
        return Failed(
            "S304", f"{building}: {len(grounds)} ground polygons, a block needs one and a top", hint
        )
    high = float(max(walls)) if top is None else top
    rings = (grounds[0].ring, *grounds[0].holes)
    up = normal(rings[0])[2] > 0
    lower = [r[::-1] if up else r for r in rings]
    upper = [np.column_stack([r[:, :2], np.full(len(r), high)])[::-1] for r in lower]
    shell = [Surface(lower[0], "GroundSurface", "", tuple(lower[1:]))]
    shell.append(Surface(upper[0], "RoofSurface", "", tuple(upper[1:])))
    for low_ring, high_ring in zip(lower, upper, strict=True):
        above = high_ring[::-1]
        for a in range(len(low_ring)):
            b = (a + 1) % len(low_ring)
            side = np.array([low_ring[b], low_ring[a], above[a], above[b]])
            shell.append(Surface(side, "WallSurface"))
    made = host_solid(building, shell, world, "1")
    if not isinstance(made, Host):
        return made
    note = f"{building}: a block over its ground polygon up to {high:.2f} m stands for the city model's solid"
    return Host(made.solid, (note, *made.notes))


def facade_block(
    building: str, local_from_facade: Rigid3, outline: Float, depth: float, world: WorldRef
) -> Host | Failed:
    """A block behind a facade: its outline (k, 2) m (x, z) extruded `depth` m along its level normal.

    The host where there is no city model. The front and the back are walls; sides that look up are roof,
    those that look down ground.
    """
    raw = Polygon(outline)
    if not raw.is_valid or raw.area == 0 or depth <= 0:
        return Failed("S304", f"{building}: the facade's outline makes no block", "check outline and depth")
    polygon = shapely.set_precision(raw, 1 / GRID).simplify(1 / GRID)
    if not isinstance(polygon, Polygon) or polygon.is_empty:
        return Failed("S304", f"{building}: the facade's outline is too thin", "check outline and depth")
    ring = polygon_ring(polygon)
    front = local_from_facade.apply(np.insert(ring, 1, 0.0, axis=1))
    inward = local_from_facade.R[:, 1] * np.array([1.0, 1.0, 0.0])
    back = front + depth * inward / np.linalg.norm(inward)
    grid = np.rint(np.concatenate([front, back]) * GRID).astype(np.int64)
    k = len(ring)
    faces = [Face(tuple(range(k)), "WallSurface"), Face(tuple(range(2 * k - 1, k - 1, -1)), "WallSurface")]
    for a in range(k):
        b = (a + 1) % k
        side = (b, a, a + k, b + k)
        up = float(normal(grid[list(side)] / GRID)[2])
        kind = "RoofSurface" if up > _UP else "GroundSurface" if up < -_UP else "WallSurface"
        faces.append(Face(side, kind))
    note = f"{building}: no city model; a block of {depth:g} m behind the facade stands for it"
    return Host(Solid(building, grid, world.origin, tuple(faces), "1"), (note,))
