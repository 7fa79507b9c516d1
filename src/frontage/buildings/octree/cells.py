"""Octree cells as packed 64-bit keys, the structure that this room works on.

A level of an octree is the set of its occupied cells. The key of a cell packs its three integer coordinates
(21 bits each). A level is therefore one sorted int64 array, a parent is a shift, and a neighbour is found by
binary search.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from frontage.buildings.groups import mean_of
from frontage.errors import InputError
from frontage.geometry.arrays import Array, Float, Int, extent, sorted_groups
from frontage.model.canonical import steady

_BITS = 21  # bits of a coordinate in a key
_MAX = (1 << _BITS) - 2  # one cell is kept free on either side, so that neighbour keys never wrap
_HALF = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1) if (i, j, k) > (0, 0, 0)]


MOMENTS = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]


@dataclass(frozen=True, eq=False)
class OctreeLevel:
    """The occupied cells of one octree level, sorted by key.

    size    m, edge of a cell; `origin` (3,) m local, corner of cell (0, 0, 0)
    ijk     (m, 3) int32, cell coordinates
    key     (m,) int64, ascending
    weight  (m,) float64: points per leaf, or occupied leaves per parent
    mean    (m, 3) m local: mean of the points, or of the occupied leaves (so that density does not matter)
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
    """Packs cell coordinates (m, 3) >= 0 into keys (m,) int64."""
    i = np.asarray(ijk, np.int64) + 1
    return (i[:, 0] << 2 * _BITS) | (i[:, 1] << _BITS) | i[:, 2]


def leaf_level(xyz: Float, size: float) -> tuple[OctreeLevel, Array]:
    """Distributes points (n, 3) m into leaves of edge `size` m; also returns each point's leaf (n,) int32.

    Raises InputError when the cloud is wider than 2 million cells.
    """
    origin, far = extent(xyz)
    if float((far - origin).max()) / size > _MAX:
        raise InputError(
            f"the cloud is wider than {_MAX * size / 1000:.0f} km; cut it into tiles or remove stray points"
        )
    order, start, ijk = _occupied(xyz, origin, far, size)
    weight = np.diff(start, append=len(xyz))
    of_point = np.empty(len(xyz), np.int32)
    of_point[order] = np.repeat(np.arange(len(start), dtype=np.int32), weight)
    weight = weight.astype(np.float64)
    mean = steady(np.column_stack([mean_of(of_point, xyz[:, a], weight) for a in range(3)]))
    return OctreeLevel(size, origin, ijk, pack(ijk), weight, mean), of_point


def _occupied(xyz: Float, origin: Float, far: Float, size: float) -> tuple[Int, Int, Array]:
    """Sorts points (n, 3) m by cell of edge `size` m, counted from `origin` (3,) m; `far` is the last corner.

    Returns the order (n,), where each occupied cell starts in it (m,), and the cells' coordinates (m, 3).
    """
    shape = ((far - origin) / size).astype(np.int64) + 1
    cell = np.zeros(len(xyz), np.int64)
    for a in range(3):  # axis by axis: no (n, 3) temporary
        step = xyz[:, a] - origin[a]
        step /= size
        cell *= shape[a]
        cell += step.astype(np.int64)
    order, start = sorted_groups(cell)
    ijk = np.unravel_index(cell[order[start]], tuple(shape))
    return order, start, np.column_stack(ijk).astype(np.int32)


def parent_level(leaf: OctreeLevel, shift: int) -> tuple[OctreeLevel, Array]:
    """Builds the level `shift` steps up, with moments; also returns the parent (m,) of every leaf."""
    key, of_leaf = np.unique(pack(leaf.ijk >> shift), return_inverse=True)
    n = len(key)
    weight = np.bincount(of_leaf, minlength=n).astype(np.float64)
    mean = np.column_stack([mean_of(of_leaf, leaf.mean[:, a], weight) for a in range(3)])
    ijk = np.zeros((n, 3), np.int32)
    ijk[of_leaf] = leaf.ijk >> shift
    size = leaf.size * (1 << shift)
    d = leaf.mean - (leaf.origin + (ijk[of_leaf] + 0.5) * size)
    moment = [np.bincount(of_leaf, weights=d[:, a] * d[:, b], minlength=n) for a, b in MOMENTS]
    moments: Float = np.column_stack(moment).astype(np.float64)
    return OctreeLevel(size, leaf.origin, ijk, key, weight, mean, moments), of_leaf


def adjacency(level: OctreeLevel) -> sparse.csr_array:
    """Returns the symmetric (m, m) matrix of ones between cells that touch, with 26 neighbours each."""
    rows, cols = [], []
    for offset in _HALF:
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


def connected_cells(touch: sparse.csr_array, keep: Array) -> Int:
    """Labels the connected components of the cells kept in `keep` (m,) bool.

    Labels (m,) count from 0 by first cell; -1 marks cells that are not kept.
    """
    labels = np.full(len(keep), -1, np.int64)
    inside = np.flatnonzero(keep)
    if len(inside):
        labels[inside] = connected_components(touch[inside][:, inside], directed=False)[1]
    return labels
