"""Hosts whose roof does not reach its walls: the free edges are sewn together where only one way is open."""

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Float, Int
from frontage.model import Face, Solid
from frontage.solids.hosts.repair import flattened, free_loops, grounded, noded, triangles
from frontage.solids.log import Log
from frontage.solids.relief import GRID
from frontage.solids.rims import edges_of, rings_of, unmatched, without_repeats
from frontage.validation.validate import validate

_REACH = (100.0, 200.0, 500.0, 1000.0)  # 0.1 mm: city models are drawn to 0.1 m
_UP = np.array([0.0, 0.0, 1.0])
_ANCHORS = ("WallSurface", "GroundSurface")


def sewn(solid: Solid, log: Log) -> Solid:
    """A closed, valid solid from an open one, or the solid as it was.

    Free vertices of the roof go to the nearest free vertex of walls and ground, free edges take in free
    vertices that lie on them, polygons that hang on nothing are left out. The smallest reach of 0.01 to 0.1 m
    that gives a closed solid without findings is taken; walls and ground keep their vertices.
    """
    for reach in _REACH:
        trial = Log()
        sewed = _joined(solid, reach)
        sewed = noded(noded(sewed, trial, reach), trial, reach)
        loose = set(unmatched(sewed.faces))
        kept = tuple(f for f in sewed.faces if not loose.issuperset(edges_of(f)))
        sewed = grounded(replace(sewed, faces=kept), trial)
        if len(kept) < 4 or unmatched(sewed.faces):
            continue
        flat = flattened(sewed, trial)
        if not validate(flat):
            dropped = len(solid.faces) - len(kept)
            text = f"{solid.building}: free edges up to {reach / GRID:g} m apart have been joined"
            log.notes.append(text + (f", {dropped} loose polygons left out" if dropped else ""))
            log.notes += trial.notes
            return flat
    return solid


def lidded(solid: Solid, log: Log) -> Solid:
    """Walls and ground as they are under a lid of triangles in place of the roof, or the solid as it was.

    The walls' upper edges must form simple loops. What lies under the lid is not the true roof's volume.
    """
    for reach in (0.0, *_REACH):
        trial = Log()
        body = replace(solid, faces=tuple(f for f in solid.faces if f.semantics in _ANCHORS))
        body = noded(noded(body, trial, reach), trial, reach)
        faces = list(body.faces)
        for loop in free_loops([e[::-1] for e in unmatched(body.faces)]):
            lid = Face(tuple(loop), "RoofSurface")
            faces += triangles(lid, body.vertices / GRID, _UP) or [lid]
        closed = replace(body, faces=tuple(faces))
        if len(faces) == len(body.faces) or unmatched(closed.faces) or validate(closed):
            continue
        log.notes.append(
            f"{solid.building}: the roof does not meet the walls; a lid of triangles replaces it"
        )
        log.notes += trial.notes
        return closed
    return solid


def _joined(solid: Solid, reach: float) -> Solid:
    """Free vertices of the roof at the nearest free vertex of walls and ground within reach."""
    free = {i for e in unmatched(solid.faces) for i in e}
    anchors = {i for f in solid.faces if f.semantics in _ANCHORS for r in rings_of(f) for i in r}
    fixed, loose = np.array(sorted(free & anchors)), np.array(sorted(free - anchors))
    if not len(fixed) or not len(loose):
        return solid
    away, nearest = cKDTree(_xyz(solid, fixed)).query(_xyz(solid, loose))
    near = np.asarray(away) <= reach
    goes = dict(zip(loose[near].tolist(), fixed[np.asarray(nearest)[near]].tolist(), strict=True))
    faces = []
    for f in solid.faces:
        ring, *holes = (without_repeats([goes.get(i, i) for i in r]) for r in rings_of(f))
        if len(ring) > 2:
            faces.append(Face(ring, f.semantics, tuple(h for h in holes if len(h) > 2), f.opening))
    return replace(solid, faces=tuple(faces))


def _xyz(solid: Solid, ids: Int) -> Float:
    return solid.vertices[ids].astype(np.float64)
