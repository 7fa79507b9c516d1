"""Draw lines through the wall columns of each block: the street fronts in plan."""

from dataclasses import replace

import numpy as np

from frontage.buildings.cloud import StreetCloud
from frontage.buildings.fronts.front import StreetFront
from frontage.buildings.fronts.street_side import measured_side
from frontage.buildings.fronts.wall_map import WallMap
from frontage.geometry.arrays import Bool, Float, Int
from frontage.model.masonry import MASONRY

_BAND_M = 6.0  # m, parallel walls up to this far apart are one front with setbacks
_RUN_GAP_M = 4.0  # m, longest stretch of a front without wall (a gate, a shadow)
_SPANNED = 0.9  # share of a longer stretch over which wall goes on above
_MIN_FRONT_M = 3.0  # m, shortest front
_ON_LINE_M = MASONRY.relief  # m, columns this near a line are on it
_PARALLEL_COS = 0.9  # cosine between the normals of a column and a line: 25 degrees
_HYPOTHESES = 256  # lines tried, each through one column along its normal
_STEPS = 4  # steps of the least-squares fit
_BESIDE_M = 0.6  # m past the ends of a front in which columns still belong to it
_STREET_M = 2.0  # m of measured ground that separate a column from a front
_PATH_STEP_M = 0.5  # m between the places where ground is looked for


def draw_fronts(cloud: StreetCloud, walls: WallMap) -> list[StreetFront]:
    """Draws the fronts of every block, the one with most wall first.

    Each front faces its street where that is measured, and takes the columns behind it that no street
    separates from it.
    """
    fronts: list[StreetFront] = []
    for block in range(int(walls.block.max()) + 1 if len(walls.block) else 0):
        free = np.flatnonzero(walls.block == block)
        while len(free) >= 3:
            front = _next_front(walls, free, block, cloud.tree.level.size)
            if front is None:
                break
            front = front.facing(measured_side(front, cloud))
            behind = _absorbed(walls.xy[free], front, cloud)
            taken = np.union1d(front.members, free[behind])
            fronts.append(replace(front, members=taken))
            free = np.setdiff1d(free, taken, assume_unique=True)
    return fronts


def _next_front(walls: WallMap, free: Int, block: int, size: float) -> StreetFront | None:
    """Finds the line with most wall among the free columns (k,) of a block; None when it is too short.

    size m, edge of a coarse cell.
    """
    xy, weight, normal = walls.xy[free], walls.bins[free], walls.normal[free]
    tolerance = max(_ON_LINE_M, size)
    best = _best_column(xy, normal, weight, tolerance)
    origin, out = xy[best], normal[best]
    for _ in range(_STEPS):
        on = (np.abs((xy - origin) @ out) < tolerance) & (np.abs(normal @ out) > _PARALLEL_COS)
        if on.sum() < 3:
            return None
        origin = np.average(xy[on], axis=0, weights=weight[on])
        q = (xy[on] - origin) * np.sqrt(weight[on])[:, None]
        along = np.linalg.eigh(q.T @ q)[1][:, 1]
        out = np.array([along[1], -along[0]])
    s = (xy - origin) @ along
    band = (np.abs((xy - origin) @ out) < _BAND_M) & (np.abs(normal @ out) > _PARALLEL_COS)
    if not band.any():  # the line of a few columns need not run as they face
        return None
    lintels = walls.lintels - origin
    lintels = lintels[np.abs(lintels @ out) < tolerance]
    is_open = _open_stretches(s[band], lintels @ along, max(_RUN_GAP_M, 4 * size), size)
    run = _heaviest_run(s, weight * on, band, is_open)
    lo, hi = float(s[run].min()), float(s[run].max())
    if hi - lo < max(_MIN_FRONT_M, 3 * size):
        return None
    return StreetFront(origin, along, out, lo, hi, free[run], block)


def _best_column(xy: Float, normal: Float, weight: Float, tolerance: float) -> int:
    """Returns the column whose own line, through it and across its normal, holds the most wall."""
    trial = np.linspace(0, len(xy) - 1, min(_HYPOTHESES, len(xy))).astype(np.int64)
    score = np.empty(len(trial))
    for start in range(0, len(trial), 32):
        t = trial[start : start + 32]
        d = normal[t] @ xy.T - np.sum(normal[t] * xy[t], 1)[:, None]
        on = (np.abs(d) < tolerance) & (np.abs(normal[t] @ normal.T) > _PARALLEL_COS)
        score[start : start + 32] = on @ weight
    return int(trial[int(np.argmax(score))])


def _open_stretches(s: Float, lintels: Float, gap: float, size: float) -> Bool:
    """Returns which stretches (k - 1,) between columns at s (k,) m along a line break it, in order.

    Such a stretch is longer than `gap` m, and the places `lintels` (n,) m of wall above openings, in cells of
    `size` m, do not cover it.
    """
    edge = np.sort(s)
    length = np.diff(edge)
    covered = np.unique(np.floor(lintels / size))
    spanned = np.diff(np.searchsorted(covered, edge / size)) * size
    open_: Bool = (length > gap) & (spanned < _SPANNED * length)
    return open_


def _heaviest_run(s: Float, weight: Float, band: Bool, is_open: Bool) -> Int:
    """Returns the columns of the unbroken stretch along s, within the band, that holds the most weight.

    is_open  (k - 1,) whether the stretch between two of the k columns of the band, in order, is a break
    """
    index = np.flatnonzero(band)
    index = index[np.argsort(s[index], kind="stable")]
    piece = np.concatenate([[0], np.cumsum(is_open)])
    run: Int = index[piece == np.argmax(np.bincount(piece, weights=weight[index]))]
    return run


def _absorbed(xy: Float, front: StreetFront, cloud: StreetCloud) -> Bool:
    """Returns the columns (k,) beside a front that belong to it.

    They lie within the depth of a building, with less than 2 m of measured ground between. Once the street
    side is known, columns on that side belong to the front only as far out as parallel walls do.
    """
    s, d = front.coordinates(xy)
    depth = cloud.options.max_depth
    before = _BAND_M if front.faces_street else depth
    reach = (s > front.lo - _BESIDE_M) & (s < front.hi + _BESIDE_M) & (d > -depth) & (d < before)
    if cloud.ground is None:
        return reach
    index = np.flatnonzero(reach)
    step = np.linspace(0, 1, int(np.ceil(depth / _PATH_STEP_M)))
    path = xy[index, None] - (d[index, None, None] * front.out) * step[None, :, None]
    row, col = cloud.ground.cell_of(path.reshape(-1, 2))
    open_ = cloud.ground.measured[row, col].reshape(len(index), -1).mean(1) * np.abs(d[index])
    reach[index] = open_ < _STREET_M
    return reach
