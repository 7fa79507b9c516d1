"""The plane of every face by least squares, and the faces drawn in their planes."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.validation.geometry.mesh import Mesh


@dataclass(frozen=True, eq=False)
class Flat:
    """Faces in their planes: `xy` (c, 2) m per corner, `offset` (c,) m from the plane, `normal` (f, 3).

    The normal is the side from which the outer ring runs counter-clockwise.
    """

    xy: Float
    offset: Float
    normal: Float


def flatten(mesh: Mesh) -> Flat:
    """Fit a plane to all corners of each face (smallest eigenvector of their scatter) and project.

    Faces with fewer than three corners get an arbitrary plane.
    """
    face = mesh.face_of_corner
    number = len(mesh.faces) - 1
    xyz = mesh.xyz[mesh.corners]
    count = np.maximum(np.bincount(face, minlength=number), 1)[:, None]
    centre = sum_by(face, xyz, number) / count
    d = xyz - centre[face]
    scatter = sum_by(face, (d[:, :, None] * d[:, None, :]).reshape(-1, 9), number).reshape(-1, 3, 3)
    _, axes = np.linalg.eigh(scatter)
    normal = axes[:, :, 0]
    outward = newell(mesh)
    turn = np.einsum("fi,fi->f", normal, outward) < 0
    normal = np.where(turn[:, None], -normal, normal)
    u = axes[:, :, 2]
    v = np.cross(normal, u)
    xy = np.stack([np.einsum("ci,ci->c", d, u[face]), np.einsum("ci,ci->c", d, v[face])], axis=1)
    return Flat(xy, np.einsum("ci,ci->c", d, normal[face]), normal)


def newell(mesh: Mesh) -> Float:
    """Twice the vector area (f, 3) of each face's outer ring; its direction is the ring's right hand."""
    number = len(mesh.faces) - 1
    ring = mesh.ring_of_corner
    face = mesh.face_of_ring[ring]
    outer = ring == mesh.faces[:-1][face]
    xyz = mesh.xyz
    base = xyz[mesh.corners[mesh.rings[:-1][ring]]]
    area = np.cross(xyz[mesh.corners] - base, xyz[mesh.following] - base)
    return sum_by(face[outer], area[outer], number)


def sum_by(group: Int, values: Float, number: int) -> Float:
    """Sums (number, k) of values (n, k) per group (n,)."""
    columns = [np.bincount(group, weights=column, minlength=number) for column in values.T]
    return np.stack(columns, axis=1) if columns else np.zeros((number, 0))


def ring_areas(mesh: Mesh, xy: Float) -> Float:
    """Signed area (r,) of every ring in its face's plane."""
    ring = mesh.ring_of_corner
    base = xy[mesh.rings[:-1][ring]]
    a, b = xy - base, xy[mesh.after] - base
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return np.asarray(0.5 * np.bincount(ring, weights=cross, minlength=len(mesh.rings) - 1), np.float64)
