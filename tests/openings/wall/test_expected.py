"""How many beams a piece of wall would return, in dense and in sparse scans."""

import numpy as np
import pytest
import shapely

from frontage.openings import FoundOpenings, find_openings
from frontage.openings.wall.density import triangulated_density
from frontage.openings.wall.expected import expected_beams
from frontage.openings.wall.raster import WallRaster
from fronts import box_of, scan_wall

HOLES = [(x, z, x + 1.0, z + 1.4) for x in (1.0, 3.0, 5.0, 7.0) for z in (1.0, 4.0)]


def wall(dx, dz, scatter=0.0):
    """Points of a raster of dx by dz m on a wall of 9 x 6.4 m with windows."""
    x, z = (v.ravel() for v in np.meshgrid(np.arange(0, 9, dx), np.arange(0, 6.4, dz)))
    places = np.column_stack([x, z]) + np.random.default_rng(0).normal(0, scatter, (len(x), 2))
    free = [(places < (a, b)).any(1) | (places > (c, d)).any(1) for a, b, c, d in HOLES]
    return places[np.all(free, axis=0)]


@pytest.mark.parametrize(("dx", "dz"), [(0.02, 0.02), (0.08, 0.08), (0.17, 0.17), (0.3, 0.1), (0.1, 0.35)])
def test_beams_due_are_those_of_the_wall_around_also_within_openings(dx, dz):
    cell = 0.05
    due = expected_beams(wall(dx, dz, 0.002), WallRaster((0.0, 0.0), cell, (128, 180)))
    inner = due[10:-10, 10:-10] * dx * dz / cell**2
    assert np.quantile(inner, 0.05) > 0.6 and np.quantile(inner, 0.95) < 1.4
    assert abs(np.median(inner) - 1.0) < 0.1


@pytest.mark.parametrize("density", [10.0, 25.0, 50.0])
def test_points_at_random_are_as_dense_as_they_are(density):
    places = np.random.default_rng(1).uniform((0, 0), (9, 6.4), (round(density * 9 * 6.4), 2))
    held = [(places > (a, b)).all(1) & (places < (c, d)).all(1) for a, b, c, d in HOLES]
    due = expected_beams(places[~np.any(held, axis=0)], WallRaster((0.0, 0.0), 0.05, (128, 180)))
    inner = due[10:-10, 10:-10] / 0.05**2 / density
    assert 0.85 < np.median(inner) < 1.2


def test_nothing_is_due_away_from_the_wall():
    due = expected_beams(wall(0.17, 0.17), WallRaster((0.0, 0.0), 0.1, (64, 160)))
    assert due[:, 140:].max() == 0.0 and due[:, :80].min() > 0.0


def test_points_on_one_line_or_too_few_have_no_density():
    line = np.column_stack([np.arange(9.0), np.zeros(9)])
    for points in (line, line[:2], np.empty((0, 2))):
        assert triangulated_density(points, np.array([[1.0, 0.0]]), 1.0).tolist() == [0.0]


def test_coincident_points_do_no_harm():
    points = wall(0.1, 0.1)
    twice = triangulated_density(np.vstack([points, points[::3]]), np.array([[4.5, 3.0]]), 1.0)
    assert abs(twice[0] - 100.0) < 5.0


def test_windows_of_seven_beams_by_ten_are_found():
    facade, scan = scan_wall(HOLES, spacing=0.14, returned=0.1, size=(9.0, 6.4))
    found = find_openings(facade, scan)
    assert isinstance(found, FoundOpenings)
    rings = sorted(
        (shapely.box(*box_of(o)) for o in found.openings), key=lambda b: [round(v) for v in b.bounds]
    )
    assert len(rings) == len(HOLES)
    for ring, hole in zip(rings, map(shapely.box, *zip(*HOLES, strict=True)), strict=True):
        assert ring.intersection(hole).area > 0.5 * ring.union(hole).area
