"""A ground floor set back by a hand's breadth: its wall begins where its own points show it."""

import numpy as np
import pytest

from frontage.openings import FoundOpenings, find_openings
from frontage.openings.wall.raster import TILE, WallRaster
from frontage.openings.wall.surface import value_at, wall_depth
from fronts import box_of, scan_wall
from openings.boxes import box, scanned

BACK, PANE = 0.13, 0.28  # m, the wall of the ground floor and its panes behind the upper wall
STEP, HEAD, FOOT = 3.2, 3.1, 0.8
WINDOWS = ((0.3, 2.6), (2.95, 5.1), (5.45, 7.7))  # piers between them are narrower than half a window


def ground_floor():
    """A wall above STEP, and below it one further back with windows nearly as wide as their bays."""
    x = [0.0, *np.ravel(WINDOWS), 8.0]
    piers = [box(a, b, BACK, 0.5, FOOT, HEAD) for a, b in zip(x[::2], x[1::2], strict=True)]
    bands = [box(0.0, 8.0, BACK, 0.5, 0.0, FOOT), box(0.0, 8.0, BACK, 0.5, HEAD, STEP)]
    return [box(0.0, 8.0, 0.0, 0.5, STEP, 9.0), *piers, *bands, box(0.0, 8.0, PANE, 0.5, FOOT, HEAD)]


@pytest.mark.parametrize("rays", [True, False])
def test_the_wall_has_the_depth_of_its_own_tiles_on_both_sides_of_a_step(rays):
    facade, scan = scanned(wall=ground_floor(), rays=rays)
    found = find_openings(facade, scan)
    assert isinstance(found, FoundOpenings)
    x = np.array([0.15, 1.5, 4.0, 6.5, 7.85])
    beams = found.evidence.beams
    assert np.abs(beams.depth_at(x, np.full(5, STEP + 0.3))).max() < 0.02
    assert np.abs(beams.depth_at(x, np.full(5, STEP - 0.3)) - BACK).max() < 0.02


@pytest.mark.parametrize("rays", [True, False])
def test_a_pier_of_a_set_back_ground_floor_is_wall_though_a_room_is_seen_behind_it(rays):
    """Beams through the windows beside a pier end behind it, in as many depths as the room is deep."""
    rng = np.random.default_rng(0)
    upper = rng.uniform((0.0, -0.005, STEP), (8.0, 0.005, 6.0), (20_000, 3))
    room = rng.uniform((0.0, 0.3, 0.0), (8.0, 1.5, STEP), (40_000, 3))
    lower = rng.uniform((0.0, BACK - 0.005, 0.0), (8.0, BACK + 0.005, STEP), (60_000, 3))
    in_window = np.any([(lower[:, 0] > a) & (lower[:, 0] < b) for a, b in WINDOWS], axis=0)
    raster = WallRaster((0.0, 0.0), TILE, (24, 32))
    depth = wall_depth(np.vstack([upper, room, lower[~in_window]]), raster, 0.005, rays)
    x = np.array([0.15, 2.8, 5.3, 7.85])
    assert np.abs(value_at(depth, raster, x, np.full(4, 2.6)) - BACK).max() < 0.02
    assert np.abs(value_at(depth, raster, x, np.full(4, 3.6))).max() < 0.02


@pytest.mark.parametrize("mirrored", [True, False])
@pytest.mark.parametrize("beside", [0.3, 1.5])  # m, the pier between the step and the windows
def test_panes_as_deep_as_the_wall_beside_are_no_wall(beside, mirrored):
    """Two walls stand side by side; the panes of the nearer one lie in the plane of the other."""
    rng = np.random.default_rng(0)
    left = 3.8 + beside
    windows = ((left, 1.4, left + 2.1, 2.5), (left + 0.1, 4.4, left + 2.1, 5.5))
    points = rng.uniform((0.0, -0.005, 0.0), (9.0, 0.005, 7.0), (150_000, 3))
    x, _, z = points.T
    pane = np.any([(x > a) & (x < c) & (z > b) & (z < d) for a, b, c, d in windows], axis=0)
    points[(x > 3.8) & ~pane, 1] -= BACK
    points = points[~pane | (rng.random(len(points)) < 0.1)]
    if mirrored:
        points[:, 0] = 9.0 - points[:, 0]
    raster = WallRaster((0.0, 0.0), TILE, (28, 36))
    depth = wall_depth(points, raster, 0.005)
    at = np.array([1.0, left + 0.4, left + 1.0, left + 1.7, 8.5])
    for height in (1.9, 4.9):
        found = value_at(depth, raster, 9.0 - at if mirrored else at, np.full(5, height))
        assert found == pytest.approx([0.0, -BACK, -BACK, -BACK, -BACK], abs=0.02)


@pytest.mark.parametrize("bay", [(3.0, 5.0), (2.0, 16.0)])
def test_beside_a_bay_the_wall_has_its_own_depth_though_it_lies_behind_the_plane(bay):
    rng = np.random.default_rng(0)
    wall = rng.uniform((0.0, BACK - 0.005, 0.0), (18.0, BACK + 0.005, 6.0), (160_000, 3))
    front = rng.uniform((bay[0], -0.655, 0.0), (bay[1], -0.645, 6.0), (int(1500 * (bay[1] - bay[0])) * 6, 3))
    hidden = (wall[:, 0] > bay[0]) & (wall[:, 0] < bay[1])
    raster = WallRaster((0.0, 0.0), TILE, (24, 72))
    depth = wall_depth(np.vstack([wall[~hidden], front]), raster, 0.005)
    left, middle, right = value_at(
        depth, raster, np.array([bay[0] - 0.4, np.mean(bay), bay[1] + 0.4]), np.full(3, 3.0)
    )
    assert [left, right] == pytest.approx([BACK, BACK], abs=0.02)
    assert middle == pytest.approx(-0.65, abs=0.02)


@pytest.mark.parametrize("rays", [True, False])
def test_a_gate_as_high_as_half_of_a_set_back_part_is_an_opening_down_to_the_ground(rays):
    gate = (3.0, 0.0, 6.2, 4.2)
    facade, scan = scan_wall([gate], depth=0.39, spacing=0.04, rays=rays, size=(9.0, 9.0))
    (found,) = find_openings(facade, scan).openings
    assert np.abs(box_of(found) - gate).max() < 0.05
