"""Registration as in paper B, section 2.1, the baseline: plain ICP of all points, which is not robust."""

from typing import Literal

import numpy as np
import shapely
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.model import CityModel
from frontage.registration.equations import apply_step
from frontage.registration.walls import model_walls

_STEP_M = 0.25  # m between the points that represent the model's surfaces


def plain_icp(
    xyz: Float,
    model: CityModel,
    method: Literal["point", "plane"] = "plane",
    iterations: int = 60,
    tolerance: float = 1e-5,
) -> Rigid3:
    """Moves points (n, 3) m local onto a city model by ICP, starting from where they are.

    method     "point": Besl and McKay (1992), the rigid motion between closest points by singular values;
               "plane": Chen and Medioni (1992), distances along the surface's normal, linearised
    tolerance  m, motion of the centroid below which the iteration stops

    Every point has its closest partner at every step.
    """
    target, normal = _sampled(model)
    tree = cKDTree(target)
    pose = Rigid3.identity("local", "given")
    pivot = xyz.mean(0)
    for _ in range(iterations):
        now = pose.apply(xyz)
        _, k = tree.query(now)
        before = now.mean(0)
        step = _absolute(now, target[k]) if method == "point" else None
        if step is None:
            n = normal[k]
            A = np.column_stack([n, np.cross(now - pose.apply(pivot[None]), n)])
            r = np.einsum("ij,ij->i", n, now - target[k])
            pose = apply_step(pose, pivot, -np.linalg.lstsq(A.T @ A, A.T @ r, rcond=None)[0])
        else:
            pose = step @ pose
        if np.linalg.norm(pose.apply(xyz).mean(0) - before) < tolerance:
            break
    return pose


def _absolute(a: Float, b: Float) -> Rigid3:
    """Returns the least-squares motion of points a (n, 3) onto b (n, 3) by singular value decomposition."""
    ca, cb = a.mean(0), b.mean(0)
    u, _, vt = np.linalg.svd((b - cb).T @ (a - ca))
    R = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    return Rigid3("local", "local", R, cb - R @ ca)


def _sampled(model: CityModel) -> tuple[Float, Float]:
    """Returns points (m, 3) m on the model's surfaces, and their normals (m, 3)."""
    points, normals = [], []
    for p in model_walls(model).patches:
        x0, y0, x1, y1 = p.polygon.bounds
        u, h = (g.ravel() for g in np.meshgrid(np.arange(x0, x1, _STEP_M), np.arange(y0, y1, _STEP_M)))
        inside = np.asarray(shapely.contains_xy(p.polygon, u, h), np.bool_)
        points.append(p.point + u[inside, None] * p.along + h[inside, None] * p.up)
        normals.append(np.tile(p.normal, (int(inside.sum()), 1)))
    return np.concatenate(points), np.concatenate(normals)
