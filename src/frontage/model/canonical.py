"""A cloud in an order and a frame that follow from its own points.

Samples are drawn by row number and grids are laid along the axes. So that neither the order of the points in
a file nor the direction of north decides what is found, rooms work on the canonical view of a cloud.
"""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.model.scan import Scan

_VOXEL_M = 0.1  # m: points of one voxel follow one another
_DIGITS = 6  # of coordinates in m: sums over another order, or turned, differ by less
_AXIS_DIGITS = 14  # of the axes' directions
_FINE_BITS = 10  # bits of each coordinate inside a voxel: 0.1 mm
_VOXEL_BITS = (63 - 3 * _FINE_BITS) // 3  # of each coordinate of a voxel; larger clouds take larger voxels
_WALL_CELL_M = 1.0  # m, plan cells that tell the direction of walls
_FEWEST_IN_CELL = 10  # points of such a cell
_ASLANT = np.array([[2.0, -1.0], [1.0, 2.0]]) / np.sqrt(5.0)  # a wall crosses two cells along, one across


@dataclass(frozen=True, eq=False)
class CanonicalView:
    """A cloud in its canonical frame and order.

    scan   the points; they have no raster and no beams without return
    order  (n,) int64, row of each point in the original cloud
    axes   (3, 3) orthogonal: ``original = axes @ canonical``. Its determinant is -1 where left and right are
           swapped
    """

    scan: Scan
    order: Int
    axes: Float

    @property
    def mirrored(self) -> bool:
        """Whether left and right are swapped."""
        return bool(np.linalg.det(self.axes) < 0)

    def rows(self, index: Int) -> Int:
        """Returns the rows (m,) of this view, ascending, of points at `index` (m,) of the original cloud."""
        chosen = np.zeros(len(self.order), np.bool_)
        chosen[index] = True
        return np.flatnonzero(chosen[self.order])


def canonical_view(scan: Scan, index: Int | None = None) -> CanonicalView:
    """Turns a cloud about the vertical, and sorts it, so that only its content decides frame and order.

    index  (m,) int64, points that decide the frame; all of them when omitted

    The frame lies aslant, by arctan 1/2, to the prevailing direction of the walls. Third moments tell the
    signs of x and y: the longer tail lies on the positive side, also in a mirrored cloud. z stays. Equal
    clouds get equal views, whatever their order and direction, and whether they are mirrored, except where
    both signs are as likely.
    """
    axes = canonical_axes(scan.xyz if index is None else scan.xyz[index])
    xyz = steady(scan.xyz @ axes)
    order = canonical_order(xyz)
    bare = replace(scan, grid=None, no_returns=(), local_from_scanner=None)
    turned = replace(bare.take(order), xyz=np.take(xyz, order, axis=0), origins=scan.origins @ axes)
    return CanonicalView(turned, order, axes)


def canonical_axes(xyz: Float) -> Float:
    """Returns the axes (3, 3), as columns, of the canonical frame of points (n, 3) m.

    They lie aslant to the prevailing direction of the walls: most walls run along it or across it, and would
    otherwise coincide with borders of cells over their whole length.
    """
    axes = np.eye(3)
    if len(xyz) < 2:
        return axes
    plan = xyz[:, :2] - xyz[:, :2].mean(0)
    along = np.linalg.eigh(plan.T @ plan)[1][:, ::-1]  # the longer first
    along *= np.where(((plan @ along) ** 3).sum(0) < 0.0, -1.0, 1.0)
    angle = _wall_angle(steady(plan @ along))
    c, s = np.cos(angle), np.sin(angle)
    x, y = (along @ np.array([[c, -s], [s, c]]) @ _ASLANT)[:, 0]
    x, y = (float(np.round(v, _AXIS_DIGITS)) for v in (x, y))  # a sum in another order gives the same axes
    x, y = x / float(np.hypot(x, y)), y / float(np.hypot(x, y))
    side = float(np.sign(np.linalg.det(along)))
    axes[:2, :2] = np.array([[x, -side * y], [y, side * x]])
    return axes


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
    key = _key(xyz)
    order = np.argsort(key, kind="stable")
    same = np.diff(key[order]) == 0
    near = np.flatnonzero(np.append(same, False) | np.append(False, same))  # closer than the key tells
    own = order[near]
    order[near] = own[np.lexsort((*xyz[own].T, key[own]))]
    return order


def _key(xyz: Float) -> Int:
    """Returns a number (n,) int64 for every point, which orders them by voxel and by place within it."""
    low, high = xyz.min(0), xyz.max(0)
    voxel = max(_VOXEL_M, float((high - low).max()) / ((1 << _VOXEL_BITS) - 1))
    scale = (1 << _FINE_BITS) / voxel
    coarse, fine = np.zeros(len(xyz), np.int64), np.zeros(len(xyz), np.int64)
    for a in (2, 1, 0):
        step = ((xyz[:, a] - low[a]) * scale).astype(np.int64)
        coarse = (coarse << _VOXEL_BITS) | (step >> _FINE_BITS)
        fine = (fine << _FINE_BITS) | (step & ((1 << _FINE_BITS) - 1))
    return (coarse << 3 * _FINE_BITS) | fine
