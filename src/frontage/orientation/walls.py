"""Upright walls of a scan and of a block of photos, in which both can be drawn alike."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.geometry.rigid import Rigid3
from frontage.solve.surfels import Surfels

_AZIMUTHS = np.radians(np.arange(0.0, 360.0, 2.0))
_ALIKE = float(np.cos(np.radians(8.0)))  # between normals of one wall
_BIN_M = 0.2  # offsets of a wall
_THICK_M = 0.4  # pieces this far from a wall belong to it
_LEAST_AREA_M2 = 10.0
_ENDS = 0.01  # share of a wall that may lie beyond its extent, on each side


@dataclass(frozen=True, eq=False)
class UprightWall:
    """An upright plane with its extent.

    pose    frame_from_wall: X to the right as seen from the street, Y into the building, Z up
    extent  x0, z0, x1, z1 in the wall's frame
    weight  area (m2) or number of points that it was found from
    """

    pose: Rigid3
    extent: tuple[float, float, float, float]
    weight: float

    @property
    def inward(self) -> Float:
        """The unit vector (3,) into the building."""
        return self.pose.R[:, 1]


def scan_walls(pieces: Surfels, most: int = 8) -> list[UprightWall]:
    """Finds the largest upright walls of a scan, largest first, from its flat pieces.

    The street side of a wall is where the scanner stood; a wall of unknown side is returned for both sides.
    """
    upright = pieces.take(pieces.upright)
    walls: list[UprightWall] = []
    while len(upright) and len(walls) < most:
        azimuth, offset, area = _strongest(upright)
        if area < _LEAST_AREA_M2:
            break
        normal = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        own = _members(upright, normal, offset)
        normal = _mean_normal(upright.take(own), normal)
        walls += _placed_walls(upright.take(own), normal, float(upright.area[own].sum()))
        upright = upright.take(~own)
    return walls


def _strongest(pieces: Surfels) -> tuple[float, float, float]:
    """Azimuth (rad) of the outward normal, offset (m) and area (m2) of the wall with the largest area."""
    best = (0.0, 0.0, 0.0)
    for azimuth in _AZIMUTHS:
        normal = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        alike = pieces.normal @ normal > _ALIKE
        if not alike.any():
            continue
        number = np.floor(pieces.xyz[alike] @ normal / _BIN_M).astype(np.int64)
        per_bin = np.bincount(number - number.min(), pieces.area[alike])
        area = np.convolve(per_bin, [1.0, 1.0])  # a wall on the border of two bins
        top = int(area.argmax())
        if area[top] > best[2]:
            best = (float(azimuth), float((top + number.min()) * _BIN_M), float(area[top]))
    return best


def _members(pieces: Surfels, normal: Float, offset: float) -> Bool:
    return (pieces.normal @ normal > _ALIKE) & (np.abs(pieces.xyz @ normal - offset) < _THICK_M)


def _mean_normal(pieces: Surfels, start: Float) -> Float:
    """The horizontal normal of the plane through the pieces, weighted by area; `start` tells its side."""
    w = pieces.area / pieces.area.sum()
    d = pieces.xyz[:, :2] - w @ pieces.xyz[:, :2]
    across = np.linalg.eigh((d * w[:, None]).T @ d)[1][:, 0]
    normal = np.append(across, 0.0)
    return np.asarray(normal if normal @ start > 0 else -normal)


def _placed_walls(pieces: Surfels, outward: Float, area: float) -> list[UprightWall]:
    offset = _weighted_median(pieces.xyz @ outward, pieces.area)
    origin = outward * offset
    sides = [outward] if pieces.oriented.mean() > 0.5 else [outward, -outward]
    return [wall_through(origin, -side, pieces.xyz, area, "local") for side in sides]


def wall_through(origin: Float, inward: Float, xyz: Float, weight: float, frame: str) -> UprightWall:
    """Returns the wall with an inward unit vector (3,) through `origin` (3,), as wide as points (n, 3)."""
    x = np.array([inward[1], -inward[0], 0.0])
    pose = Rigid3(frame, "wall", np.column_stack([x, inward, [0.0, 0.0, 1.0]]), origin)
    at = pose.inverse.apply(xyz)
    (x0, z0), (x1, z1) = (np.quantile(at[:, ::2], q, axis=0).tolist() for q in (_ENDS, 1 - _ENDS))
    return UprightWall(pose, (x0, z0, x1, z1), weight)


def _weighted_median(values: Float, weights: Float) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, 0.5 * total[-1])])


def block_walls(
    points: Float, centres: Float, scale: float, most: int = 4, seed: int = 0
) -> list[UprightWall]:
    """Finds upright walls among the points (n, 3) of a block whose third axis points up.

    centres  (p, 3) of the cameras, which tell the street side
    scale    block units per metre, roughly: how thick a wall may be

    Lines are searched in plan by drawing pairs of points (RANSAC).
    """
    rng = np.random.default_rng(seed)
    left, walls = points, list[UprightWall]()
    thick = 0.1 * scale
    for _ in range(most):
        if len(left) < 30:
            break
        own, across = _line(left[:, :2], thick, rng)
        if own.sum() < max(20, 0.04 * len(points)):
            break
        inward = np.append(across, 0.0)
        middle = np.median(left[own] @ inward)
        if np.median(centres @ inward) > middle:
            inward, middle = -inward, -middle
        walls.append(wall_through(inward * middle, inward, left[own], float(own.sum()), "block"))
        left = left[~own]
    return walls


def _line(xy: Float, thick: float, rng: np.random.Generator, draws: int = 1500) -> tuple[Bool, Float]:
    """The points (n,) on the line with the most points, and its unit normal (2,)."""
    pairs = rng.integers(0, len(xy), (draws, 2))
    along = xy[pairs[:, 1]] - xy[pairs[:, 0]]
    length = np.linalg.norm(along, axis=1)
    far = length > 10 * thick
    if not far.any():
        return np.zeros(len(xy), np.bool_), np.array([1.0, 0.0])
    normal = np.column_stack([-along[far, 1], along[far, 0]]) / length[far, None]
    offset = np.einsum("ij,ij->i", normal, xy[pairs[far, 0]])
    sample = xy[rng.permutation(len(xy))[:4000]]
    near = (np.abs(sample @ normal.T - offset) < thick).sum(0)
    n, d = normal[near.argmax()], offset[near.argmax()]
    for _ in range(3):
        own = np.abs(xy @ n - d) < thick
        centred = xy[own] - xy[own].mean(0)
        n = np.linalg.eigh(centred.T @ centred)[1][:, 0]
        d = np.median(xy[own] @ n)
    return np.abs(xy @ n - d) < thick, n
