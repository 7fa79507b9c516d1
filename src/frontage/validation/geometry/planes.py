"""The plane of every face by least squares, and the faces in the coordinates of their planes."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.validation.geometry.mesh import Mesh


@dataclass(frozen=True, eq=False)
class PlaneFit:
    """The corners of a mesh in the planes of their faces.

    xy      (c, 2) m: the corners in the planes
    offset  (c,) m: signed distance of the corners from the planes
    normal  (f, 3): towards the side from which the outer ring runs counter-clockwise
    """

    xy: Float
    offset: Float
    normal: Float


def fit_planes(mesh: Mesh) -> PlaneFit:
    """Fits a plane to all corners of each face (smallest eigenvector of their scatter) and projects them.

    Faces with fewer than three corners get an arbitrary plane.
    """
    face = mesh.face_of_corner
    number = len(mesh.faces) - 1
    xyz = mesh.xyz[mesh.corners]
    count = np.maximum(np.bincount(face, minlength=number), 1)[:, None]
    centre = _sum_by(face, xyz, number) / count
    d = xyz - centre[face]
    scatter = _sum_by(face, (d[:, :, None] * d[:, None, :]).reshape(-1, 9), number).reshape(-1, 3, 3)
    _, axes = np.linalg.eigh(scatter)
    normal = axes[:, :, 0]
    opposite = np.einsum("fi,fi->f", normal, _vector_areas(mesh)) < 0
    normal = np.where(opposite[:, None], -normal, normal)
    u = axes[:, :, 2]
    v = np.cross(normal, u)
    xy = np.stack([np.einsum("ci,ci->c", d, u[face]), np.einsum("ci,ci->c", d, v[face])], axis=1)
    return PlaneFit(xy, np.einsum("ci,ci->c", d, normal[face]), normal)


def _vector_areas(mesh: Mesh) -> Float:
    """Returns twice the vector area (f, 3) of each face's outer ring (Newell); right-handed to the ring."""
    number = len(mesh.faces) - 1
    ring = mesh.ring_of_corner
    face = mesh.face_of_ring[ring]
    outer = ring == mesh.faces[:-1][face]
    xyz = mesh.xyz
    base = xyz[mesh.corners[mesh.rings[:-1][ring]]]
    area = np.cross(xyz[mesh.corners] - base, xyz[mesh.following] - base)
    return _sum_by(face[outer], area[outer], number)


def _sum_by(group: Int, values: Float, number: int) -> Float:
    """Returns the sums (number, k) of values (n, k) per group (n,)."""
    columns = [np.bincount(group, weights=column, minlength=number) for column in values.T]
    return np.stack(columns, axis=1) if columns else np.zeros((number, 0))


def ring_areas(mesh: Mesh, xy: Float) -> Float:
    """Returns the signed area (r,) m2 of every ring in the plane of its face; `xy` as in `PlaneFit`."""
    ring = mesh.ring_of_corner
    base = xy[mesh.rings[:-1][ring]]
    a, b = xy - base, xy[mesh.after] - base
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return np.asarray(0.5 * np.bincount(ring, weights=cross, minlength=len(mesh.rings) - 1), np.float64)
