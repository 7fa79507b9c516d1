"""Measures how far behind the wall the frame of an opening lies."""

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.estimate import Estimate
from frontage.model.masonry import TOLERANCES
from frontage.openings.wall.crossings import CrossingBeams
from frontage.openings.wall.evidence import LARGEST

_DEEPEST = 1.0  # m: deeper points are in a room
_BIN = 0.005  # m, bin of depths
# share of the points of the densest surface that the front of the frame needs, being the foremost
_SHARE = 0.3
_FEW = 8  # points that a depth needs
_SLACK = 0.1  # share of the width that borders may be off at most; ribbons are as well known as others
AROUND = 1.2  # m around an opening within which beams determine its wall
FRAME = (0.012, 0.05)
"""The frame shows between these distances (m) from a border. The reveal is seen nearer to the border."""

BASE = 0.05
"""m by which the masonry of a ground floor may stand out before the wall"""

_BESIDE, _STRIP = 0.02, 0.3  # m off a side, and width of the strips whose density is told
_RELIEF = 0.035  # m about the local mean within which wall and relief lie
_MUCH = 0.2  # share of the points of the largest surface that the wall needs, being the rearmost
_APART = 2.0 / 3.0  # of three sigmas of a point: walls that far apart are at two levels


def find_depth(
    near: CrossingBeams,
    box: tuple[float, float, float, float],
    rise: float,
    slack: float = 0.0,
    others: Float | None = None,
    wall: tuple[float, float] | None = None,
) -> Estimate[float] | None:
    """Measures the depth m of the front of the frame behind the wall; None where too few points determine it.

    near    beams within `AROUND` of the opening
    box     of the opening, whose head is `rise` m high
    slack   m by which the borders may be off: points nearer to them may lie on a reveal
    others  (n,) m, depths y of the walls around the facade's openings
    wall    what `find_wall` returns for the box, where that is known

    The frame runs along the borders of the opening and is the foremost of the surfaces there: panes, curtains
    and rooms lie behind it, and reveals end at it. The wall is the rearmost of the surfaces that fill much of
    the surroundings: surrounds, bands and plinths stand before it.
    """
    wall = wall or find_wall(near, box, others)
    slack = min(slack, _SLACK * min(box[2] - box[0], LARGEST))
    y = _along(near, box, rise, slack, FRAME[1] + slack)
    if len(y) < _FEW:
        y = _along(near, box, rise, slack, np.inf)
    if len(y) < _FEW or wall is None:
        return None
    frame = _level(y, np.arange(wall[0] + near.wall, wall[0] + _DEEPEST, _BIN), near.wall / 3.0, _SHARE)
    if frame is None:
        return None
    variance = frame[1] ** 2 + wall[1] ** 2
    return Estimate(frame[0] - wall[0], np.array([[variance]]), float(len(y) - 1))


def find_wall(
    near: CrossingBeams, box: tuple[float, float, float, float], others: Float | None = None
) -> tuple[float, float] | None:
    """Returns the depth y m of the wall around a box and its sigma; None where too few points determine it.

    It is the rearmost of the surfaces that hold much of the surroundings. Given the depths of the walls
    around the facade's other openings (`others`, m), it is the level that they share.
    """
    x0, z0, x1, z1 = box
    on = np.flatnonzero(np.abs(near.depth) < _RELIEF)
    x, z = near.points.take(on, 1)
    on = on[(x < x0) | (x > x1) | (z < z0) | (z > z1)]
    y = near.depth[on] + near.level[on]
    if len(y) < _FEW:
        return None
    found = _level(-y, np.arange(-y.max() - _BIN, -y.min() + 2 * _BIN, _BIN), near.wall / 3.0, _MUCH)
    if found is None:
        return None
    own = -found[0], found[1]
    return own if others is None or not len(others) else _of_level(*own, others, _APART * near.wall)


def points_behind(near: CrossingBeams) -> tuple[Float, Float, Float]:
    """Returns x, y and z (n,) m of the points behind the wall, without those deep in a room."""
    deep = np.flatnonzero((near.depth > near.wall) & (near.depth < _DEEPEST))
    x, z = near.points.take(deep, 1)
    return x, near.depth[deep] + near.level[deep], z


def density_beside(near: CrossingBeams, box: tuple[float, float, float, float]) -> float:
    """Returns the beams per m2 that the wall on both sides of a box sends back."""
    x0, z0, x1, z1 = box
    x, z = near.place
    on = (np.abs(near.depth) <= near.wall) & (z > z0) & (z < z1)
    left = on & (x < x0 - _BESIDE) & (x > x0 - _BESIDE - _STRIP)
    right = on & (x > x1 + _BESIDE) & (x < x1 + _BESIDE + _STRIP)
    return float(np.median([left.sum(), right.sum()])) / max(_STRIP * (z1 - z0), 1e-6)


def _of_level(wall: float, sigma: float, others: Float, apart: float) -> tuple[float, float]:
    """Returns the depth y m of the level that a wall belongs to, and its sigma, by those of `others` (n,) m.

    Where many of them lie behind it by less than `BASE` m, the wall is relief in front of theirs, as the
    masonry of a ground floor is. The share of such others tells how likely that is.
    """
    rear = others[(others > wall + apart) & (others < wall + BASE)]
    share = len(rear) / len(others)
    if share >= _MUCH:
        main = float(np.median(rear))
        return main, float(np.hypot(sigma, (main - wall) * np.sqrt(share * (1.0 - share))))
    level = others[np.abs(others - wall) < apart]
    return float(np.median(level)) if len(level) else wall, sigma


def _level(y: Float, edge: Float, noise: float, share: float) -> tuple[float, float] | None:
    """Returns the first peak of y (n,) m that is at least `share` of the highest one, and its sigma."""
    y = np.sort(y)
    number = np.diff(np.searchsorted(y, edge))
    smooth: Float = np.convolve(number, [1.0, 1.0, 1.0], "same")
    # less the error of a count, for a few mixed echoes are not a surface
    first = int(np.argmax(smooth - np.sqrt(smooth) >= share * smooth.max()))
    while first + 1 < len(smooth) and smooth[first + 1] > smooth[first]:
        first += 1
    at = float(edge[first] + _BIN / 2)
    for _ in range(3):
        some = y[slice(*np.searchsorted(y, [at - 2.0 * noise, at + 2.0 * noise]))]
        if len(some) < _FEW // 2:
            return None
        at = float(some[(len(some) - 1) // 2] + some[len(some) // 2]) / 2.0
    # the foremost of several layers and the noise of one layer cannot be distinguished any better
    return float(some.mean()), float(
        np.hypot(some.std() / np.sqrt(len(some)), TOLERANCES.common_noise * noise)
    )


def _along(
    near: CrossingBeams, box: tuple[float, float, float, float], rise: float, slack: float, hug: float
) -> Float:
    """Returns the depths y (n,) m of the points behind the wall within `hug` m of the sides and the top.

    Points along the bottom do not count, for sills and thresholds slope.
    """
    x0, z0, x1, z1 = box
    x, y, z = points_behind(near)
    off = np.minimum(x - x0, x1 - x)
    if rise == 0.0:
        off = np.minimum(off, z1 - z)
    return y[(z > z0 + FRAME[0]) & (z < z1 - rise) & (off > FRAME[0] + slack) & (off < hug)]
