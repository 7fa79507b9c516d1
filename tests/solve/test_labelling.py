"""Labels on a grid: energies near the least possible, no specks, borders where they cost least."""

from itertools import product

import numpy as np
import pytest

from frontage.solve import labelling
from frontage.solve.labelling import label_grid


def energy(label, cost, base, border):
    """The energy of labels (n, h, w)."""
    n = np.arange(len(cost))
    chosen = label[:, None] == n[None, :, None, None]
    total = (chosen * cost).sum((1, 2, 3))
    for axis in (2, 3):
        edge = 0.5 * (np.delete(border, 0, axis - 1) + np.delete(border, -1, axis - 1))
        sides = [np.delete(chosen, end, axis) for end in (0, -1)]
        apart = ~(sides[0] & sides[1]).any(1)
        price = base + sum((side * edge).sum(1) for side in sides)
        total = total + (apart * price).sum((1, 2))
    return total


@pytest.mark.parametrize("seed", range(6))
def test_the_energy_is_near_the_least_of_all_labellings(seed):
    rng = np.random.default_rng(seed)
    cost = rng.uniform(0, 3, (3, 3, 3)).astype(np.float32)
    border = rng.uniform(0, 1, (3, 3, 3)).astype(np.float32)
    every = np.array(list(product(range(3), repeat=9))).reshape(-1, 3, 3)
    values = energy(every, cost, 0.5, border)
    found = energy(label_grid(cost, 0.5, border)[None], cost, 0.5, border)[0]
    assert values.min() - 1e-4 <= found <= 1.1 * values.min()


def test_a_speck_is_not_worth_its_border():
    cost = np.zeros((2, 40, 40), np.float32)
    cost[1] = 0.2
    cost[0, 20, 20], cost[1, 20, 20] = 2.0, 0.0
    nothing = np.zeros_like(cost)
    assert (label_grid(cost, 1.0, nothing) == 0).all()
    assert label_grid(cost, 0.1, nothing)[20, 20] == 1


def test_a_border_runs_where_it_costs_least():
    h, w = 32, 64
    cost = np.zeros((2, h, w), np.float32)
    cost[0, :, 44:] = cost[1, :, :20] = 5.0
    border = np.ones_like(cost)
    border[:, :, 30:32] = 0.0
    label = label_grid(cost, 0.2, border)
    assert (label[:, :31] == 0).all()
    assert (label[:, 31:] == 1).all()


def test_windows_are_labelled_as_the_whole_would_be(monkeypatch):
    rng = np.random.default_rng(8)
    for shape in ((201, 37), (200, 64), (150, 1), (70, 131)):
        cost = rng.uniform(0, 2, (4, *shape)).astype(np.float32)
        border = rng.uniform(0, 1, (4, *shape)).astype(np.float32)
        for side in ("_ROWS", "_COLUMNS"):
            monkeypatch.setattr(labelling, side, 1 << 20)
        whole = label_grid(cost, 0.7, border)
        for side in ("_ROWS", "_COLUMNS"):
            monkeypatch.setattr(labelling, side, 32)
        assert np.array_equal(label_grid(cost, 0.7, border), whole)
