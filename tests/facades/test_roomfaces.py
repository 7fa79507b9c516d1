"""Walls of rooms that were scanned from within are no facades where the front of the house was seen."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from frontage.facades import find_facades
from frontage.model import Building, Facade, Scan, WorldRef

DEEP, WIDE, HIGH = 5.0, 3.6, 8.4


def _wall(start: tuple[float, float], end: tuple[float, float], holes: bool = False) -> np.ndarray:
    """Returns the points of a wall between two places in plan, with or without two windows per storey."""
    length = np.hypot(*np.subtract(end, start))
    x, z = (v.ravel() for v in np.meshgrid(np.arange(0, length, 0.03), np.arange(0, HIGH, 0.03)))
    is_open = (np.abs(x % 1.6 - 1.0) < 0.5) & (np.abs(z % 2.8 - 1.75) < 0.85) & holes
    x, z = x[~is_open], z[~is_open]
    return np.column_stack([np.array(start) + np.outer(x / length, np.subtract(end, start)), z])


def _floor(z: float, step: float = 0.05) -> np.ndarray:
    """Returns the points of a floor or a ceiling of a room."""
    x, y = np.meshgrid(np.arange(0.0, WIDE, step), np.arange(0.3, DEEP, step))
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)])


def _house(rooms: bool) -> tuple[Scan, Building]:
    """Returns a narrow house with rooms behind its front in y = 0, and the ground before it.

    The rooms were scanned from within, so that their walls are as large as the front and denser.
    """
    rng = np.random.default_rng(0)
    parts = [_wall((0.0, 0.0), (WIDE, 0.0), holes=True)]
    if rooms:
        corners = [(0.0, 0.3), (0.0, DEEP), (WIDE, DEEP), (WIDE, 0.3)]
        parts += [_wall(a, b) for a, b in pairwise(corners)]
        parts += [_floor(z + h) for z in (0.0, 2.8, 5.6) for h in (0.05, 2.6)]
    own = np.vstack(parts)
    ground = np.column_stack([rng.uniform(-4, 8, 9000), rng.uniform(-9, -0.1, 9000), np.zeros(9000)])
    xyz = np.vstack([own, ground])
    return Scan("house", xyz + rng.normal(0, 0.003, xyz.shape), WorldRef(np.zeros(3))), Building(
        "B01", np.arange(len(own)), 0.0
    )


def _with_sensors(scan: Scan, own: int) -> Scan:
    """Returns the scan with its sensors: one in the street, and one in the middle of every room."""
    eyes = [[WIDE / 2, -8.0, 1.7], *([WIDE / 2, DEEP / 2, z + 1.5] for z in (0.0, 2.8, 5.6))]
    x, y, z = scan.xyz.T
    room = 1 + np.clip((z / 2.8).astype(np.int32), 0, 2)
    in_street = (np.arange(len(x)) >= own) | (np.abs(y) < 0.05)
    return replace(scan, origins=np.array(eyes), origin_index=np.where(in_street, 0, room).astype(np.int32))


def _planes(rooms: bool, rays: bool = False) -> list[tuple[float, float]]:
    """Returns the directions (x, y), rounded, that the facades of the house face."""
    scan, building = _house(rooms)
    found = find_facades(_with_sensors(scan, len(building.index)) if rays else scan, building)
    return sorted((round(-float(f.frame.R[0, 1])), round(-float(f.frame.R[1, 1]))) for f in found)


@pytest.mark.parametrize("rays", [True, False])
def test_the_front_of_a_house_with_scanned_rooms_is_its_only_facade(rays: bool) -> None:
    assert _planes(True, rays) == [(0, -1)]


def test_the_front_of_an_empty_house_is_found_as_well() -> None:
    assert _planes(rooms=False) == [(0, -1)]


def _front_cut_out_of_its_street() -> tuple[Scan, Building]:
    """Returns all points within a metre of a front with string courses: its end, and the ground beside it."""
    rng, length = np.random.default_rng(1), 12.0
    x, y = (v.ravel() for v in np.meshgrid(np.arange(0.0, length, 0.03), np.arange(-0.5, 0.0, 0.03)))
    courses = [np.column_stack([x, y, np.full(x.size, z)]) for z in (0.3, 2.7, 3.0, 5.5, 5.8, 8.2)]
    front = _wall((0.0, 0.0), (length, 0.0), holes=True)
    own = np.vstack([front, *courses, _wall((length, -0.95), (length, 0.95))])
    ground = np.column_stack([rng.uniform(0, 20, 9000), rng.uniform(-1, 0.9, 9000), np.zeros(9000)])
    xyz = np.vstack([own, ground])
    return Scan("front", xyz + rng.normal(0, 0.003, xyz.shape), WorldRef(np.zeros(3))), Building(
        "B01", np.arange(len(own)), 0.0
    )


def test_a_front_that_was_cut_out_of_its_street_is_no_wall_of_a_room() -> None:
    found = find_facades(*_front_cut_out_of_its_street())
    widths = [np.ptp(f.outline[:, 0]) for f in found if isinstance(f, Facade)]
    assert max(widths) == pytest.approx(12.0, abs=0.5)
