"""Tell which side of a front is the street."""

import numpy as np

from frontage.buildings.cloud import StreetCloud
from frontage.buildings.fronts.front import StreetFront
from frontage.buildings.fronts.wall_map import WallMap
from frontage.geometry.arrays import Float, drawn
from frontage.model.masonry import MASONRY

_PAVEMENT_M = 6.0  # m before a front in which its pavement is looked for
_ON_WALL_M = 0.5  # m on either side of a front: points of its wall
_SKIN_M = MASONRY.relief  # m, half thickness of the wall's surface
_MOST_POINTS = 20_000  # points whose rays are examined
_FEWEST_CELLS = 20  # on one side, before their share says anything


def measured_side(front: StreetFront, cloud: StreetCloud) -> float:
    """Returns the side of a front on which its street lies, +1 along `out` or -1 against it; 0 if unknown.

    The rays tell it where points know theirs, else measured ground does.
    """
    return _by_rays(front, cloud) or _by_ground(front, cloud)


def _by_rays(front: StreetFront, cloud: StreetCloud) -> float:
    """Returns +1 or -1 by the sensors that measured points of this wall; 0 without rays."""
    scan = cloud.scan
    if not scan.has_origins:
        return 0.0
    pick = drawn(scan.xyz[:, 2:], _MOST_POINTS)
    s, d = front.coordinates(scan.xyz[pick, :2])
    on = pick[(s > front.lo) & (s < front.hi) & (np.abs(d) < _ON_WALL_M)]
    eye = scan.sensor_of(on)[:, :2]
    away = front.coordinates(eye[np.isfinite(eye[:, 0])])[1]
    away = away[np.abs(away) > _ON_WALL_M]
    return float(np.sign(np.sign(away).sum()))


def _by_ground(front: StreetFront, cloud: StreetCloud) -> float:
    """Returns +1 or -1 by the side with clearly more measured ground beside the wall; 0 if undecided."""
    ground = cloud.ground
    if ground is None:
        return 0.0
    row, col = np.nonzero(ground.measured)
    xy = ground.corner + (np.column_stack([col, row]) + 0.5) * ground.cell
    s, d = front.coordinates(xy)
    beside = (s > front.lo) & (s < front.hi) & (np.abs(d) > _ON_WALL_M) & (np.abs(d) < _PAVEMENT_M)
    plus, minus = int((beside & (d > 0)).sum()), int((beside & (d < 0)).sum())
    return float(np.sign(plus - minus)) if max(plus, minus) > 1.5 * min(plus, minus) + 4 else 0.0


def opaque_side(cloud: StreetCloud, walls: WallMap, s: Float, d: Float) -> float:
    """Returns the side of a front that is the street, +1 along `out` or -1 against it; 0 if undecided.

    Nothing is seen *behind* a closed piece of wall, so the street is on the side where more cells project
    onto closed wall.

    s, d  (m,) m, coordinates of all coarse cells in the front's frame, NaN for cells that are not near it
    """
    near = np.isfinite(d)
    if not near.any():
        return 0.0
    level = cloud.tree.level
    shape = (int(np.nanmax(s - np.nanmin(s)) / level.size) + 2, int(level.ijk[:, 2].max()) + 1)
    column = np.zeros(len(s), np.int64)
    column[near] = ((s[near] - np.nanmin(s)) / level.size).astype(np.int64)
    closed = np.zeros(shape, bool)
    skin = near & walls.cells & (np.abs(np.where(near, d, np.inf)) < _SKIN_M)
    closed[column[skin], level.ijk[skin, 2]] = True
    share = []
    for side in (1.0, -1.0):
        beyond = near & (side * np.where(near, d, 0) > _ON_WALL_M)
        hits = closed[column[beyond], level.ijk[beyond, 2]]
        share.append(hits.mean() if len(hits) >= _FEWEST_CELLS else np.nan)
    return float(np.sign(share[0] - share[1])) if np.isfinite(share).all() else 0.0
