"""Filters of maps."""

import numpy as np
import pytest
from scipy import ndimage

from frontage.openings.wall.raster import WallRaster, averaged, closed, opened, summed


@pytest.mark.parametrize("size", [(3, 3), (1, 4), (5, 2), (6, 7)])
def test_cells_are_opened_and_closed_with_nothing_beyond_the_border(size: tuple[int, int]) -> None:
    cells = np.random.default_rng(4).random((23, 31)) < 0.7
    assert np.array_equal(opened(cells, size), ndimage.binary_opening(cells, np.ones(size)))
    assert np.array_equal(closed(~cells, size), ndimage.binary_closing(~cells, np.ones(size)))


@pytest.mark.parametrize("shape", [(9, 12), (9, 12, 5)])
def test_sums_lie_below_and_left_of_the_corners_of_cells(shape: tuple[int, ...]) -> None:
    values = np.random.default_rng(5).random(shape)
    sums = summed(values)
    assert not sums[0].any()
    assert not sums[:, 0].any()
    assert sums[1:, 1:] == pytest.approx(values.cumsum(0).cumsum(1))


def test_outermost_cells_count_twice_in_means() -> None:
    values = np.random.default_rng(6).random((7, 5))
    assert averaged(values) == pytest.approx(ndimage.uniform_filter(values, 3))


@pytest.mark.parametrize("step", range(-19, 12))
def test_a_box_has_the_same_cells_in_a_mirrored_raster(step: int) -> None:
    raster = WallRaster((-1.0, 0.0), 0.1, (8, 20))
    left, right = 0.05 * step, 0.05 * step + 0.35
    _, columns = raster.cells((left, 0.2, right, 0.6))
    _, mirrored = raster.cells((-right, 0.2, -left, 0.6))
    assert (columns.start, columns.stop) == (20 - mirrored.stop, 20 - mirrored.start)
