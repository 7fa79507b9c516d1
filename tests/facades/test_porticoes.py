"""The prism of a facade reaches the wall behind a portico, and ends behind windows where it always does."""

import numpy as np

from frontage.facades.cells import CellMap
from frontage.facades.porticoes import depth_behind

CELL = 0.1
LIMITS = (1.0, 1.5)


def _front(width: int, height: int) -> tuple[CellMap, np.ndarray]:
    """Returns a front of 20 x 12 m with a hole of so many cells in its middle, and the cells of it."""
    wall = np.ones((120, 200), np.bool_)
    wall[60 - height // 2 : 60 + height // 2, 100 - width // 2 : 100 + width // 2] = False
    return CellMap((0.0, 0.0), CELL, wall, np.ones_like(wall), wall), np.flatnonzero(~wall)


def test_the_wall_behind_columns_belongs_to_the_facade_with_its_frames() -> None:
    cells, hole = _front(120, 60)
    columns = np.random.default_rng(0).permutation(hole)[: len(hole) // 2]
    y = np.concatenate([np.full(len(columns), 0.25), np.full(len(hole), 1.08)])
    depth = depth_behind(y, np.concatenate([columns, hole]), cells, LIMITS)
    assert 1.4 <= depth.ravel()[hole].min() <= LIMITS[1]
    assert (depth[cells.wall] == LIMITS[0]).all()


def test_a_portico_whose_wall_is_near_needs_no_deeper_prism() -> None:
    cells, hole = _front(120, 60)
    y = np.concatenate([np.full(len(hole), 0.5), np.full(len(hole) // 4, 1.3)])
    depth = depth_behind(y, np.concatenate([hole, hole[: len(hole) // 4]]), cells, LIMITS)
    assert (depth == LIMITS[0]).all()


def test_behind_an_opening_nothing_is_a_wall() -> None:
    cells, hole = _front(40, 50)
    assert (depth_behind(np.full(len(hole), 1.2), hole, cells, LIMITS) == LIMITS[0]).all()


def test_a_portico_in_which_nothing_was_measured_has_the_usual_depth() -> None:
    cells, hole = _front(120, 60)
    assert (depth_behind(np.zeros(len(hole)), hole, cells, LIMITS) == LIMITS[0]).all()
