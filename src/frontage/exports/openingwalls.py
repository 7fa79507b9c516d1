"""Finds the wall that holds an opening, from the faces around it alone."""

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import OPENING_SURFACES, Solid
from frontage.solids.brep import GRID_PER_M, Edge, directed_edges, newell_normal

_PARALLEL_COS = 0.99  # of the largest angle between the normals of an opening and its wall


def walls_of_openings(solid: Solid) -> dict[int, int]:
    """Maps the face number of every window and door to that of the wall around it.

    The wall is the parallel face that shares the longest edge with the opening or with the reveals around it;
    where no face is parallel, it is the wall that shares the longest edge. Openings without a wall beside
    them are left out.
    """
    xyz = solid.vertices / GRID_PER_M
    beyond = {e: k for k, f in enumerate(solid.faces) for e in directed_edges(f)}
    normals: dict[int, Float] = {}

    def normal_of(k: int) -> Float:
        if k not in normals:
            normals[k] = newell_normal(xyz[list(solid.faces[k].ring)])
        return normals[k]

    found = {}
    for k, face in enumerate(solid.faces):
        if face.semantics not in OPENING_SURFACES:
            continue
        direct = _shared(solid, xyz, k, beyond)
        beside = dict(direct)
        for reveal in direct:
            if solid.faces[reveal].opening is None:
                for other, length in _shared(solid, xyz, reveal, beyond).items():
                    beside[other] = beside.get(other, 0.0) + length
        walls = {
            j: v for j, v in beside.items() if solid.faces[j].semantics not in OPENING_SURFACES and j != k
        }
        parallel = {j: v for j, v in walls.items() if normal_of(j) @ normal_of(k) > _PARALLEL_COS}
        chosen = parallel or {j: v for j, v in walls.items() if solid.faces[j].semantics == "WallSurface"}
        if chosen:
            found[k] = max(chosen, key=lambda j: (chosen[j], -j))
    return found


def _shared(solid: Solid, xyz: Float, face: int, beyond: dict[Edge, int]) -> dict[int, float]:
    """Returns the neighbours of a face with the length (m) of the edges that they share with it."""
    out: dict[int, float] = {}
    for a, b in directed_edges(solid.faces[face]):
        other = beyond.get((b, a))
        if other is not None:
            out[other] = out.get(other, 0.0) + float(np.linalg.norm(xyz[a] - xyz[b]))
    return out
