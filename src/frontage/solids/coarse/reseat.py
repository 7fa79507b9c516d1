"""Moves the walls of a host onto the measured planes, and their corners to where these planes meet."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.model import Solid
from frontage.solids.brep import GRID_PER_M, newell_normal, rings_of
from frontage.solids.build_log import BuildLog
from frontage.solids.coarse.repair import split_uneven_faces
from frontage.solids.options import BuildOptions
from frontage.solids.relief import FacadeReliefs
from frontage.solids.walls import find_walls
from frontage.validation.validate import validate

_PARALLEL_SINE = 0.05  # planes closer to parallel than this do not place a corner along their common line

Plane = tuple[Float, Float]
"""Unit normal (3,) and a point (3,) m of a plane."""


def reseat_walls(
    solid: Solid, facades: Sequence[FacadeReliefs], options: BuildOptions, log: BuildLog
) -> Solid:
    """Moves the largest wall under every facade into the facade's plane.

    A vertex takes the smallest step d that puts it in the planes of all its faces, moved or not: with the
    planes' normals N and distances r, ``min |d|  subject to  N d = r`` in the least squares sense. Faces that
    are not flat afterwards are split. Returns the solid unchanged if the result is not valid or a vertex
    would move by more than twice `max_offset`.
    """
    measured: dict[int, Plane] = {}
    for facade in facades:
        for wall in find_walls(solid, facade, options)[:1]:
            frame = facade.local_from_facade
            measured |= dict.fromkeys(wall.faces, (-frame.R[:, 1], frame.t))
    if not measured:
        return solid
    moved = _moved_vertices(solid, measured)
    shift = float(np.abs(moved - solid.vertices).max()) / GRID_PER_M
    seated = split_uneven_faces(replace(solid, vertices=moved), log)
    if shift > 2 * options.max_offset or validate(seated):
        log.note(f"{solid.building}: walls not moved, because the solid would not be valid")
        return solid
    log.note(f"{solid.building}: walls moved onto the measured planes, corners by up to {shift:.3f} m")
    return seated


def _moved_vertices(solid: Solid, measured: dict[int, Plane]) -> Int:
    """Returns the vertices (v, 3) on the grid after the move; `measured`: face index -> measured plane."""
    local = solid.vertices / GRID_PER_M
    planes: list[list[Plane]] = [[] for _ in local]
    for k, face in enumerate(solid.faces):
        ring = local[list(face.ring)]
        plane = measured.get(k, (newell_normal(ring), ring.mean(0)))
        for i in {i for r in rings_of(face) for i in r}:
            planes[i].append(plane if k in measured else (plane[0], local[i]))
    touched = {i for k in measured for r in rings_of(solid.faces[k]) for i in r}
    out = local.copy()
    for i in sorted(touched):
        normals = np.array([n for n, _ in planes[i]])
        away = np.array([n @ (p - local[i]) for n, p in planes[i]])
        out[i] += np.linalg.lstsq(normals, away, rcond=_PARALLEL_SINE)[0]
    return np.rint(out * GRID_PER_M).astype(np.int64)
