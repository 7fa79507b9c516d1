"""Gives a storey or an annex that stands out from the rest of its front a plane of its own.

The search claims everything near a plane for it. Where the largest plane is a recessed wall above a
rusticated basement, the bars of the windows below may happen to lie in it, while the wall around these
windows stands well before it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from frontage.facades.candidate import FacadeCandidate, refine_candidate
from frontage.facades.cells import CellMap
from frontage.facades.remaining import on_walls, without_doubles
from frontage.facades.scene import FacadeScene
from frontage.facades.sequential import is_large, least_area
from frontage.geometry.arrays import Array, Bool, Int, distinct
from frontage.model.masonry import MASONRY, TOLERANCES

_BIN_M = MASONRY.step_out / 2.0  # m of depth
_LAYER = 3  # bins of a wall with joints and courses that leans a little
_FARTHEST_M = MASONRY.pier  # m before the plane of a part beside the rest: farther ones are bays
_AROUND_M = 1.0  # side of the surroundings of a cell
_FILLED = 0.5  # share of them that a wall fills, unlike the bars of windows
_MORE = 0.1  # share of a row by which more of it lies before the plane than on it
_LESS = 0.5  # share of the wall of a part that the facade may show there: panes, and spandrels in its plane
_FEW = 0.2  # share of the wall of a part that may lie beyond it
_MOST = 0.5  # share of the columns of a storey that show its wall
_BOUNDED = 0.9  # share of the length of an upright seam along which the facade shows wall


def with_standing_parts(
    facades: Sequence[FacadeCandidate], scene: FacadeScene, rng: np.random.Generator
) -> list[FacadeCandidate]:
    """Returns the facades, with every part that stands out from one of them as a facade of its own.

    Seams give every row, or every column, of cells to the plane that shows more wall there. A storey stands
    out by more than relief, lies below or above the rest of the front, and shows as much more wall than the
    other plane as a facade needs; an annex lies left or right of it. What shows much wall in between as well
    is no such part. A part that is one of the facades already only ends the outline of the other one.
    """
    found: list[FacadeCandidate] = []
    rest = list(facades)
    while rest:
        facade = rest.pop(0)
        parts = _parts(facade, [*found, *rest], scene, rng)
        if parts is None:
            found.append(facade)
        else:
            rest = [parts[0], *rest]
            found += parts[1:]
    return without_doubles(found, scene) if len(found) > len(facades) else found


def _parts(
    facade: FacadeCandidate, others: Sequence[FacadeCandidate], scene: FacadeScene, rng: np.random.Generator
) -> list[FacadeCandidate] | None:
    """Returns the rest of a facade and the part that stands out from it, if that is new; None without one."""
    seam = _seam(facade, others, scene.options.min_area)
    if seam is None:
        return None
    left = replace(facade, cells=_cut(facade.cells, ~seam.part))
    if seam.y is None:
        return [left]
    part = _part(facade, seam, seam.y, scene, rng)
    return [left, part] if part else None


@dataclass(frozen=True, eq=False)
class _Seam:
    """A part that stands out.

    y     m, depth of its wall, negative; None where that is one of the facades already
    part  (h, 1) or (1, w) whether the rows or the columns of cells belong to it
    """

    y: float | None
    part: Bool


@dataclass(frozen=True, eq=False)
class _View:
    """What a front shows in its cells (h, w); for upright seams transposed, so that columns are rows.

    whole   (h, w) cells of its outline
    wall    (h, w) those that show its own wall
    own     (h, w) those of them that it fills
    before  (h, w) cells that show something before the plane
    walls   (layers + 1, h, w) those that a wall in each layer before the plane fills; last, other facades
    room    (1, k) or (k, 1) a level line of cells, as long as the front of a room is wide
    least   cells, rows of the smallest part
    """

    whole: Bool
    wall: Bool
    own: Bool
    before: Bool
    walls: Bool
    room: Bool
    least: float

    def ends(self) -> tuple[Bool, Bool]:
        """Returns the rows (h,), from the first on and up to the last, that show more before the plane."""
        gain = self.before.sum(1) - self.wall.sum(1) - _MORE * self.whole.sum(1)
        row = np.arange(len(gain))
        return row <= np.cumsum(gain).argmax(), row[::-1] <= np.cumsum(gain[::-1]).argmax()

    def gain(self, rows: Bool) -> tuple[int, int]:
        """Returns the layer with most wall in rows (h,), and how many cells of wall more than the facade."""
        area = self.walls[:, rows].sum((1, 2))
        return int(area.argmax()), int(area.max()) - int(self.own[rows].sum())

    def is_part(self, layer: int, rows: Bool, between: Bool) -> bool:
        """Returns whether rows (h,) at one end of the front, with their wall in a layer, are a part.

        `between` (h,) are the rows that belong to neither end. Pilasters, buttresses and the pedestals of
        columns are narrower than a room and do not count.
        """
        wall, inside = self.walls[layer], int(self.walls[layer, rows].sum())
        beyond = ndimage.binary_opening(wall & between[:, None], self.room)
        spans = wall[rows].any(0).sum() > _MOST * self.whole[rows].any(0).sum()
        is_own = beyond.sum() <= _FEW * inside and self.own[rows].sum() <= _LESS * inside
        return bool(spans and is_own and (self.whole.any(1) & rows).sum() >= self.least)


def _views(facade: FacadeCandidate, others: Sequence[FacadeCandidate]) -> tuple[_View, _View]:
    """Returns the views of a facade for level and for upright seams."""
    cells, (layers, known) = facade.cells, _shown_before(facade, others)
    walls = np.stack([_filled(shown, cells.cell) for shown in (*layers, known)])
    room = np.ones((1, round(MASONRY.room_width / cells.cell)), np.bool_)
    # the last layer reaches into the relief of the plane and tells no row
    before = layers[:-1].any(0) | known
    own, least = _filled(cells.wall, cells.cell), MASONRY.room_height / cells.cell
    level = _View(cells.whole, cells.wall, own, before, walls, room, least)
    near = int((MASONRY.facade_reach - _FARTHEST_M) / _BIN_M)
    walls = np.concatenate([np.zeros_like(walls[:near]), walls[near:]]).transpose(0, 2, 1)
    before, least = layers[near:-1].any(0) | known, MASONRY.room_width / cells.cell
    return level, _View(cells.whole.T, cells.wall.T, own.T, before.T, walls, room.T, least)


def _seam(facade: FacadeCandidate, others: Sequence[FacadeCandidate], least: float) -> _Seam | None:
    """Returns the part that shows most wall more than the facade, `least` m2 at least; None without any.

    Its rows or columns are those that show more before the plane than on it, from one end of the front on.
    Its wall is the layer that shows most of it, or that of other facades if these show more.
    """
    cells, (level, upright) = facade.cells, _views(facade, others)
    best, seam = least / cells.cell**2, None
    for view in (level, upright):
        ends = view.ends()
        for rows in ends:
            layer, gain = view.gain(rows)
            if gain < best or not view.is_part(layer, rows, ~np.any(ends, axis=0)):
                continue
            part = rows[:, None] if view is level else rows[None]
            bounded = view is level or _is_bounded(cells, rows)
            if bounded and is_large(_cut(cells, ~part), least):
                y = None if layer == len(view.walls) - 1 else _depth(layer)
                best, seam = gain, _Seam(y, part)
    return seam


def _is_bounded(cells: CellMap, columns: Bool) -> bool:
    """Returns whether there is wall all along an upright seam at the end of `columns` (w,).

    A window of the facade beside the seam would lose the pier that bounds it.
    """
    pier = ndimage.binary_dilation(columns, iterations=round(MASONRY.pier / cells.cell)) & ~columns
    wall, whole = (shown[:, pier].any(1) for shown in (cells.wall, cells.whole))
    return int((wall & whole).sum()) >= _BOUNDED * int(whole.sum())


def _depth(layer: int) -> float:
    """Returns the depth y m of the middle of a layer."""
    return (layer + _LAYER / 2.0) * _BIN_M - MASONRY.facade_reach


def _shown_before(facade: FacadeCandidate, others: Sequence[FacadeCandidate]) -> tuple[Bool, Bool]:
    """Returns the cells (layers, h, w) that show something in each layer well before the plane.

    The first layer begins as far before the plane as anything of a facade stands. What lies on the walls of
    other facades is in none of them; its cells (h, w) come last. All rows and columns of the facade count,
    because its outline may enter a storey through the windows of that storey only.
    """
    cells, q = facade.cells, facade.slab.q
    number = round((MASONRY.facade_reach - MASONRY.relief + _LAYER // 2 * _BIN_M) / _BIN_M) + 1
    level = np.floor((q[:, 1] + MASONRY.facade_reach) / _BIN_M).astype(np.int64)
    near = np.flatnonzero((level >= 0) & (level < number))
    level = np.where(on_walls(facade.wall.point + q[near] @ facade.wall.axes.T, others), number, level[near])
    held = np.zeros((number + 1, cells.whole.size), np.bool_)
    held.ravel()[distinct(level * cells.whole.size + cells.flat(q[near, 0], q[near, 2]))] = True
    held = held.reshape(number + 1, *cells.whole.shape) & _extent(cells)
    return np.stack([held[k : k + _LAYER].any(0) for k in range(number - _LAYER + 1)]), held[-1]


def _extent(cells: CellMap) -> Bool:
    """Returns the cells (h, w) in the rows and columns of an outline."""
    return np.logical_and.outer(cells.whole.any(1), cells.whole.any(0))


def _filled(shown: Array, cell: float) -> Bool:
    """Returns the cells (h, w) that show a surface which fills most of their surroundings."""
    size = round(_AROUND_M / cell) | 1
    share = ndimage.uniform_filter(shown.astype(np.float64), size, mode="nearest")
    return np.asarray(shown & (share > _FILLED), np.bool_)


def _part(
    facade: FacadeCandidate, seam: _Seam, y: float, scene: FacadeScene, rng: np.random.Generator
) -> FacadeCandidate | None:
    """Returns the part at a depth y m as a wall of its own; None where it is not large enough for one."""
    wall, cells, q = facade.wall, facade.cells, facade.slab.q
    on = np.abs(q[:, 1] - y) < _LAYER * _BIN_M / 2.0
    on &= (_extent(cells) & seam.part).ravel()[cells.flat(q[:, 0], q[:, 2])]
    moved = replace(facade, wall=replace(wall, point=wall.point + y * wall.normal))
    found = refine_candidate(moved, wall.point + q[on] @ wall.axes.T, scene, rng)
    if found is None or found.wall.normal @ wall.normal < TOLERANCES.parallel_cos:
        return None
    part = replace(found, cells=_cut(found.cells, _at(found, facade, seam.part)))
    return part if is_large(part.cells, least_area([facade], scene.options)) else None


def _at(own: FacadeCandidate, other: FacadeCandidate, part: Bool) -> Bool:
    """Returns which rows (k, 1) or columns (1, k) of cells of a wall lie in those of another one, `part`."""
    axis = 0 if part.shape[1] == 1 else 1
    cells, across = own.cells, other.wall.axes[:, 2 - 2 * axis]
    place = cells.corner[1 - axis] + cells.cell * (np.arange(cells.whole.shape[axis]) + 0.5)
    place += float((own.wall.point - other.wall.point) @ across)
    at: Int = np.floor((place - other.cells.corner[1 - axis]) / other.cells.cell).astype(np.int64)
    inside = part.ravel()[np.clip(at, 0, part.size - 1)]
    return np.asarray(np.expand_dims(inside, 1 - axis), np.bool_)


def _cut(cells: CellMap, kept: Bool) -> CellMap:
    """Returns the map with the `kept` cells: rows (h, 1) or columns (1, w)."""
    return cells.with_outline(cells.whole & kept)
