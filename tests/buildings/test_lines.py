"""Lines through the wall columns of a block."""

from types import SimpleNamespace

import numpy as np

from frontage.buildings import BuildingOptions
from frontage.buildings.fronts.lines import draw_fronts
from frontage.buildings.fronts.wall_map import WallMap
from frontage.buildings.terrain import Ground

COLUMNS = np.array(
    [
        [0.0, 0.03177, 0.87089, 0.49148, 15.0],
        [0.00062, 0.16069, 0.92791, 0.3728, 15.0],
        [0.19324, 0.01666, 0.38107, 0.92455, 17.0],
        [0.16107, 0.16942, 0.60498, 0.79624, 17.0],
        [0.13956, 0.31144, 0.543, 0.83973, 12.0],
        [0.40077, 0.0, 0.27204, 0.96229, 12.0],
        [0.41028, 0.09502, 0.49088, 0.87123, 12.0],
    ]
)
"""Columns beside a cut of a real scan: x, y m, normal, occupied bins. The last line leaves them all."""


def test_a_few_columns_that_do_not_face_across_their_line_are_no_front():
    walls = WallMap(
        np.ones(7, np.bool_),
        COLUMNS[:, :2],
        COLUMNS[:, 4],
        COLUMNS[:, 2:4],
        np.zeros(7, np.int64),
        np.empty((0, 2)),
    )
    cloud = SimpleNamespace(tree=SimpleNamespace(level=SimpleNamespace(size=0.1)))
    assert draw_fronts(cloud, walls) == []


def row_of_columns(x0: float, x1: float, y: float) -> np.ndarray:
    """Wall columns (k, 2) m every quarter of a metre along x."""
    x = np.arange(x0, x1, 0.25)
    return np.column_stack([x, np.full(len(x), y)])


def test_a_front_takes_no_wall_of_a_house_across_the_street() -> None:
    front, across = row_of_columns(0.0, 16.0, 0.0), row_of_columns(-9.0, 3.0, -9.0)
    behind = np.array([[8.0, 5.0], [8.0, 5.25], [8.0, 5.5]])
    xy = np.vstack([front, across, behind])
    normal = np.tile([0.0, 1.0], (len(xy), 1))
    walls = WallMap(
        np.ones(1, np.bool_),
        xy,
        np.full(len(xy), 20.0),
        normal,
        np.zeros(len(xy), np.int64),
        np.empty((0, 2)),
    )
    measured = np.zeros((80, 80), np.bool_)  # a car hides the ground between the two houses
    measured[20:40, 44:80] = True
    ground = Ground(np.zeros((80, 80)), measured, np.array([-20.0, -20.0]), 0.5)
    cloud = SimpleNamespace(
        tree=SimpleNamespace(level=SimpleNamespace(size=0.25)),
        scan=SimpleNamespace(has_origins=False),
        ground=ground,
        options=BuildingOptions(),
    )
    fronts = draw_fronts(cloud, walls)
    assert len(fronts) == 2
    held = sorted(sorted(front.members.tolist()) for front in fronts)
    own, other = len(front), len(front) + len(across)
    assert held == [[*range(own), *range(other, len(xy))], list(range(own, other))]
