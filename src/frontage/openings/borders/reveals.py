"""Tells where a reveal begins from the points on it."""

import numpy as np

from frontage.geometry.arrays import Float

_SPLAY = 0.1  # m per m, one sigma of the slant of reveals
_ROUGH = 0.001  # m, one sigma of the points of a reveal about its plane
_FINEST = 0.0003  # m, least sigma of the place of a reveal: half a step of the posterior


def reveal_line(u: Float, depth: Float, noise: float, slope: Float) -> tuple[float, float] | None:
    """Returns where a reveal begins, m, and its sigma, from its own points; it may slant a little."""
    if len(u) < 4:
        return None
    keep = np.abs(u - np.median(u)) < 0.02 + _SPLAY * depth
    u, depth, slope = u[keep], depth[keep], slope[keep]
    if len(u) < 4:
        return None
    sigma = float(np.hypot(noise * np.median(np.abs(slope)), _ROUGH))
    design = np.column_stack([np.ones(len(u)), depth])
    normal = design.T @ design / sigma**2 + np.diag([0.0, 1.0 / _SPLAY**2])
    inverse = np.linalg.inv(normal)
    start = inverse @ (design.T @ u / sigma**2)
    spread = float(np.sqrt(np.mean((u - design @ start) ** 2))) / sigma
    return float(start[0]), max(float(np.sqrt(inverse[0, 0])) * max(spread, 1.0), _FINEST)
