"""Finds railings: parts of a facade that show what is behind them, and that belong into its picture.

Behind a parapet the scan has no points of the wall; behind a railing it has. High up, the floor of a balcony
hides what lies right behind its railing, seen from the front, from a scanner in the street. The beams are
therefore asked as well: those that hit the wall passed between the bars, beside those that hit a bar.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int, distinct
from frontage.model import Facade, Scan

_BEFORE_M = 0.25  # of the wall: railings of windows stand farther out
_LEDGE_M = 0.5  # of the wall: farther out there are no sills and ledges
_WALL_M = 0.3  # of the plane, likewise: wall and glass
_CELL_M = 0.08  # of a railing, between two bars
_AROUND = 7  # cells, half a metre
_SEEN_THROUGH = 0.6  # share of the cells of a railing in which the wall was seen, too
_TALL_CELLS = 8  # of a railing that stands no farther out than a ledge, which is lower
_WIDE_CELLS = 5  # of a railing; the sides of a bay are narrower, seen from the front
_STATION_M = 2.0  # beams from places nearer to each other pass a railing in nearly the same way
_PLACES = (1 << 20) - 1  # along an axis, after which their numbers repeat
_FEWEST = 50  # points of parts before the wall, seen from one place, that are worth a look


@dataclass(frozen=True, eq=False)
class Beams:
    """Where points (n) were measured from.

    origins  (s, 3) float32 m in the facade frame
    index    (n,) into `origins`, -1 = unknown
    """

    origins: Array
    index: Int

    @classmethod
    def of(cls, scan: Scan | None, facade: Facade, points: Int) -> "Beams":
        """Those of some points (n,) of a scan."""
        if scan is None:
            return cls(np.zeros((0, 3), np.float32), np.full(len(points), -1, np.int64))
        origins = facade.frame.inverse.apply(scan.origins).astype(np.float32)
        return cls(origins, np.take(scan.origin_index, points).astype(np.int64))

    def and_those(self, other: "Beams") -> "Beams":
        """Returns these beams, followed by others."""
        moved = np.where(other.index < 0, -1, other.index + len(self.origins))
        return Beams(np.concatenate([self.origins, other.origins]), np.concatenate([self.index, moved]))

    def stations(self, points: Int) -> Int:
        """Returns numbers (k,) of the places that some points (k,) were measured from, -1 where unknown."""
        cell = np.floor(self.origins / np.float32(_STATION_M)).astype(np.int64) & _PLACES
        number = np.append((cell[:, 0] * (_PLACES + 1) + cell[:, 1]) * (_PLACES + 1) + cell[:, 2], -1)
        return np.take(number, self.index[points])


def find_railings(xyz: Array, beams: Beams, held: Bool) -> Bool:
    """Returns which points (n, 3) m of the facade frame belong to railings.

    `beams` are those of the points, and `held` (n,) tells which belong to the facade: of the others, beams
    are not asked. A ledge also has wall beside it, but it is low and stands near the wall.
    """
    found = xyz[:, 1] < -_BEFORE_M
    before, behind = np.flatnonzero(found), np.flatnonzero(np.abs(xyz[:, 1]) < _WALL_M)
    if not len(before) or not len(behind):
        return np.zeros_like(found)
    place = np.take(xyz[:, ::2].T, before, axis=1)
    wall = np.take(xyz[:, ::2].T, behind, axis=1)
    corner = np.minimum(place.min(axis=1), wall.min(axis=1))
    own, other = _cells(place, corner), _cells(wall, corner)
    part = _marked(own, (int(own[0].max()) + 1, int(own[1].max()) + 1))
    wide, tall = _shapes(part)
    far = xyz[before, 1] < -_LEDGE_M
    shaped = np.where(far, wide[own], (wide & tall)[own])
    square = np.ones((3, 3), np.uint8)
    seen = cv2.dilate(_marked(other, part.shape), square)
    railing = shaped & (_share(part, seen, _AROUND)[own] > _SEEN_THROUGH)
    left = shaped & ~railing & tall[own] & held[before]
    railing[left] = _passed(xyz, beams, before[left], behind)
    found[before] = railing
    return found


def _shapes(part: Array) -> tuple[Bool, Bool]:
    """Which cells (h, w) of parts before the wall are as wide as a railing, and as tall as one."""
    whole = cv2.morphologyEx(part, cv2.MORPH_CLOSE, np.ones((1, 3), np.uint8))
    wide = cv2.morphologyEx(whole, cv2.MORPH_OPEN, np.ones((1, _WIDE_CELLS), np.uint8)) > 0
    tall = cv2.morphologyEx(whole, cv2.MORPH_CLOSE, np.ones((3, 1), np.uint8))
    tall = cv2.morphologyEx(tall, cv2.MORPH_OPEN, np.ones((_TALL_CELLS, _WIDE_CELLS), np.uint8)) > 0
    return wide, tall


def _passed(xyz: Array, beams: Beams, before: Int, behind: Int) -> Bool:
    """Which of the points `before` (k,) the wall stand where beams passed and hit the points `behind` (m,).

    Every point is moved along its own beam to the plane of the wall, and compared with what was measured
    there from the same place.
    """
    passed, of_part = np.zeros(len(before), np.bool_), beams.stations(before)
    if (of_part >= 0).sum() < _FEWEST:
        return passed
    wall = np.take(xyz[:, ::2].T, behind, axis=1)
    corner = wall.min(axis=1)
    other = _cells(wall, corner)
    shape = int(other[0].max()) + 1, int(other[1].max()) + 1
    start, end = np.take(beams.origins.T, beams.index[before], axis=1), np.take(xyz.T, before, axis=1)
    ahead = (of_part >= 0) & (end[1] > start[1])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        hit = end[::2] - (end - start)[::2] * (end[1] / (end[1] - start[1]))
        last = corner + np.float32(_CELL_M) * np.array(shape[::-1], np.float32)
        inside = ahead & (hit >= corner[:, None]).all(0) & (hit < last[:, None]).all(0)
    of_wall = beams.stations(behind)
    for number in distinct(of_part[inside]).tolist():
        mine, own_wall = np.flatnonzero(inside & (of_part == number)), of_wall == number
        if len(mine) < _FEWEST or own_wall.sum() < _FEWEST:
            continue
        own = _within(_cells(hit[:, mine], corner), shape)
        # The wall is seen above and below a handrail, and only above the edge of a floor.
        seen = cv2.dilate(_marked((other[0][own_wall], other[1][own_wall]), shape), np.ones((1, 3), np.uint8))
        seen = cv2.morphologyEx(seen, cv2.MORPH_CLOSE, np.ones((3, 1), np.uint8))
        passed[mine] = _share(_marked(own, shape), seen, 3)[own] > _SEEN_THROUGH
    return passed


def _cells(place: Float, corner: Float) -> tuple[Array, Array]:
    """The rows and columns (n,) of the cells that places (2, n) m (x, z) lie in, from the lowest (2,) on."""
    column, row = (
        ((at - first) * np.float32(1.0 / _CELL_M)).astype(np.int32)
        for at, first in zip(place, corner, strict=True)
    )
    return row, column


def _marked(cells: tuple[Array, Array], shape: tuple[int, ...]) -> Array:
    """A grid (h, w) uint8 with 1 in the given cells; what lies outside is left out."""
    row, column = cells
    inside = (row < shape[0]) & (column < shape[1])
    grid = np.zeros(shape, np.uint8)
    grid[row[inside], column[inside]] = 1
    return grid


def _within(cells: tuple[Array, Array], shape: tuple[int, int]) -> tuple[Array, Array]:
    """The same cells, of which those that rounding has put beyond a grid (h, w) are moved to its edge."""
    return np.clip(cells[0], 0, shape[0] - 1), np.clip(cells[1], 0, shape[1] - 1)


def _share(part: Array, seen: Array, rows: int) -> Array:
    """The share (h, w) of the cells of a part (h, w) around each one in which the wall was `seen` (h, w)."""
    around = (_AROUND, rows)
    both = cv2.blur((part & seen).astype(np.float32), around)
    return np.asarray(both / np.maximum(cv2.blur(part.astype(np.float32), around), np.float32(1e-6)))
