"""Closes hosts whose roof does not reach their walls, where there is only one way to do so."""

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Float, Int
from frontage.model import Face, Solid
from frontage.solids.brep import (
    GRID_PER_M,
    directed_edges,
    rings_of,
    unmatched_edges,
    without_repeats,
)
from frontage.solids.build_log import BuildLog
from frontage.solids.coarse.repair import (
    add_missing_ground,
    simple_loops,
    split_edges,
    split_uneven_faces,
    triangulate_face,
)
from frontage.validation.validate import validate

_REACHES = (100.0, 200.0, 500.0, 1000.0)  # 0.1 mm; city models are drawn to 0.1 m
_UP = np.array([0.0, 0.0, 1.0])
_FIXED_KINDS = ("WallSurface", "GroundSurface")
_FEWEST_FACES = 4


def sew_roof_to_walls(solid: Solid, log: BuildLog) -> Solid:
    """Joins the free edges of the roof to those of walls and ground; else returns the solid unchanged.

    Free vertices of the roof move to the nearest free vertex of walls and ground, free edges are split at
    free vertices that lie on them, and polygons that share no edge with others are left out. The smallest
    reach of 0.01 to 0.1 m that gives a valid solid is taken; the vertices of walls and ground keep their
    places.
    """
    for reach in _REACHES:
        trial = BuildLog()
        sewed = _with_roof_moved(solid, reach)
        sewed = split_edges(split_edges(sewed, trial, reach), trial, reach)
        free = set(unmatched_edges(sewed.faces))
        kept = tuple(f for f in sewed.faces if not free.issuperset(directed_edges(f)))
        sewed = add_missing_ground(replace(sewed, faces=kept), trial)
        if len(kept) < _FEWEST_FACES or unmatched_edges(sewed.faces):
            continue
        flat = split_uneven_faces(sewed, trial)
        if not validate(flat):
            dropped = len(solid.faces) - len(kept)
            text = f"{solid.building}: free edges up to {reach / GRID_PER_M:g} m apart were joined"
            log.note(text + (f" and {dropped} loose polygons left out" if dropped else ""))
            log.notes += trial.notes
            return flat
    return solid


def cover_with_lid(solid: Solid, log: BuildLog) -> Solid:
    """Replaces the roof by a lid of triangles over the walls; else returns the solid unchanged.

    The upper edges of the walls must form simple loops. The volume under the lid is not that of the true
    roof.
    """
    for reach in (0.0, *_REACHES):
        trial = BuildLog()
        body = replace(solid, faces=tuple(f for f in solid.faces if f.semantics in _FIXED_KINDS))
        body = split_edges(split_edges(body, trial, reach), trial, reach)
        faces = list(body.faces)
        for loop in simple_loops([e[::-1] for e in unmatched_edges(body.faces)]):
            lid = Face(tuple(loop), "RoofSurface")
            faces += triangulate_face(lid, body.vertices / GRID_PER_M, _UP) or [lid]
        closed = replace(body, faces=tuple(faces))
        if len(faces) == len(body.faces) or unmatched_edges(closed.faces) or validate(closed):
            continue
        log.note(f"{solid.building}: the roof does not meet the walls; a lid of triangles replaces it")
        log.notes += trial.notes
        return closed
    return solid


def _with_roof_moved(solid: Solid, reach: float) -> Solid:
    """Moves free vertices of the roof to the nearest one of walls and ground within reach (0.1 mm)."""
    free = {i for e in unmatched_edges(solid.faces) for i in e}
    anchors = {i for f in solid.faces if f.semantics in _FIXED_KINDS for r in rings_of(f) for i in r}
    fixed, loose = np.array(sorted(free & anchors)), np.array(sorted(free - anchors))
    if not len(fixed) or not len(loose):
        return solid
    away, nearest = cKDTree(_coordinates(solid, fixed)).query(_coordinates(solid, loose))
    near = np.asarray(away) <= reach
    moved_to = dict(zip(loose[near].tolist(), fixed[np.asarray(nearest)[near]].tolist(), strict=True))
    faces = []
    for f in solid.faces:
        ring, *holes = (without_repeats([moved_to.get(i, i) for i in r]) for r in rings_of(f))
        if len(ring) > 2:
            faces.append(Face(ring, f.semantics, tuple(h for h in holes if len(h) > 2), f.opening))
    return replace(solid, faces=tuple(faces))


def _coordinates(solid: Solid, ids: Int) -> Float:
    return solid.vertices[ids].astype(np.float64)
