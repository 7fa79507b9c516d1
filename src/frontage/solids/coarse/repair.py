"""Repairs of a host that need no guessing: T-junctions, a missing ground, faces that are not flat."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry import Polygon

from frontage.geometry.arrays import Float
from frontage.model import Face, Solid
from frontage.solids.brep import (
    GRID_PER_M,
    Edge,
    directed_edges,
    newell_normal,
    ring_edges,
    rings_of,
    unmatched_edges,
)
from frontage.solids.build_log import BuildLog

ON_EDGE = 10.0  # 0.1 mm: a vertex this close to an edge lies on it; the validator's snap tolerance
_FLAT_M = 0.008  # a face with a corner further off its plane is split; the validator accepts 0.01
_LEVEL = 0.9  # vertical component of the normal of a ground, at least
_LOW_SHARE = 0.5  # the lowest corner of a ground is at most half as high over the solid's foot as its highest


def split_edges(solid: Solid, log: BuildLog, near: float = ON_EDGE) -> Solid:
    """Splits free edges at the free vertices of other faces within `near` (0.1 mm) of them."""
    free = unmatched_edges(solid.faces)
    if not free:
        return solid
    ids = np.array(sorted({i for e in free for i in e}))
    xyz = solid.vertices[ids].astype(np.float64)
    between: dict[Edge, list[int]] = {}
    for a, b in free:
        p, way = solid.vertices[a].astype(np.float64), (solid.vertices[b] - solid.vertices[a]).astype(float)
        t = (xyz - p) @ way / float(way @ way)
        off = np.linalg.norm(xyz - p - t[:, None] * way, axis=1)
        on = np.nonzero((off <= near) & (t > 0) & (t < 1) & (ids != a) & (ids != b))[0]
        if len(on):
            between[a, b] = ids[on[np.argsort(t[on], kind="stable")]].tolist()
    if not between:
        return solid
    log.note(f"{solid.building}: {len(between)} edges were split at vertices of other faces that lie on them")
    return replace(solid, faces=tuple(_with_vertices(f, between) for f in solid.faces))


def _with_vertices(face: Face, between: dict[Edge, list[int]]) -> Face:
    """Returns a face with vertices inserted into its edges."""

    def ring(ids: tuple[int, ...]) -> tuple[int, ...]:
        return tuple(i for a, b in ring_edges(ids) for i in (a, *between.get((a, b), [])))

    return Face(ring(face.ring), face.semantics, tuple(ring(h) for h in face.holes), face.opening)


def add_missing_ground(solid: Solid, log: BuildLog) -> Solid:
    """Adds a missing ground surface where that is unambiguous; else returns the solid unchanged.

    Every free edge must belong to one simple loop, and every loop must be flat, level, low and face down.
    """
    loops = simple_loops([e[::-1] for e in unmatched_edges(solid.faces)])
    if not loops:
        return solid
    lowest = float(solid.vertices[:, 2].min()) / GRID_PER_M
    faces = list(solid.faces)
    for loop in loops:
        if not _is_ground_ring(solid.vertices[loop] / GRID_PER_M, lowest):
            return solid
        faces.append(Face(tuple(loop), "GroundSurface"))
    if unmatched_edges(faces):
        return solid
    log.note(f"{solid.building}: the ground surface was missing and has been added")
    return replace(solid, faces=tuple(faces))


def _is_ground_ring(ring: Float, lowest: float) -> bool:
    """Decides whether a ring (k, 3) m is flat, faces down and is low, given the solid's `lowest` z (m)."""
    n = newell_normal(ring)
    flat = np.abs((ring - ring.mean(0)) @ n).max() <= _FLAT_M
    low = ring[:, 2].min() - lowest <= _LOW_SHARE * (ring[:, 2].max() - lowest) + _FLAT_M
    return bool(n[2] <= -_LEVEL and flat and low)


def simple_loops(edges: Sequence[Edge]) -> list[list[int]]:
    """Chains directed edges to simple loops of vertex ids; returns none if a vertex has two successors."""
    after = dict(edges)
    if len(after) != len(edges) or set(after) != set(after.values()):
        return []
    loops, rest = [], set(after)
    while rest:
        start = min(rest)
        loop = [start]
        while (following := after[loop[-1]]) != start:
            loop.append(following)
        rest -= set(loop)
        loops.append(loop)
    return loops


def split_uneven_faces(solid: Solid, log: BuildLog) -> Solid:
    """Splits faces with corners off their plane into triangles; all other faces stay as they are."""
    local, faces, split = solid.vertices / GRID_PER_M, list[Face](), 0
    for face in solid.faces:
        ids = [i for r in rings_of(face) for i in r]
        n = newell_normal(local[list(face.ring)])
        off = np.abs((local[ids] - local[ids].mean(0)) @ n).max()
        parts = triangulate_face(face, local, n) if off > _FLAT_M else []
        faces += parts or [face]
        split += bool(parts)
    if split:
        log.note(f"{solid.building}: {split} faces that were not flat were split into triangles")
    return replace(solid, faces=tuple(faces)) if split else solid


def triangulate_face(face: Face, local: Float, normal: Float) -> list[Face]:
    """Splits a face into triangles over its own vertices; returns none if the triangulation fails.

    `local` (v, 3) m are the vertices of the solid, `normal` (3,) is the direction that the triangles face.
    """
    keep = [k for k in range(3) if k != int(np.argmax(np.abs(normal)))]
    vertex_at = {tuple(local[i, keep].tolist()): i for r in rings_of(face) for i in r}
    drawn = Polygon(local[list(face.ring)][:, keep], [local[list(h)][:, keep] for h in face.holes])
    try:
        parts = shapely.get_parts(shapely.constrained_delaunay_triangles(drawn))
    except shapely.errors.GEOSException:
        return []
    rings = [[vertex_at[x, y] for x, y in shapely.get_coordinates(t)[:3].tolist()] for t in parts]
    oriented = [r if newell_normal(local[r]) @ normal > 0 else r[::-1] for r in rings]
    triangles = [Face(tuple(r), face.semantics, (), face.opening) for r in oriented]
    needed = set(directed_edges(face))
    made = {e for t in triangles for e in directed_edges(t)}
    return triangles if needed <= made and len(triangles) > 1 else []
