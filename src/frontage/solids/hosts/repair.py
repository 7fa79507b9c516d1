"""What can be put right on a host without guessing: T-junctions, missing ground, faces that are not flat."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry import Polygon

from frontage.geometry.arrays import Float
from frontage.model import Face, Solid
from frontage.solids.log import Log
from frontage.solids.relief import GRID
from frontage.solids.rims import Edge, edges_of, normal, rings_of, unmatched

NEAR = 10.0  # 0.1 mm: a vertex this close to an edge lies on it (the validator's snap tolerance)
_FLAT = 0.008  # m: corners further off the face's plane than this split it; a valid face may have 0.01
_LEVEL = 0.9  # vertical part of a ground's normal


def noded(solid: Solid, log: Log, near: float = NEAR) -> Solid:
    """Free vertices within `near` (0.1 mm) of free edges of other faces put into these edges."""
    loose = unmatched(solid.faces)
    if not loose:
        return solid
    ids = np.array(sorted({i for e in loose for i in e}))
    xyz = solid.vertices[ids].astype(np.float64)
    between: dict[Edge, list[int]] = {}
    for a, b in loose:
        p, way = solid.vertices[a].astype(np.float64), (solid.vertices[b] - solid.vertices[a]).astype(float)
        t = (xyz - p) @ way / float(way @ way)
        off = np.linalg.norm(xyz - p - t[:, None] * way, axis=1)
        on = np.nonzero((off <= near) & (t > 0) & (t < 1) & (ids != a) & (ids != b))[0]
        if len(on):
            between[a, b] = ids[on[np.argsort(t[on], kind="stable")]].tolist()
    if not between:
        return solid
    log.notes.append(f"{solid.building}: vertices put into {len(between)} edges that passed by them")
    return replace(solid, faces=tuple(_with(f, between) for f in solid.faces))


def _with(face: Face, between: dict[Edge, list[int]]) -> Face:
    def ring(ids: tuple[int, ...]) -> tuple[int, ...]:
        pairs = zip(ids, (*ids[1:], ids[0]), strict=True)
        return tuple(i for a, b in pairs for i in (a, *between.get((a, b), [])))

    return Face(ring(face.ring), face.semantics, tuple(ring(h) for h in face.holes), face.opening)


def grounded(solid: Solid, log: Log) -> Solid:
    """A missing ground closed where that is unambiguous: level free loops below everything beside them.

    Every free edge must belong to one simple loop, every loop must be flat and face down.
    """
    loops = free_loops([e[::-1] for e in unmatched(solid.faces)])
    if not loops:
        return solid
    low = float(solid.vertices[:, 2].min()) / GRID
    faces = list(solid.faces)
    for loop in loops:
        ring = solid.vertices[loop] / GRID
        n = normal(ring)
        flat = np.abs((ring - ring.mean(0)) @ n).max() <= _FLAT
        if n[2] > -_LEVEL or not flat or ring[:, 2].min() - low > 0.5 * (ring[:, 2].max() - low) + _FLAT:
            return solid
        faces.append(Face(tuple(loop), "GroundSurface"))
    if unmatched(faces):
        return solid
    log.notes.append(f"{solid.building}: the ground surface was missing and has been added")
    return replace(solid, faces=tuple(faces))


def free_loops(edges: Sequence[Edge]) -> list[list[int]]:
    """Simple loops of edges; none where an end is ambiguous."""
    after = dict(edges)
    if len(after) != len(edges) or set(after) != set(after.values()):
        return []
    loops, rest = [], set(after)
    while rest:
        start = min(rest)
        loop = [start]
        while (nxt := after[loop[-1]]) != start:
            loop.append(nxt)
        rest -= set(loop)
        loops.append(loop)
    return loops


def flattened(solid: Solid, log: Log) -> Solid:
    """Faces with corners off their plane split into triangles; all others stay."""
    local, faces, split = solid.vertices / GRID, list[Face](), 0
    for face in solid.faces:
        ids = [i for r in rings_of(face) for i in r]
        n = normal(local[list(face.ring)])
        off = np.abs((local[ids] - local[ids].mean(0)) @ n).max()
        parts = triangles(face, local, n) if off > _FLAT else []
        faces += parts or [face]
        split += bool(parts)
    if split:
        log.notes.append(f"{solid.building}: {split} faces that were not flat are split into triangles")
    return replace(solid, faces=tuple(faces)) if split else solid


def triangles(face: Face, local: Float, n: Float) -> list[Face]:
    """A face as triangles over its own vertices; none where the triangulation fails."""
    keep = [k for k in range(3) if k != int(np.argmax(np.abs(n)))]
    where = {tuple(local[i, keep].tolist()): i for r in rings_of(face) for i in r}
    drawn = Polygon(local[list(face.ring)][:, keep], [local[list(h)][:, keep] for h in face.holes])
    try:
        parts = shapely.get_parts(shapely.constrained_delaunay_triangles(drawn))
    except shapely.errors.GEOSException:
        return []
    rings = [[where[x, y] for x, y in shapely.get_coordinates(t)[:3].tolist()] for t in parts]
    turned = [r if normal(local[r]) @ n > 0 else r[::-1] for r in rings]
    triangles = [Face(tuple(r), face.semantics, (), face.opening) for r in turned]
    inside = set(edges_of(face))
    free = {e for t in triangles for e in edges_of(t)}
    return triangles if inside <= free and len(triangles) > 1 else []
