"""Lines through the wall columns of a block."""

from types import SimpleNamespace

import numpy as np

from frontage.buildings.fronts.lines import draw_fronts
from frontage.buildings.fronts.wall_map import WallMap

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
        np.ones(7, np.bool_), COLUMNS[:, :2], COLUMNS[:, 4], COLUMNS[:, 2:4], np.zeros(7, np.int64)
    )
    cloud = SimpleNamespace(tree=SimpleNamespace(level=SimpleNamespace(size=0.1)))
    assert draw_fronts(cloud, walls) == []
