"""Walls that remain when the first ones are refined: beyond a gap, and on a bend."""

import numpy as np
import pytest
from shapely.geometry import Polygon, box
from shapely.ops import unary_union

from frontage.facades import find_facades
from frontage.model import Building, Facade, Scan, WorldRef

WORLD = WorldRef(np.array([0, 0, 0]))
HIGH = 9.0


def wall(x0, x1, spacing, rng):
    """Points of a wall y = 0 with a window every 3 m on three storeys."""
    x, z = np.meshgrid(np.arange(x0, x1, spacing), np.arange(0.0, HIGH, spacing))
    x, z = (v.ravel() + rng.uniform(-spacing / 3, spacing / 3, v.size) for v in (x, z))
    hole = (np.abs(x % 3 - 1.5) < 0.6) & (z % 3 > 0.9) & (z % 3 < 2.4)
    return np.column_stack([x, rng.normal(0, 0.004, x.size), z])[~hole]


def found_in(xyz):
    scan = Scan("front", xyz, WORLD, np.array([[5.0, -12.0, 1.7]]), np.zeros(len(xyz), np.int32))
    facades = find_facades(scan, Building("B01", np.arange(len(xyz)), 0.0))
    assert all(isinstance(f, Facade) for f in facades)
    return facades


@pytest.mark.parametrize("gap", [2.0, 2.1, 2.2, 2.3])
def test_both_parts_of_a_front_with_a_gap_are_found(gap):
    rng = np.random.default_rng(0)
    # so many points that the search looks at thinned ones, on cells twice as wide
    parts = [wall(0.0, 9.0, 0.025, rng), wall(9.0 + gap, 18.0 + gap, 0.025, rng)]
    outlines = []
    for f in found_in(np.vstack(parts)):
        q = f.frame.t + np.insert(f.outline, 1, 0.0, axis=1) @ f.frame.R.T
        outlines.append(Polygon(q[:, [0, 2]]))
    both = unary_union([box(0.0, 0.0, 9.0, HIGH), box(9.0 + gap, 0.0, 18.0 + gap, HIGH)])
    assert unary_union(outlines).intersection(both).area > 0.97 * both.area
    assert sum(o.area for o in outlines) < 1.03 * unary_union(outlines).area


@pytest.mark.parametrize("mirrored", [False, True])
def test_the_middle_of_a_front_that_bends_on_both_sides_is_a_facade(mirrored):
    rng = np.random.default_rng(1)
    xyz = wall(-17.0, 22.0, 0.05, rng)
    left, right = np.minimum(xyz[:, 0], 0.0), np.maximum(xyz[:, 0] - 9.0, 0.0)
    xyz[:, 1] += np.where(left < 0.0, 0.13 + 0.032 * left, 0.064 * right)
    if mirrored:
        xyz[:, 0] *= -1.0
    facades = found_in(xyz)
    assert len(facades) == 3
    held = np.zeros(len(xyz), int)
    for f in facades:
        assert f.roughness < 0.01
        y = ((xyz[f.support] - f.frame.t) @ f.frame.R)[:, 1]
        held[f.support[np.abs(y) < 0.03]] += 1
    assert np.mean(held == 0) < 0.02
