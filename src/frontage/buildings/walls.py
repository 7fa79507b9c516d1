"""Wall evidence: an accumulation map, and the street fronts drawn through it.

A column of the map counts *occupied height bins* with a vertical, planar surface, not points: the
number of points
tells how near the scanner stood, the number of bins how high the wall is.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from frontage.buildings.ground import Ground
from frontage.buildings.options import BuildingOptions
from frontage.buildings.voxels import Level, Shape, mean_of
from frontage.geometry.arrays import Bool, Float, Int, distinct
from frontage.model.masonry import MASONRY

_FILL = 0.35  # share of a wall column's bins that are occupied: windows and shadows take the rest
_LINK = 2.0  # m, wall columns closer than this belong to one block
_BAND = 6.0  # m, parallel walls this far apart are one front with setbacks
_RUN_GAP = 4.0  # m, longest stretch of a front without wall (a gate, a shadow)
_MIN_FRONT = 3.0  # m, shortest front


@dataclass(frozen=True, eq=False)
class Columns:
    """Wall columns: `xy` (k, 2) m, `bins` (k,) occupied height bins, `normal` (k, 2) unit, sign
    free, `block` (k,)."""

    xy: Float
    bins: Float
    normal: Float
    block: Int


@dataclass(frozen=True, eq=False)
class Front:
    """A street front in plan: unit `along` and `out` (2,), line `origin + s along`, s from `lo` to
    `hi`, m; its columns."""

    origin: Float
    along: Float
    out: Float
    lo: float
    hi: float
    members: Int
    block: int

    def coordinates(self, xy: Float) -> tuple[Float, Float]:
        """s along the front and distance d in front of it (n,), m, of points (n, 2)."""
        q = xy - self.origin
        return q @ self.along, q @ self.out


def wall_cells(level: Level, shape: Shape, above: Bool) -> Bool:
    """Cells (m,) above ground whose surroundings are planar and upright."""
    upright = np.abs(shape.normal[:, 2]) < 0.35
    return above & upright & (shape.planarity > 0.35) & (shape.scatter < 0.12) & (shape.support >= 5)


def wall_columns(level: Level, shape: Shape, wall: Bool, options: BuildingOptions) -> Columns:
    """Columns of the accumulation map that rise high and full enough to be a wall."""
    at = np.flatnonzero(wall)
    ij, z = level.ijk[at, :2].astype(np.int64), level.ijk[at, 2].astype(np.int64)
    own, of_cell = np.unique(ij[:, 0] << 32 | ij[:, 1], return_inverse=True)
    n = len(own)
    wide = np.concatenate([(own[of_cell] + (i << 32) + j) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    target = np.searchsorted(own, wide)
    target[target == n] = 0
    hit = own[target] == wide
    pair = distinct(
        target[hit] << 24 | np.tile(z, 9)[hit]
    )  # one vote per column and height bin, its 8 neighbours helping
    column, bin_ = pair >> 24, pair & ((1 << 24) - 1)
    bins = np.bincount(column, minlength=n).astype(np.float64)
    first = np.full(n, 1 << 24)
    last = np.zeros(n, np.int64)
    np.minimum.at(first, column, bin_)
    np.maximum.at(last, column, bin_)
    need = max(3, int(np.ceil(options.min_wall_height / level.size - 1e-9)))
    good = (bins >= need) & (bins >= _FILL * (last - first + 1))
    count = np.bincount(of_cell, minlength=n).astype(np.float64)
    xy = np.column_stack([mean_of(of_cell, level.mean[at, a], count) for a in (0, 1)])
    nx, ny = shape.normal[at, 0], shape.normal[at, 1]
    double = 2 * np.arctan2(ny, nx)  # normals without sign are averaged as doubled angles
    angle = 0.5 * np.arctan2(mean_of(of_cell, np.sin(double), count), mean_of(of_cell, np.cos(double), count))
    keep = np.flatnonzero(good)
    normal = np.column_stack([np.cos(angle), np.sin(angle)])[keep]
    return Columns(xy[keep], bins[keep], normal, _blocks(xy[keep], max(_LINK, 3 * level.size)))


def _blocks(xy: Float, link: float) -> Int:
    """Labels (k,) of the groups of columns closer than `link` m."""
    if not len(xy):
        return np.empty(0, np.int64)
    pairs = cKDTree(xy).query_pairs(link, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(xy), len(xy)))
    return connected_components(graph, directed=False)[1].astype(np.int64)


def find_fronts(
    columns: Columns, ground: Ground | None, size: float, options: BuildingOptions
) -> list[Front]:
    """The fronts of every block, longest wall first; each takes the columns behind it that no
    street separates."""
    fronts: list[Front] = []
    for block in range(int(columns.block.max()) + 1 if len(columns.block) else 0):
        free = np.flatnonzero(columns.block == block)
        while len(free) >= 3:
            front = _next_front(columns, free, block, size)
            if front is None:
                break
            behind = _absorbed(columns.xy[free], front, ground, options)
            taken = np.union1d(front.members, free[behind])
            fronts.append(Front(front.origin, front.along, front.out, front.lo, front.hi, taken, block))
            free = np.setdiff1d(free, taken, assume_unique=True)
    return fronts


def _next_front(columns: Columns, free: Int, block: int, size: float) -> Front | None:
    """The line with most wall among the free columns of a block, or None when none is long enough."""
    xy, weight, normal = columns.xy[free], columns.bins[free], columns.normal[free]
    tolerance = max(MASONRY.relief, size)
    trial = np.linspace(0, len(free) - 1, min(256, len(free))).astype(np.int64)
    score = np.empty(len(trial))
    for start in range(0, len(trial), 32):  # one-point hypotheses: a column and its normal
        t = trial[start : start + 32]
        d = normal[t] @ xy.T - np.sum(normal[t] * xy[t], 1)[:, None]
        score[start : start + 32] = ((np.abs(d) < tolerance) & (np.abs(normal[t] @ normal.T) > 0.9)) @ weight
    best = trial[int(np.argmax(score))]
    origin, out = xy[best], normal[best]
    for _ in range(4):
        on = (np.abs((xy - origin) @ out) < tolerance) & (np.abs(normal @ out) > 0.9)
        if on.sum() < 3:
            return None
        origin = np.average(xy[on], axis=0, weights=weight[on])
        q = (xy[on] - origin) * np.sqrt(weight[on])[:, None]
        along = np.linalg.eigh(q.T @ q)[1][:, 1]
        out = np.array([along[1], -along[0]])
    s = (xy - origin) @ along
    band = (np.abs((xy - origin) @ out) < _BAND) & (np.abs(normal @ out) > 0.9)
    run = _heaviest_run(s, weight * on, band, max(_RUN_GAP, 4 * size))
    lo, hi = float(s[run].min()), float(s[run].max())
    if hi - lo < max(_MIN_FRONT, 3 * size):
        return None
    return Front(origin, along, out, lo, hi, free[run], block)


def _heaviest_run(s: Float, weight: Float, band: Bool, gap: float) -> Int:
    """Indices of the unbroken stretch along s, among the columns in the band, that holds most weight."""
    index = np.flatnonzero(band)
    index = index[np.argsort(s[index], kind="stable")]
    piece = np.concatenate([[0], np.cumsum(np.diff(s[index]) > gap)])
    run: Int = index[piece == np.argmax(np.bincount(piece, weights=weight[index]))]
    return run


def _absorbed(xy: Float, front: Front, ground: Ground | None, options: BuildingOptions) -> Bool:
    """Columns (k,) beside a front, up to the building depth, with less than 2 m of measured ground
    between."""
    s, d = front.coordinates(xy)
    reach = (s > front.lo - 0.6) & (s < front.hi + 0.6) & (np.abs(d) < options.max_depth)
    if ground is None:
        return reach
    index = np.flatnonzero(reach)
    step = np.linspace(0, 1, int(np.ceil(options.max_depth / 0.5)))
    path = xy[index, None] - (d[index, None, None] * front.out) * step[None, :, None]
    row, col = ground.cell_of(path.reshape(-1, 2))
    open_ = ground.measured[row, col].reshape(len(index), -1).mean(1) * np.abs(d[index])
    reach[index] = open_ < 2.0
    return reach
