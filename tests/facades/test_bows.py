"""Bowed fronts: each strip of the bow is a facade, and the flat wall beside it ends where the bow begins."""

import numpy as np
import pytest

from frontage.facades import find_facades
from frontage.model import Building, Facade, Scan, WorldRef

WORLD = WorldRef(np.array([0, 0, 0]))
HIGH, STRIP, FLAT = 10.0, 1.2, 3.0


def strip(start, towards, length, windows, rng, spacing=0.03):
    """Points of an upright strip of wall from `start` (2,) m in a direction (2,), with windows 0.9 m wide."""
    u, z = np.meshgrid(np.arange(0.0, length, spacing), np.arange(0.0, HIGH, spacing))
    u, z = (v.ravel() + rng.uniform(-spacing / 3, spacing / 3, v.size) for v in (u, z))
    pane = (np.abs(u - length / 2) < 0.45) & (z % 3.3 > 1.1) & (z % 3.3 < 2.8) & windows
    off = np.where(pane, 0.12, 0.0) + rng.normal(0.0, 0.004, u.size)
    inwards = np.array([-towards[1], towards[0]])
    plan = np.asarray(start) + np.outer(u, towards) + np.outer(off, inwards)
    return np.column_stack([plan, z])


def front(turn, strips, rng):
    """Points of a flat wall, a bow of five strips, and so forth; ends (k, 2, 2) of all of them."""
    place, angle, parts, ends = np.zeros(2), 0.0, [], []
    for number in range(strips):
        angle += {0: -2.0 * turn if number else 0.0, 1: -2.0 * turn}.get(number % 6, turn)
        towards = np.array([np.cos(angle), np.sin(angle)])
        length = STRIP if number % 6 else FLAT
        parts.append(strip(place, towards, length, number % 6 in (0, 1, 3, 5), rng))
        ends.append([place, place + length * towards])
        place = place + length * towards
    return np.vstack(parts), np.array(ends)


def faces_of(xyz, rays):
    rng = np.random.default_rng(0)
    low, high = xyz.min(0), xyz.max(0)
    street = rng.uniform([low[0] - 3.0, low[1] - 6.0, 0.0], [high[0] + 3.0, low[1] - 0.2, 0.02], (30_000, 3))
    everything = np.vstack([xyz, street])
    eye = np.array([[5.0, -14.0, 1.7]])
    origins = (eye, np.zeros(len(everything), np.int32)) if rays else ()
    scan = Scan("bow", everything, WORLD, *origins)
    found = find_facades(scan, Building("B01", np.arange(len(xyz)), 0.0))
    assert all(isinstance(f, Facade) for f in found)
    return found


def ends_of(facade):
    """The ends (2, 2) m in plan of a facade's outline, from left to right."""
    x = facade.outline[:, 0]
    along = np.array([[x.min(), 0.0, 0.0], [x.max(), 0.0, 0.0]])
    return facade.frame.apply(along)[:, :2]


@pytest.mark.parametrize("rays", [False, True])
@pytest.mark.parametrize("turn", [11.0, 13.0])
def test_every_strip_of_a_bow_is_a_facade(turn, rays):
    xyz, ends = front(np.radians(turn), 6, np.random.default_rng(3))
    found = faces_of(xyz, rays)
    assert len(found) == len(ends)
    told = np.array([ends_of(f) for f in found])
    off = np.linalg.norm(told[:, None] - ends, axis=3).max(2)
    assert (off.min(0) < 0.25).all()  # outlines end within a cell or two of the corners


def test_a_flat_wall_goes_on_beyond_a_bow_but_not_behind_it():
    xyz, ends = front(np.radians(12.0), 7, np.random.default_rng(4))
    found = faces_of(xyz, rays=False)
    first, second = (np.array([*ends[k].mean(0), 5.0]) for k in (0, 6))
    behind = np.array([*ends[1:6].reshape(-1, 2).mean(0), 5.0])
    flats = [f for f in found if abs(f.frame.R[0, 1]) < 0.02 and np.ptp(f.outline[:, 0]) > 2.0]
    assert len(found) == 7 and len(flats) == 2

    def shows(facade, place):
        x = facade.frame.inverse.apply(place[None])[0, 0]
        return facade.outline[:, 0].min() < x < facade.outline[:, 0].max()

    assert {tuple(shows(f, p) for p in (first, second)) for f in flats} == {(True, False), (False, True)}
    assert not any(shows(f, behind) for f in flats)


def test_a_round_tower_is_no_fan_of_strips():
    rng = np.random.default_rng(5)
    turn = rng.uniform(0.25 * np.pi, 0.75 * np.pi, 60_000)
    arc = np.column_stack([6.0 * np.cos(turn), -6.0 * np.sin(turn), rng.uniform(0.0, HIGH, len(turn))])
    found = faces_of(arc + rng.normal(0.0, 0.005, arc.shape), rays=True)
    assert len(found) <= 3


def test_a_pilaster_and_a_downpipe_are_no_strips():
    rng = np.random.default_rng(6)
    wall = strip([0.0, 0.0], np.array([1.0, 0.0]), 9.0, False, rng)
    pilaster = strip([3.0, -0.25], np.array([1.0, 0.0]), 0.8, False, rng)
    angle = rng.uniform(0.0, 2.0 * np.pi, 8000)
    pipe = np.column_stack(
        [6.0 + 0.06 * np.cos(angle), -0.15 + 0.06 * np.sin(angle), rng.uniform(0, HIGH, 8000)]
    )
    assert len(faces_of(np.vstack([wall, pilaster, pipe]), rays=True)) == 1
