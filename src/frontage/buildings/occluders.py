"""Trees, cars, lamps, people and wires: out of the buildings, kept for those who look past them.

What lies on or behind a wall is the building's (rooms seen through windows do no harm). What
stands before it is
taken piece by piece: attached, off the ground and built of surfaces, it is a balcony, a sign or an
oriel; standing
on the ground it must lean on the wall for most of its height and be built of surfaces, as stairs
and porches are.
"""

import numpy as np

from frontage.buildings.voxels import Level, Shape, components
from frontage.geometry.arrays import Array, Bool, Float, Int, distinct
from frontage.model.masonry import MASONRY

_ON_WALL = MASONRY.relief  # m in front of the wall: still its relief
_OFF_GROUND = 2.3  # m, headroom under a balcony
_TALL = 3.5  # m, an upright surface higher than any vehicle is a wall
_LEAFY = 0.5  # share of scattered cells that makes a piece foliage


def is_occluder(
    level: Level, shape: Shape, touch: object, front_of: Float, height: Float, near: Bool, wall: Bool
) -> Bool:
    """Which cells (m,) stand before the buildings.

    front_of (m,) m in front of the nearest wall;  height (m,) m above ground (inf = no ground known)
    near (m,): within reach of a building;  wall (m,): wall cells that make up the fronts
    """
    core = near & ((front_of <= _ON_WALL) | wall)
    loose = near & ~core
    piece = components(touch, loose)  # type: ignore[arg-type]
    if not loose.any():
        return loose
    n = int(piece.max()) + 1
    at = np.flatnonzero(loose)
    group = piece[at]
    count = np.bincount(group, minlength=n)
    contact = (touch @ core.astype(np.float64)) > 0  # type: ignore[operator]
    on_wall = _heights(group, level.ijk[at, 2], contact[at], n)
    tall = _heights(group, level.ijk[at, 2], np.ones(len(at), bool), n)
    leafy = np.bincount(group, weights=_scattered(shape)[at], minlength=n) / np.maximum(count, 1)
    standing = (np.abs(shape.normal[:, 2]) < 0.35) & (shape.planarity > 0.35)
    upright = np.bincount(group, weights=standing[at].astype(np.float64), minlength=n) / np.maximum(count, 1)
    base = np.full(n, np.inf)
    np.minimum.at(base, group, height[at])
    hangs = base > _OFF_GROUND
    surfaces = leafy < _LEAFY
    keep = (on_wall > 0) & surfaces & (hangs | (on_wall > 0.5 * tall))
    keep |= surfaces & (upright > 0.5) & (tall * level.size >= _TALL)
    if not np.isfinite(
        height
    ).any():  # a cut-out without ground: only foliage clear of the wall is taken from it
        keep |= surfaces | (on_wall > 0)
    out = np.zeros(len(level), bool)
    out[at] = ~keep[group]
    return out


def _scattered(shape: Shape) -> Float:
    """1 for cells (m,) whose surroundings fill space instead of a surface or a line."""
    return ((shape.scatter > 0.1) & (shape.linearity < 0.7)).astype(np.float64)


def _heights(group: Int, k: Array, keep: Bool, n: int) -> Float:
    """Number (n,) of height bins k that the kept cells of each group occupy."""
    pairs = distinct(group[keep] << 32 | k[keep].astype(np.int64))
    return np.bincount(pairs >> 32, minlength=n).astype(np.float64)
