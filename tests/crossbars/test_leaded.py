"""Leaded lights are told by the mesh of their panes; bars and bare glass are not taken for them."""

import numpy as np
import pytest

from frontage.crossbars.leaded import leaded
from frontage.crossbars.rectify import Grid, PlaneView

GRID = Grid(0.0, 0.0, 0.004, (350, 250))  # 1.0 x 1.4 m
BOX = (0.05, 0.05, 0.95, 1.35)


def views(dark, seed=0, shift=0.01):
    """Two views of glass with dark lines where `dark(x, z)` is true, displaced against each other."""
    rng = np.random.default_rng(seed)
    found = []
    for name, off in (("a", 0.0), ("b", shift)):
        x, z = np.meshgrid(GRID.centres(0) + off, GRID.centres(1))
        grey = np.where(dark(x, z), 60.0, 120.0 + 15.0 * np.sin(2.0 * x + 3.0 * z)) + rng.normal(
            0, 4, x.shape
        )
        image = np.repeat(grey.astype(np.float32)[..., None], 3, axis=2)
        found.append(PlaneView(name, image, np.ones(x.shape, np.float32), (0.004, 0.004)))
    return found


def lines(value, pitch, width):
    """Where a value is within half a width of a multiple of the pitch."""
    return np.abs((value / pitch + 0.5) % 1.0 - 0.5) * pitch < 0.5 * width


def diamonds(x, z):
    return lines(x + z / 1.4, 0.12, 0.012) | lines(x - z / 1.4, 0.12, 0.012)


def rectangles(x, z):
    return lines(x, 0.11, 0.012) | lines(z, 0.15, 0.012)


def cross(x, z):
    return (np.abs(x - 0.5) < 0.02) | (np.abs(z - 0.9) < 0.02)


def glazing_bars(x, z):
    return lines(x - 0.05, 0.30, 0.03) | lines(z - 0.05, 0.325, 0.03)


@pytest.mark.parametrize(("mesh", "kind"), [(diamonds, "diamonds"), (rectangles, "rectangles")])
def test_a_mesh_of_small_panes_is_a_leaded_light(mesh, kind):
    assert leaded(GRID, views(mesh), BOX) == kind


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("dark", [cross, glazing_bars, lambda x, z: x < -1.0])
def test_bars_and_bare_glass_are_no_leaded_light(dark, seed):
    assert leaded(GRID, views(dark, seed), BOX) == ""
