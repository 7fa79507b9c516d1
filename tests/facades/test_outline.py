"""The outline of a wall whose points lie farther and farther apart towards its end."""

import numpy as np

from frontage.facades.outline import largest_part, occupied

CELL = 0.1
WIDTH, HEIGHT = 30.0, 9.0


def _row(rng: np.random.Generator, denser: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Returns x, z (n,) m of random points: 400 per m2 at one end of a row, 9 at the other."""
    x, z = rng.uniform(0.0, 1.0, (2, int(400 * WIDTH * HEIGHT))) * np.array([[WIDTH], [HEIGHT]])
    kept = rng.uniform(size=len(x)) < denser * np.exp(-x / WIDTH * np.log(400 / 9))
    return x[kept], z[kept]


def _outline(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, tuple[float, float]]:
    count, corner, _ = occupied(x, z, CELL)
    cells = largest_part(count, corner, CELL, np.column_stack([x, np.zeros(len(x)), z]))
    assert cells is not None
    return cells.whole, corner


def test_the_sparse_end_of_a_row_belongs_to_its_outline() -> None:
    for seed in range(3):
        whole, (x0, z0) = _outline(*_row(np.random.default_rng(seed)))
        low, high = int(-z0 / CELL), int((HEIGHT - z0) / CELL)
        end = int((WIDTH - x0) / CELL)
        assert whole[low + 3 : high - 3, end - 80 : end - 3].mean() > 0.97


def test_points_beside_a_dense_wall_do_not_widen_it() -> None:
    rng = np.random.default_rng(0)
    x, z = rng.uniform(0.0, 8.0, (2, 25_600))
    stray = rng.uniform((8.4, 0.0), (8.9, 8.0), (12, 2))  # three per m2, nearer than a gap that is bridged
    whole, (x0, _) = _outline(np.append(x, stray[:, 0]), np.append(z, stray[:, 1]))
    assert np.flatnonzero(whole.any(0)).max() * CELL + x0 < 8.2


def test_cells_of_any_size_are_closed() -> None:
    x, z = np.meshgrid(np.arange(0.0, 4.0, 0.02), np.arange(0.0, 4.0, 0.02))
    for cell in (
        0.05,
        0.1,
        0.285,
        0.523,
        0.57,
        0.6,
    ):  # of some, the widest disk is no whole multiple in floats
        count, corner, _ = occupied(x.ravel(), z.ravel(), float(cell))
        cells = largest_part(count, corner, float(cell), np.zeros((1, 3)))
        assert cells is not None and abs(cells.area - 16.0) < 4.0


def _front(width: float, end: float = 12.0) -> tuple[np.ndarray, np.ndarray]:
    """Returns x, z (n,) m of a wall 12 m long and 8 m high with a shop window, 3 m high, from 4 m on."""
    x, z = (v.ravel() for v in np.meshgrid(np.arange(0.0, end, 0.02), np.arange(0.0, 8.0, 0.02)))
    shop = (z < 3.0) & (x > 4.0) & (x < 4.0 + width)
    return x[~shop], z[~shop]


def test_a_shop_window_of_any_width_belongs_to_its_wall() -> None:
    for width in (3.0, 3.9, 4.1, 6.0):
        whole, (x0, z0) = _outline(*_front(width))
        column, row = int((4.0 + width / 2.0 - x0) / CELL), int((1.5 - z0) / CELL)
        assert whole[row, column], width


def test_what_lies_below_the_end_of_an_overhanging_storey_does_not() -> None:
    whole, (x0, z0) = _outline(*_front(6.0, end=10.0))
    assert not whole[int((0.5 - z0) / CELL), int((7.0 - x0) / CELL)]
