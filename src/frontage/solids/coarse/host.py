"""Makes a closed solid on the integer grid from the polygons of a building in a city model."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Int
from frontage.model import Face, Failed, Solid, Surface, WorldRef
from frontage.solids.brep import GRID_PER_M, unmatched_edges, volume6, without_repeats
from frontage.solids.build_log import BuildLog
from frontage.solids.coarse.repair import add_missing_ground, split_edges, split_uneven_faces
from frontage.solids.coarse.sewing import cover_with_lid, sew_roof_to_walls

_WELD = 10  # 0.1 mm: vertices this close are one; the validator's snap tolerance
_FEWEST_FACES = 4  # of a solid: a tetrahedron


@dataclass(frozen=True, eq=False)
class Host:
    """A closed coarse solid, and notes on what was done to get it."""

    solid: Solid
    notes: tuple[str, ...] = ()


def host_solid(
    building: str, surfaces: Sequence[Surface], world: WorldRef, lod: str = "2", lid: bool = False
) -> Host | Failed:
    """Makes a closed solid from the polygons of a building.

    `surfaces` have rings (k, 3) m local, counter-clockwise as seen from outside. Vertices are rounded to the
    grid of 0.1 mm and not moved otherwise. Repaired, with a note: vertices up to 1 mm apart, vertices on the
    edges of other faces, a missing ground, free edges up to 0.1 m apart, faces that all look inwards, faces
    that are not flat; with `lid`, also a roof that does not meet its walls, which a lid of triangles
    replaces. Returns S302 if there are too few faces, S303 if the solid is not closed after all repairs.
    """
    log = BuildLog()
    vertices, faces = _welded(surfaces, log, building)
    if len(faces) < _FEWEST_FACES:
        hint = "use another level of detail, or a block made from the facade"
        return Failed("S302", f"{building}: {len(faces)} usable polygons do not make a solid", hint)
    solid = split_edges(Solid(building, vertices, world.origin, tuple(faces), lod), log)
    solid = add_missing_ground(solid, log)
    if unmatched_edges(solid.faces):
        solid = sew_roof_to_walls(solid, log)
    if lid and unmatched_edges(solid.faces):
        solid = cover_with_lid(solid, log)
    free = unmatched_edges(solid.faces)
    if free:
        x, y, z = (vertices[free[0][0]] / GRID_PER_M + world.origin).tolist()
        where = f"{len(free)} edges belong to one face only, one of them at {x:.2f} {y:.2f} {z:.2f}"
        hint = "repair the model, or use a block made from the ground or the facade"
        return Failed("S303", f"{building}: the host is not closed: {where}", hint)
    if volume6(solid) < 0:
        solid = _reversed(solid, log)
    return Host(split_uneven_faces(solid, log), tuple(log.notes))


def _welded(surfaces: Sequence[Surface], log: BuildLog, building: str) -> tuple[Int, list[Face]]:
    """Returns grid vertices (v, 3), those within the snap tolerance merged, and faces over them."""
    rings = [r for s in surfaces for r in (s.ring, *s.holes)]
    if not rings:
        return np.zeros((0, 3), np.int64), []
    grid = np.rint(np.concatenate(rings) * GRID_PER_M).astype(np.int64)
    unique, number = np.unique(grid, axis=0, return_inverse=True)
    merged = _first_within_tolerance(unique)
    if (merged != np.arange(len(merged))).any():
        log.note(f"{building}: vertices up to {_WELD / GRID_PER_M:g} m apart were merged")
    number = merged[number.ravel()]
    faces, start = [], 0
    for surface in surfaces:
        own = []
        for ring in (surface.ring, *surface.holes):
            own.append(without_repeats(number[start : start + len(ring)].tolist()))
            start += len(ring)
        if len(own[0]) > 2:
            faces.append(Face(own[0], surface.semantics, tuple(h for h in own[1:] if len(h) > 2)))
    return unique, faces


def _first_within_tolerance(grid: Int) -> Int:
    """Returns for every vertex the first vertex within the tolerance of it."""
    first = np.arange(len(grid))
    pairs = cKDTree(grid.astype(np.float64)).query_pairs(_WELD, output_type="ndarray")
    for a, b in sorted(map(tuple, np.sort(pairs, axis=1).tolist())):
        first[b] = min(first[b], first[a])
    return first


def _reversed(solid: Solid, log: BuildLog) -> Solid:
    """Reverses all faces of a solid."""
    log.note(f"{solid.building}: all faces looked inwards and were reversed")
    faces = [Face(f.ring[::-1], f.semantics, tuple(h[::-1] for h in f.holes)) for f in solid.faces]
    return replace(solid, faces=tuple(faces))
