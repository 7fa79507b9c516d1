"""Host walls moved onto the measured planes, their corners where the planes meet."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.model import Solid
from frontage.solids.hosts.repair import flattened
from frontage.solids.hosts.walls import find_walls
from frontage.solids.log import Log
from frontage.solids.relief import GRID, BuildOptions, FacadeReliefs
from frontage.solids.rims import normal, rings_of
from frontage.validation.validate import validate

_PARALLEL = 0.05  # planes closer to parallel than this (sine) do not place a corner along their line


def reseat(solid: Solid, facades: Sequence[FacadeReliefs], options: BuildOptions, log: Log) -> Solid:
    """The solid with every wall under a facade in the facade's plane.

    A vertex moves by the smallest step that puts it in all planes of its faces, moved or not: with the
    planes' normals N and distances r, ``min |d|  subject to  N d = r`` in the least squares sense.
    Faces that are not flat afterwards are split. If the result is not valid, the solid comes back as it was.
    """
    target: dict[int, tuple[Float, Float]] = {}
    for facade in facades:
        for wall in find_walls(solid, facade, options)[:1]:
            frame = facade.local_from_facade
            target |= dict.fromkeys(wall.faces, (-frame.R[:, 1], frame.t))
    if not target:
        return solid
    moved = _moved(solid, target)
    shift = float(np.abs(moved - solid.vertices).max()) / GRID
    seated = flattened(replace(solid, vertices=moved), log)
    if shift > 2 * options.max_offset or validate(seated):
        log.notes.append(f"{solid.building}: the walls stay, on the measured planes the solid is not valid")
        return solid
    log.notes.append(
        f"{solid.building}: walls moved onto the measured planes, corners by up to {shift:.3f} m"
    )
    return seated


def _moved(solid: Solid, target: dict[int, tuple[Float, Float]]) -> Int:
    """Vertices (v, 3) on their grid after the move."""
    local = solid.vertices / GRID
    planes: list[list[tuple[Float, Float]]] = [[] for _ in local]
    for k, face in enumerate(solid.faces):
        ring = local[list(face.ring)]
        plane = target.get(k, (normal(ring), ring.mean(0)))
        for i in {i for r in rings_of(face) for i in r}:
            planes[i].append(plane if k in target else (plane[0], local[i]))
    touched = {i for k in target for r in rings_of(solid.faces[k]) for i in r}
    out = local.copy()
    for i in sorted(touched):
        normals = np.array([n for n, _ in planes[i]])
        away = np.array([n @ (p - local[i]) for n, p in planes[i]])
        out[i] += np.linalg.lstsq(normals, away, rcond=_PARALLEL)[0]
    return np.rint(out * GRID).astype(np.int64)
