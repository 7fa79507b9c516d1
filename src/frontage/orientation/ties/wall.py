"""The wall that photos show: the plane near which most of their points lie."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float

_STILL = 0.006  # rad, median parallax below which the wall's direction is not known
_NEAR = 0.01  # of the distance, from the plane
_TRIALS = 200


@dataclass(frozen=True, eq=False)
class Wall:
    """A plane ``normal . X = distance`` in the frame of a camera or block, and two axes (2, 3) in it."""

    normal: Float
    distance: float
    axes: Float

    def meet(self, centre: Float, rays: Float) -> Float:
        """Where rays (n, 3) from `centre` (3,) meet the wall, (n, 2) along its axes; NaN if they do not."""
        along = rays @ self.normal
        ahead = (self.distance - float(self.normal @ centre)) / np.where(np.abs(along) > 1e-3, along, np.nan)
        with np.errstate(invalid="ignore"):
            ahead = np.where(ahead > 0, ahead, np.nan)
        xy: Float = (centre + rays * ahead[:, None]) @ self.axes.T
        return xy


def wall_through(points: Float, rng: np.random.Generator, facing: Float) -> Wall:
    """Returns the plane near which most of the points (n, 3) lie.

    facing  (3,) mean viewing direction

    Distances from the plane count relative to the distance from the origin.
    """
    depth = np.linalg.norm(points, axis=1)
    best, most = None, 2
    for _ in range(_TRIALS):
        p = points[rng.choice(len(points), 3, replace=False)]
        n = np.cross(p[1] - p[0], p[2] - p[0])
        size = float(np.linalg.norm(n))
        if size < 1e-9 * float(depth.max()) ** 2:
            continue
        n = n / size
        near = np.abs((points - p[0]) @ n) < _NEAR * depth
        if near.sum() > most and abs(float(n @ facing)) > 0.1:
            best, most = near, int(near.sum())
    if best is None:
        return _make_wall(facing, float(np.median(points @ facing)))
    inside = points[best]
    middle = inside.mean(0)
    normal = np.linalg.svd(inside - middle, full_matrices=False)[2][2]
    return _make_wall(normal, float(normal @ middle))


def _make_wall(normal: Float, distance: float) -> Wall:
    if distance < 0:
        normal, distance = -normal, -distance
    helper = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first)
    return Wall(normal, distance, np.vstack([first, np.cross(normal, first)]))


def wall_of_pair(u: Float, v: Float, R: Float, t: Float, rng: np.random.Generator) -> tuple[Wall, Float]:
    """The wall in the frame of the first camera, and the second camera's centre (3,) there."""
    centre, back = -R.T @ t, v @ R
    facing = u.mean(0) / np.linalg.norm(u.mean(0))
    cosine = (u * back).sum(1)
    sine2 = 1 - cosine**2
    if float(np.median(sine2)) < _STILL**2:
        return _make_wall(facing, 1.0), np.zeros(3)
    depth = (u @ centre - cosine * (back @ centre)) / np.maximum(sine2, 1e-9)
    good = (sine2 > (0.5 * _STILL) ** 2) & (depth > 0)
    if good.sum() < 12:
        return _make_wall(facing, 1.0), centre
    return wall_through(u[good] * depth[good, None], rng, facing), centre
