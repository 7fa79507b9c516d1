"""Finds the things that stand free before a facade, from the points between it and the street.

Points in front of the wall and above the ground are joined in cubes of a quarter of a metre. A group that
the wall holds belongs to the facade (a balcony, an awning), and large upright planes are walls of neighbours
and wings: they hide the facade, and nobody sees through them or finds them gone.
What stands on the ground is held only if its points go on up to the wall: a walker may pass close to it.
The rest are occluders, each with the smallest box that stands upright. Their cubes tell which points of any
cloud of the street are theirs: boxes would also take what stands under the crown of a tree.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import cv2
import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Array, Bool, Float, Int, picked_rows
from frontage.model import Facade, Scan
from frontage.model.occluder import Occluder
from frontage.ortho.cloud import in_facade_frame
from frontage.ortho.standing.groups import FEWEST_POINTS, TOUCH_M, Group, loose_groups
from frontage.ortho.standing.kinds import chances

_CUBE_M = 0.25
_CUBE_SPACINGS = 3.0
_BEFORE_M = 0.3  # of the wall, deeper than cornices and sills
_ON_WALL_M = 0.08  # before the plane: the wall itself and its ornaments
_WALL_SAMPLED = 8  # one of so many of its points helps to tell where the ground is
_STREET_M = 12.0  # before the facade, what is farther hides little of it
_BESIDE_M = 1.0  # what stands so far beside the facade still counts
_AROUND_M = 5.0  # points so far beside it are looked at, so that no tree is cut
_GROUND_M = 0.25  # above the ground, higher than kerbs
_GROUND_CELL_M = 1.0
_GROUND_CELLS = 5  # wide windows over which the lowest points are the ground: cars are 2 m wide
_NEIGHBOURHOOD_M = 0.5
_SOLID = ("car", "person", "sign")  # what nobody sees through


@dataclass(frozen=True, eq=False)
class Standing:
    """What stands free before a facade, from left to right, and the space that it takes.

    occluders  the things
    corner     (3,) m in the facade frame, of the first cube
    cube       m, edge of a cube
    filled     (i, j, k) bool, cubes that hold points of the things
    solid      (i, j, k) bool, those of things without gaps to see through
    walls      (i, j, k) bool, those of neighbouring walls, which are no things
    """

    occluders: tuple[Occluder, ...] = ()
    corner: Float = field(default_factory=lambda: np.zeros(3))
    cube: float = _CUBE_M
    filled: Bool = field(default_factory=lambda: np.zeros((0, 0, 0), np.bool_))
    solid: Bool = field(default_factory=lambda: np.zeros((0, 0, 0), np.bool_))
    walls: Bool = field(default_factory=lambda: np.zeros((0, 0, 0), np.bool_))

    def holds(self, xyz_facade: Array, asked: Bool | None = None) -> Bool:
        """Returns which points (n, 3) m of the facade frame belong to the things and not to the facade.

        Only those that are `asked` (n,) are looked at.
        """
        every = np.ones(len(xyz_facade), np.bool_) if asked is None else asked
        (held,) = self._within(xyz_facade, every, self.filled)
        return held

    def parted(self, xyz_facade: Array) -> tuple[Bool, Bool, Bool]:
        """Returns which points (n, 3) m of the facade frame belong to things, to solid ones, and to walls.

        Solid are those without gaps, such as cars; the walls are those of neighbours.
        """
        every = np.ones(len(xyz_facade), np.bool_)
        things, solid, walls = self._within(xyz_facade, every, self.filled, self.solid, self.walls)
        return things, solid, walls

    def _within(self, xyz_facade: Array, asked: Bool, *cubes: Bool) -> list[Bool]:
        """Which of the `asked` (n,) points (n, 3) lie in each of several sets of cubes of one shape."""
        left = np.flatnonzero(asked & (xyz_facade[:, 1] < -_BEFORE_M))
        cube = np.zeros(len(left), np.int64)
        for axis, first, count in zip(xyz_facade.T, self.corner, self.filled.shape, strict=True):
            at = (np.take(axis, left) - first) / self.cube
            inside = np.flatnonzero((at >= 0) & (at < count))
            left, at = np.take(left, inside), np.take(at, inside)
            cube = np.take(cube, inside) * count + at.astype(np.int64)
        held = [np.zeros(len(xyz_facade), np.bool_) for _ in cubes]
        for found, filled in zip(held, cubes, strict=True):
            if len(left):
                found[left] = np.take(filled.ravel(), cube)
        return held


def find_standing(facade: Facade, scan: Scan, xyz: Array | None = None) -> Standing:
    """Finds what stands free within 12 m before a facade.

    `xyz` are the points `in_facade_frame`, where they are known already.
    """
    xyz = in_facade_frame(scan, facade) if xyz is None else xyz
    (x0, _), (x1, z1) = facade.outline.min(0).tolist(), facade.outline.max(0).tolist()
    x, y, z = xyz.T
    near = (y > -_STREET_M) & (y < TOUCH_M) & (z < z1 + _AROUND_M)
    near &= (x > x0 - _AROUND_M) & (x < x1 + _AROUND_M)
    if np.count_nonzero(near) < FEWEST_POINTS:
        return Standing()
    ahead, wall = y < -_ON_WALL_M, np.flatnonzero(near & (y >= -_ON_WALL_M))
    lowest = np.take(xyz.T, wall[::_WALL_SAMPLED], axis=1)
    xyz = picked_rows(near & ahead, xyz)
    ground = _ground(np.concatenate([xyz.T, lowest], axis=1).T)
    height = xyz[:, 2] - ground(xyz)
    before = (xyz[:, 1] < -_BEFORE_M) & (height > _GROUND_M)
    if not before.any():
        return Standing()
    edge = max(_CUBE_M, _CUBE_SPACINGS * facade.spacing)
    corner = xyz[before].min(0).astype(np.float64)
    corner[2] -= edge  # a layer below the lowest point, for the feet
    cube = np.floor((xyz[before] - corner) / edge).astype(np.int64)
    between = (xyz[:, 1] >= -_BEFORE_M) & (height > _GROUND_M)
    joining = np.floor((xyz[between] - corner) / edge).astype(np.int64)
    loose, walls = loose_groups(Group(xyz[before], height[before], cube), joining)
    groups = [g for g in loose if g.xyz[:, 0].max() >= x0 - _BESIDE_M and g.xyz[:, 0].min() <= x1 + _BESIDE_M]
    things = [_described(g, facade) for g in groups]
    found = sorted(things, key=lambda one: float(one.centre[0]))
    named = tuple(_renamed(one, f"{facade.id}/X{n}") for n, one in enumerate(found, 1))
    solid = [g for g, one in zip(groups, things, strict=True) if one.kind in _SOLID]
    shape = cube.max(0) + 1
    return Standing(named, corner, edge, *(_filled(part, shape) for part in (groups, solid, walls)))


def _filled(groups: list[Group], shape: Int) -> Bool:
    """The cubes (`shape`) of the groups, and those below them that hold their feet."""
    filled = np.zeros(tuple(shape), np.bool_)
    for group in groups:
        filled[tuple(group.cube.T)] = True
        low = group.cube[group.height < 2.0 * _GROUND_M]
        filled[low[:, 0], low[:, 1], low[:, 2] - 1] = True
    return filled


def _ground(xyz: Array) -> Callable[[Array], Float]:
    """Returns the height z (k,) m of the ground below points (k, 3) that lie among the given ones (n, 3).

    It is that of the lowest points around, smoothed.
    """
    x0, y0 = float(xyz[:, 0].min()), float(xyz[:, 1].min())

    def cells(points: Array) -> tuple[Int, Int]:
        column, row = ((points[:, k] - first) / _GROUND_CELL_M for k, first in ((0, x0), (1, y0)))
        return column.astype(np.int64), row.astype(np.int64)

    at = cells(xyz)
    low = np.full((int(at[0].max()) + 1, int(at[1].max()) + 1), np.inf)
    np.minimum.at(low.reshape(-1), at[0] * low.shape[1] + at[1], xyz[:, 2].astype(np.float64))
    low = ndimage.minimum_filter(low, _GROUND_CELLS, mode="nearest")
    ceiling = float(np.quantile(low[np.isfinite(low)], 0.9)) if np.isfinite(low).any() else 0.0
    low = np.minimum(low, ceiling)
    smooth = ndimage.uniform_filter(low, _GROUND_CELLS, mode="nearest")
    return lambda points: np.asarray(smooth[cells(points)])


def _described(group: Group, facade: Facade) -> Occluder:
    """The occluder of a group, without an id."""
    (x, y), (a, b), angle = cv2.minAreaRect(group.xyz[:, :2].astype(np.float32))
    length, width = max(a, b), min(a, b)
    heading = np.radians(angle if a >= b else angle + 90.0)
    heading = float((heading + np.pi / 2) % np.pi - np.pi / 2)
    low, high = float(group.xyz[:, 2].min()), float(group.xyz[:, 2].max())
    on_ground = float(group.height.min()) < 2.0 * _GROUND_M
    bottom = low - float(group.height.min()) if on_ground else low
    kinds = chances(length, width, high - low, float(group.height.max()), _roundness(group.xyz))
    return Occluder(
        "",
        kinds,
        np.array([x, y, 0.5 * (bottom + high)]),
        np.array([length, width, high - bottom]),
        heading,
        float(facade.spacing / np.sqrt(12.0)),
        len(group.xyz),
    )


def _roundness(xyz: Array) -> float:
    """Median share of the smallest principal variance of the points (n, 3) in cubes of half a metre."""
    key = np.floor(xyz / _NEIGHBOURHOOD_M).astype(np.int64)
    key -= key.min(0)
    flat = np.ravel_multi_index(tuple(key.T), tuple(key.max(0) + 1))
    _, inverse, count = np.unique(flat, return_inverse=True, return_counts=True)
    mean = np.stack([np.bincount(inverse, xyz[:, c]) for c in range(3)], 1) / count[:, None]
    off = xyz - mean[inverse]
    spread = np.stack([np.bincount(inverse, off[:, i] * off[:, j]) for i in range(3) for j in range(3)], 1)
    values = np.linalg.eigvalsh((spread / count[:, None]).reshape(-1, 3, 3)[count >= 5])
    if not len(values):
        return 1e-3
    return float(np.median(values[:, 0] / np.maximum(values.sum(1), 1e-12)))


def _renamed(one: Occluder, name: str) -> Occluder:
    return Occluder(name, one.chances, one.centre, one.size, one.heading, one.sigma, one.points)
