"""Octree cells as packed 64-bit keys: the only structure this room works on.

A level of an octree is the set of its occupied cells. A cell's key packs its three integer
coordinates (21 bits
each), so a level is one sorted int64 array, a parent is a shift, and a neighbour is a binary search.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from frontage.errors import InputError
from frontage.geometry.arrays import Array, Float, Int

_BITS = 21
_MAX = (1 << _BITS) - 2  # one cell is kept free on either side, so that neighbour keys never wrap
HALF = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1) if (i, j, k) > (0, 0, 0)]


@dataclass(frozen=True, eq=False)
class Level:
    """Occupied cells of one octree level, sorted by key.

    size    m, edge of a cell;  origin (3,) m local, corner of cell (0, 0, 0)
    ijk     (m, 3) int32 cell coordinates
    key     (m,) int64, ascending
    weight  (m,) float64: points per leaf, or occupied leaves per parent
    mean    (m, 3) m local: mean of the points, or of the occupied leaves (so that density has no say)
    moment  (m, 6) m2: second moments xx xy xz yy yz zz of the leaves about the cell's centre; None for leaves
    """

    size: float
    origin: Float
    ijk: Array
    key: Int
    weight: Float
    mean: Float
    moment: Float | None = None

    def __len__(self) -> int:
        return len(self.key)


def pack(ijk: Array) -> Int:
    """Cell coordinates (m, 3) >= 0 to keys (m,) int64."""
    i = np.asarray(ijk, np.int64) + 1
    return (i[:, 0] << 2 * _BITS) | (i[:, 1] << _BITS) | i[:, 2]


def leaves(xyz: Float, size: float) -> tuple[Level, Array]:
    """Distribute points (n, 3) m into octree leaves of edge `size` m; also the leaf of every point
    (n,) int32.

    Raises InputError when the cloud is wider than 2 million cells.
    """
    origin, far = extent(xyz)
    if float((far - origin).max()) / size > _MAX:
        raise InputError(
            f"the cloud is wider than {_MAX * size / 1000:.0f} km; cut it into tiles or remove stray points"
        )
    key = np.zeros(len(xyz), np.int64)
    for a in range(3):  # axis by axis: no (n, 3) temporary
        key <<= _BITS
        key |= ((xyz[:, a] - origin[a]) / size).astype(np.int64) + 1
    unique, of_point = np.unique(key, return_inverse=True)
    of_point = of_point.astype(np.int32)
    weight = np.bincount(of_point, minlength=len(unique)).astype(np.float64)
    mean = np.column_stack([mean_of(of_point, xyz[:, a], weight) for a in range(3)])
    mask = (1 << _BITS) - 1
    ijk = np.column_stack([unique >> 2 * _BITS, (unique >> _BITS) & mask, unique & mask]).astype(np.int32) - 1
    return Level(size, origin, ijk, unique, weight, mean), of_point


def extent(xyz: Float) -> tuple[Float, Float]:
    """Least and greatest coordinates (3,) of points (n, 3), column by column: numpy is slow across rows."""
    columns = [xyz[:, a] for a in range(xyz.shape[1])]
    return np.array([c.min() for c in columns]), np.array([c.max() for c in columns])


def mean_of(group: Array, value: Array, count: Float) -> Float:
    """Mean (m,) of `value` (n,) per group (n,) int, `count` (m,) members each."""
    return np.bincount(group, weights=value, minlength=len(count)) / np.maximum(count, 1)


def grouped(group: Array, count: int) -> tuple[Int, Int]:
    """Members (n,) int64 sorted by group -1 .. count - 1, and where each group >= 0 begins (count + 1,)."""
    small = group.astype(np.int16) if count < 1 << 15 else group  # 16 bits are sorted by radix, in O(n)
    sort = np.argsort(small, kind="stable").astype(np.int64)
    size = np.bincount(group + 1, minlength=count + 1)
    return sort, np.cumsum(size).astype(np.int64)


def parents(leaf: Level, shift: int) -> tuple[Level, Array]:
    """The level `shift` steps up the octree, with moments of its leaves; and the parent of every
    leaf (m,) int64."""
    key, of_leaf = np.unique(pack(leaf.ijk >> shift), return_inverse=True)
    n = len(key)
    weight = np.bincount(of_leaf, minlength=n).astype(np.float64)
    mean = np.column_stack([mean_of(of_leaf, leaf.mean[:, a], weight) for a in range(3)])
    ijk = np.zeros((n, 3), np.int32)
    ijk[of_leaf] = leaf.ijk >> shift
    size = leaf.size * (1 << shift)
    d = leaf.mean - (leaf.origin + (ijk[of_leaf] + 0.5) * size)
    pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
    moment = np.column_stack([np.bincount(of_leaf, weights=d[:, a] * d[:, b], minlength=n) for a, b in pairs])
    moments: Float = moment.astype(np.float64)
    return Level(size, leaf.origin, ijk, key, weight, mean, moments), of_leaf


def adjacency(level: Level) -> sparse.csr_array:
    """Symmetric (m, m) matrix of ones between cells that touch (26-neighbourhood), without the diagonal."""
    rows, cols = [], []
    for offset in HALF:
        step = np.int64((offset[0] << 2 * _BITS) + (offset[1] << _BITS) + offset[2])
        at = np.searchsorted(level.key, level.key + step)
        at[at == len(level)] = 0
        hit = np.flatnonzero(level.key[at] == level.key + step)
        rows.append(hit)
        cols.append(at[hit])
    i, j = np.concatenate(rows), np.concatenate(cols)
    one = np.ones(2 * len(i), np.float64)
    shape = (len(level), len(level))
    return sparse.csr_array((one, (np.concatenate([i, j]), np.concatenate([j, i]))), shape=shape)


def components(touch: sparse.csr_array, keep: Array) -> Int:
    """Connected components of the kept cells (m,) bool: labels (m,) from 0 by first cell, -1 = not kept."""
    labels = np.full(len(keep), -1, np.int64)
    inside = np.flatnonzero(keep)
    if len(inside):
        labels[inside] = connected_components(touch[inside][:, inside], directed=False)[1]
    return labels


@dataclass(frozen=True, eq=False)
class Shape:
    """How the leaves around each cell (its 26 neighbours included) lie: eigenvalues l1 >= l2 >= l3
    of their scatter.

    normal (m, 3) unit;  linearity (l1-l2)/l1, planarity (l2-l3)/l1, scatter l3/l1, each (m,);
    support (m,) leaves
    """

    normal: Float
    linearity: Float
    planarity: Float
    scatter: Float
    support: Float


def shape_of(level: Level, touch: sparse.csr_array) -> Shape:
    """Principal components of the leaves in every cell's 3 x 3 x 3 neighbourhood."""
    around = touch + sparse.identity(len(level), format="csr")
    centre = level.origin + (level.ijk + 0.5) * level.size
    n = around @ level.weight
    first = level.mean - centre
    moment = level.moment
    assert moment is not None
    # moments about one common point would lose digits; about the cells' centres they are shifted below
    pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
    local = centre - centre.mean(0)
    s1 = level.weight[:, None] * (local + first)
    mean = (around @ s1) / n[:, None]
    cov = np.empty((len(level), 3, 3))
    for q, (a, b) in enumerate(pairs):
        w, da, db = level.weight, first[:, a], first[:, b]
        raw = moment[:, q] + w * (local[:, a] * db + local[:, b] * da + local[:, a] * local[:, b])
        cov[:, a, b] = cov[:, b, a] = (around @ raw) / n - mean[:, a] * mean[:, b]
    value, vector = np.linalg.eigh(cov)
    l3, l2, l1 = np.maximum(value, 0).T
    l1 = np.maximum(l1, 1e-12)
    return Shape(vector[:, :, 0], (l1 - l2) / l1, (l2 - l3) / l1, l3 / l1, n)
