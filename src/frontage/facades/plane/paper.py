"""The plane extraction of paper A as published, the baseline: 3-point RANSAC (Fischler, Bolles 1981)."""

import numpy as np

from frontage.geometry.arrays import Bool, Float


def paper_plane(
    xyz: Float, threshold: float, iterations: int, rng: np.random.Generator, block: int = 4
) -> tuple[Float, Float, Bool] | None:
    """Finds the plane with the most points within `threshold` m (paper A, section 2.1).

    Three points are drawn, all points are polled, and the plane with the larger number of points wins; among
    equals, the one with the smaller accumulated error. There is no prior, no weight and no refinement. The
    offset of the plane is moved to the barycentre of its inliers (section 2.2).

    Returns unit normal (3,), barycentre (3,) m and inliers (n,), or None when no three points span a plane.
    """
    if len(xyz) < 3:
        return None
    best: tuple[int, float] = (0, 0.0)
    plane: tuple[Float, float] | None = None
    for _ in range(0, iterations, block):
        a, b, c = (xyz[rng.integers(0, len(xyz), block)] for _ in range(3))
        normals = np.cross(b - a, c - a)
        length = np.linalg.norm(normals, axis=1)
        for n, size, p in zip(normals, length, a, strict=True):
            if size < 1e-9:
                continue
            distance = np.abs(xyz @ (n / size) - p @ (n / size))
            near = distance < threshold
            score = (int(near.sum()), -float(distance[near].sum()))
            if score > best:
                best, plane = score, (n / size, float(p @ n / size))
    if plane is None:
        return None
    inliers = np.abs(xyz @ plane[0] - plane[1]) < threshold
    return plane[0], xyz[inliers].mean(0), np.asarray(inliers, np.bool_)
