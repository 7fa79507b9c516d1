"""The sides of bays and oriels are facades of their own, and keep their windows."""

from itertools import pairwise

import numpy as np
import pytest

from frontage.facades import find_facades
from frontage.model import Building, Facade, Scan, WorldRef
from frontage.openings import FoundOpenings, find_openings

WORLD = WorldRef(np.array([0, 0, 0]))
EYES = np.array([[-4.0, -9.0, 1.7], [16.0, -9.0, 1.7]])
SPACING, HIGH = 0.03, 8.0


def wall(start, end, low, high, holes=()):
    """Points of an upright wall between two places in plan, without those in holes x0, z0, x1, z1 m."""
    length = np.hypot(*np.subtract(end, start))
    x, z = (v.ravel() for v in np.meshgrid(np.arange(0, length, SPACING), np.arange(low, high, SPACING)))
    free = np.ones(len(x), bool)
    for x0, z0, x1, z1 in holes:
        free &= ~((x > x0) & (x < x1) & (z > z0) & (z < z1))
    return np.column_stack([np.array(start) + np.outer(x / length, np.subtract(end, start)), z])[free]


def found_in(parts, eyes, mirrored=False):
    rng = np.random.default_rng(0)
    xyz = np.vstack(parts)
    xyz += rng.normal(0.0, 0.003, xyz.shape)
    eye = np.concatenate([np.resize(e, len(p)) for e, p in zip(eyes, parts, strict=True)]).astype(np.int32)
    axes = np.diag([-1.0, 1.0, 1.0]) if mirrored else np.eye(3)
    scan = Scan("front", xyz @ axes, WORLD, EYES @ axes, eye)
    facades = find_facades(scan, Building("B01", np.arange(len(xyz)), 0.0))
    assert all(isinstance(f, Facade) for f in facades)
    return scan, facades


def front(low=0.0):
    windows = [(x, z, x + 1.1, z + 1.5) for x in (1.0, 9.9) for z in (1.0, 4.5)]
    return wall((0.0, 0.0), (12.0, 0.0), low, HIGH, [*windows, (4.0, 0.0, 8.0, HIGH)])


def bay(run, mirrored=False):
    """The scan of a front with a bay that narrows by `run` m on either side, its sides, and their width m."""
    width = float(np.hypot(run, 0.9))
    windows = [(0.2, z, width - 0.2, z + 1.5) for z in (1.0, 4.5)]
    plan = [(4.0, 0.0), (4.0 + run, -0.9), (8.0 - run, -0.9), (8.0, 0.0)]
    sides = [wall(*plan[:2], 0.0, HIGH, windows), wall(*plan[2:], 0.0, HIGH, windows)]
    parts = [front(), wall(*plan[1:3], 0.0, HIGH), *sides]
    scan, facades = found_in(parts, [(0, 1), (0, 1), 0, 1], mirrored)
    return scan, [f for f in facades if abs(f.frame.R[1, 1]) < 0.9], width


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("run", [0.0, 0.3, 0.6])
def test_sides_of_a_bay_are_facades(run, mirrored):
    _, sides, width = bay(run, mirrored)
    assert len(sides) == 2
    for side in sides:
        assert np.ptp(side.outline, axis=0) == pytest.approx([width, HIGH], abs=0.25)


def test_sides_of_a_bay_keep_their_windows():
    scan, sides, width = bay(0.6)
    assert len(sides) == 2
    for side in sides:
        found = find_openings(side, scan)
        assert isinstance(found, FoundOpenings)
        assert len(found.openings) == 2
        for opening in found.openings:
            assert np.ptp(opening.ring, axis=0) == pytest.approx([width - 0.4, 1.5], abs=0.06)


def test_sides_of_balconies_are_none():
    parts = [wall((0.0, 0.0), (12.0, 0.0), 0.0, HIGH)]
    for z in (2.6, 5.4):
        ends = [(4.0, 0.0), (4.0, -1.2), (8.0, -1.2), (8.0, 0.0)]
        parts += [wall(a, b, z, z + 1.1) for a, b in pairwise(ends)]
    _, facades = found_in(parts, [(0, 1), *[(0,), (0, 1), (1,)] * 2])
    assert len(facades) == 1


def test_walls_of_a_room_behind_a_bay_are_no_sides():
    windows = [(0.3, z, 3.7, z + 2.2) for z in (0.8, 4.6)]
    face = wall((4.0, -0.9), (8.0, -0.9), 0.0, HIGH, windows)
    sides = [wall(a, b, 0.0, HIGH) for a, b in (((4.0, 0.0), (4.0, -0.9)), ((8.0, -0.9), (8.0, 0.0)))]
    room = [wall((4.4, -0.7), (6.0, 0.2), z, z + 2.2) for z in (0.8, 4.6)]
    _, facades = found_in([front(), face, *sides, *room], [(0, 1), (0, 1), 0, 1, 1, 1])
    assert len([f for f in facades if abs(f.frame.R[1, 1]) < 0.9]) == 2


def test_columns_have_no_sides():
    angle = np.linspace(np.pi, 2.0 * np.pi, 42)
    ring = 0.4 * np.column_stack([np.cos(angle), np.sin(angle)])
    z = np.arange(0.0, HIGH, SPACING)
    plan = np.vstack([ring + np.array([x, -0.6]) for x in (3.0, 6.0, 9.0)])
    columns = np.column_stack([np.repeat(plan, len(z), axis=0), np.tile(z, len(plan))])
    _, facades = found_in([front(), columns], [(0, 1), (0, 1)])
    assert all(abs(f.frame.R[1, 1]) > 0.9 for f in facades)
