"""Fronts with more glass than wall: the wall must be found, and not its bars and panes."""

import numpy as np
import pytest

from frontage.facades import find_facades
from frontage.model import Building, Facade, Scan, WorldRef

SPACING = 0.02


def many_paned(noise=0.005, returned=0.3):
    """Returns a wall y = 0 of 14 x 8.5 m with pilasters, a gate and seven windows of many panes.

    Bars lie 20 cm and panes 22 cm behind the wall.
    """
    rng = np.random.default_rng(0)
    x, z = (v.ravel() for v in np.meshgrid(np.arange(0, 14, SPACING), np.arange(0, 8.5, SPACING)))
    y, kept = np.zeros(len(x)), np.ones(len(x), np.bool_)
    y[x % 3.5 < 0.35], y[z > 8.1] = -0.12, -0.15
    for left in (0.725, 4.225, 7.725, 11.225):
        for sill in (0.6, 4.7):
            inside = (x > left) & (x < left + 2.4) & (z > sill) & (z < sill + 2.6)
            bar = inside & (((x - left) % 0.4 < 0.03) | ((z - sill) % 0.37 < 0.03))
            pane = inside & ~bar
            y[bar], y[pane], kept[pane] = 0.2, 0.22, rng.random(pane.sum()) < returned
            if (left, sill) == (7.725, 0.6):
                y[inside], kept[inside] = 0.25, True
    xyz = np.column_stack([x, y + rng.normal(0, noise, len(x)), z])[kept]
    known = {"origins": np.array([[7.0, -10.0, 1.6]]), "origin_index": np.zeros(len(xyz), np.int32)}
    return Scan("panes", xyz, WorldRef(np.zeros(3, np.int64)), **known)


def test_the_wall_is_found_and_not_the_panes_in_it():
    scan = many_paned()
    (facade,) = find_facades(scan, Building("B01", np.arange(len(scan)), 0.0))
    assert isinstance(facade, Facade)
    assert facade.frame.t[1] == pytest.approx(0.0, abs=0.003)
    assert facade.roughness == pytest.approx(0.005, abs=0.001)
