"""Gives a storey that stands out from the wall above or below it a plane of its own.

The search claims everything near a plane for it. Where the largest plane is a recessed wall above a
rusticated basement, the bars of the windows below may happen to lie in it, while the wall around these
windows stands well before it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.facades.candidate import FacadeCandidate, refine_candidate
from frontage.facades.cells import CellMap
from frontage.facades.scene import FacadeScene
from frontage.facades.sequential import is_large, least_area
from frontage.geometry.arrays import Bool, Float, distinct
from frontage.model.masonry import MASONRY, TOLERANCES

_BIN_M = MASONRY.step_out / 2.0  # m of depth; a wall with joints and courses fills two of them
_FEW = 0.2  # share of the wall of a storey that may lie beyond it: the pedestals of columns
_MOST = 0.5  # share of the columns of a front that its storeys fill


def with_storeys(
    facades: Sequence[FacadeCandidate], scene: FacadeScene, rng: np.random.Generator
) -> list[FacadeCandidate]:
    """Returns the facades, each followed by a storey of its own if one stands out from it.

    A level seam gives every row of cells to the plane that shows more wall there. The wall of the storey
    stands out by more than relief, shows as much more than the other plane as a facade needs, and hardly any
    of it lies beyond the seam.
    """
    found: list[FacadeCandidate] = []
    for facade in facades:
        seam = _seam(facade, scene.options.min_area)
        storey = None if seam is None else _storey(facade, seam, scene, rng)
        if seam is None or storey is None:
            found.append(facade)
        else:
            found += [replace(facade, cells=_cut(facade.cells, ~seam.rows)), storey]
    return found


@dataclass(frozen=True, eq=False)
class _Seam:
    """A storey that stands out.

    y     m, depth of its wall, negative
    rows  (h, 1) whether the rows of cells belong to it
    """

    y: float
    rows: Bool


def _seam(facade: FacadeCandidate, least: float) -> _Seam | None:
    """Returns the storey that stands out and shows at least `least` m2 more than the facade; or None."""
    cells, shown = facade.cells, _shown_before(facade)
    front, own = shown.sum(2), (cells.wall & cells.whole).sum(1)
    from_foot = np.cumsum(front - own, axis=1)
    from_head = from_foot[:, -1:] - from_foot
    gain = np.stack([from_foot, from_head])
    side, layer, row = (int(k) for k in np.unravel_index(gain.argmax(), gain.shape))
    rows = (np.arange(len(own)) <= row) == (side == 0)
    storey, rest = (_cut(cells, kept[:, None]).size[1] for kept in (rows, ~rows))
    inside = front[layer, rows].sum()
    is_storey = (
        gain.max() * cells.cell**2 >= least
        and front[layer, ~rows].sum() <= _FEW * inside
        and shown[layer, rows].any(0).sum() > _MOST * cells.whole.any(0).sum()
        and min(storey, rest) >= MASONRY.room_height
    )
    return _Seam((layer + 1) * _BIN_M - MASONRY.facade_reach, rows[:, None]) if is_storey else None


def _shown_before(facade: FacadeCandidate) -> Bool:
    """Returns the cells (layers, h, w) that show something in each layer well before the plane.

    Layer k reaches one bin to either side of the depth of k + 1 bins, counted from the farthest before the
    plane that anything of a facade stands.
    """
    cells, q = facade.cells, facade.slab.q
    number = round((MASONRY.facade_reach - MASONRY.relief) / _BIN_M) + 1
    level = np.floor((q[:, 1] + MASONRY.facade_reach) / _BIN_M).astype(np.int64)
    near = np.flatnonzero((level >= 0) & (level < number))
    held = np.zeros((number, cells.whole.size), np.bool_)
    held.ravel()[distinct(level[near] * cells.whole.size + cells.flat(q[near, 0], q[near, 2]))] = True
    held = held.reshape(number, *cells.whole.shape) & cells.whole
    return np.asarray(held[:-1] | held[1:], np.bool_)


def _storey(
    facade: FacadeCandidate, seam: _Seam, scene: FacadeScene, rng: np.random.Generator
) -> FacadeCandidate | None:
    """Returns the storey that stands out as a wall of its own; None where it is not large enough for one."""
    wall, cells, q = facade.wall, facade.cells, facade.slab.q
    on = (np.abs(q[:, 1] - seam.y) < _BIN_M) & cells.within(q[:, 0], q[:, 2], seam.rows)
    before = replace(facade, wall=replace(wall, point=wall.point + seam.y * wall.normal))
    found = refine_candidate(before, wall.point + q[on] @ wall.axes.T, scene, rng)
    if found is None or found.wall.normal @ wall.normal < TOLERANCES.parallel_cos:
        return None
    z = _middles(found) + float(found.wall.point[2])
    row = np.floor((z - float(wall.point[2]) - cells.corner[1]) / cells.cell).astype(np.int64)
    rows = seam.rows[np.clip(row, 0, len(seam.rows) - 1)]
    storey = replace(found, cells=_cut(found.cells, rows))
    return storey if is_large(storey.cells, least_area([facade], scene.options)) else None


def _middles(facade: FacadeCandidate) -> Float:
    """Returns the heights (h,) z m of the middles of the rows of cells of a facade, in its own frame."""
    cells = facade.cells
    return np.asarray(cells.corner[1] + cells.cell * (np.arange(len(cells.whole)) + 0.5))


def _cut(cells: CellMap, kept: Bool) -> CellMap:
    """Returns the map with the `kept` cells (h, w), or rows (h, 1), only."""
    return replace(cells, whole=cells.whole & kept, wall=cells.wall & kept, shut=cells.shut & kept)
