"""A frame and an order of a cloud that follow from its own points.

Grids are laid along the axes, and samples are drawn by row number. So that neither the direction of north
nor the order of the points in a file decides what is found, rooms work in the canonical frame of a cloud, and
sort the points that they sample.
"""

from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float, Int, drawn, extent
from frontage.model.scan import Scan

_VOXEL_M = 0.1  # m: points of one voxel follow one another
_MOST_POINTS = 200_000  # points that tell the frame
_DIGITS = 6  # of coordinates in m: sums over another order, or turned, differ by less
_FINE_BITS = 10  # bits of each coordinate inside a voxel: 0.1 mm
_VOXEL_BITS = (63 - 3 * _FINE_BITS) // 3  # of each coordinate of a voxel; larger clouds take larger voxels
_WALL_CELL_M = 1.0  # m, plan cells that tell the direction of walls
_FEWEST_IN_CELL = 10  # points of such a cell
_ASLANT = np.array([[2.0, -1.0], [1.0, 2.0]]) / np.sqrt(5.0)  # a wall crosses two cells along, one across


def turned(scan: Scan, axes: Float) -> Scan:
    """Returns a scan in the frame of `axes` (3, 3), its columns, without its raster and lost beams."""
    bare = replace(scan, grid=None, no_returns=(), local_from_scanner=None)
    return replace(bare, xyz=steady(scan.xyz @ axes), origins=scan.origins @ axes)


def is_mirrored(axes: Float) -> bool:
    """Returns whether left and right are swapped in the frame of `axes` (3, 3)."""
    return bool(np.linalg.det(axes) < 0)


def canonical_axes(xyz: Float) -> Float:
    """Returns the axes (3, 3), as columns, of the canonical frame of points (n, 3) m.

    They lie aslant, by arctan 1/2, to the prevailing direction of the walls: most walls run along it or
    across it, and would otherwise coincide with borders of cells over their whole length. Third moments tell
    the signs of x and y: the longer tail lies on the positive side, also in a mirrored cloud, so that the
    determinant is -1 where left and right are swapped. z stays. Equal clouds get equal frames, whatever their
    order and direction, and whether they are mirrored, except where both signs are as likely.
    """
    axes = np.eye(3)
    if len(xyz) < 2:
        return axes
    plan = xyz[drawn(xyz[:, 2:], _MOST_POINTS), :2]  # by height, which turning does not change
    plan = _ordered(plan)  # sums over another order differ in their last digits
    plan -= plan.mean(0)
    along = np.linalg.eigh(plan.T @ plan)[1][:, ::-1]  # the longer first
    turned_plan = plan @ along
    along *= np.where((turned_plan * turned_plan * turned_plan).sum(0) < 0.0, -1.0, 1.0)
    angle = _wall_angle(steady(plan @ along))
    c, s = np.cos(angle), np.sin(angle)
    axes[:2, :2] = along @ np.array([[c, -s], [s, c]]) @ _ASLANT
    return axes


def _ordered(plan: Float) -> Float:
    """Returns places (n, 2) m sorted by y, then by x, in a third of the time of `numpy.lexsort`."""
    pairs = np.sort(np.ascontiguousarray(plan[:, ::-1]).view(np.complex128), axis=0)
    return np.ascontiguousarray(pairs.view(np.float64)[:, ::-1])


def steady(xyz: Float) -> Float:
    """Rounds coordinates (n, d) m to a micrometre, more than they change when a cloud is turned and back."""
    return np.round(xyz, _DIGITS)


def _wall_angle(plan: Float) -> float:
    """Returns the prevailing direction of walls, rad between +-pi/4, of points (n, 2) m in plan.

    In cells of a metre, a wall spreads along one line and the ground in all directions. The angles of the
    cells are averaged four-fold, so that walls at right angles agree.
    """
    cell = np.floor(plan / _WALL_CELL_M).astype(np.int64)
    cell -= cell.min(0)
    _, own = np.unique(cell[:, 0] * (cell[:, 1].max() + 1) + cell[:, 1], return_inverse=True)
    count = np.bincount(own)
    u, v = (plan[:, k] - (np.bincount(own, plan[:, k]) / count)[own] for k in (0, 1))
    uu, vv, uv = (np.bincount(own, m) for m in (u * u, v * v, u * v))
    spread = np.maximum(uu + vv, 1e-12)
    line = ((uu - vv + 2j * uv) / spread)[count >= _FEWEST_IN_CELL]
    return float(np.angle((line**2).sum()) / 4.0) if len(line) else 0.0


def canonical_order(xyz: Float) -> Int:
    """Returns the order (n,) of points (n, 3) m by voxel and by place within it."""
    if len(xyz) == 0:
        return np.empty(0, np.int64)
    key = _key(xyz)
    order = np.argsort(key)
    same = np.diff(key[order]) == 0
    near = np.flatnonzero(np.append(same, False) | np.append(False, same))  # closer than the key tells
    own = order[near]
    order[near] = own[np.lexsort((*xyz[own].T, key[own]))]
    return order


def _key(xyz: Float) -> Int:
    """Returns a number (n,) int64 for every point, which orders them by voxel and by place within it."""
    low, high = extent(xyz)
    voxel = max(_VOXEL_M, float((high - low).max()) / ((1 << _VOXEL_BITS) - 1))
    scale = (1 << _FINE_BITS) / voxel
    coarse, fine = np.zeros(len(xyz), np.int64), np.zeros(len(xyz), np.int64)
    for a in (2, 1, 0):
        step = ((xyz[:, a] - low[a]) * scale).astype(np.int64)
        coarse = (coarse << _VOXEL_BITS) | (step >> _FINE_BITS)
        fine = (fine << _FINE_BITS) | (step & ((1 << _FINE_BITS) - 1))
    return (coarse << 3 * _FINE_BITS) | fine
