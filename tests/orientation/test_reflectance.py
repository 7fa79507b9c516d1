"""The reflectance of a scan: corrected for range and incidence, and drawn exactly where a camera sees it."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.model import Camera
from frontage.orientation.reflectance.radiometry import corrected, fit_radiometry
from frontage.orientation.reflectance.render import render, rendering_factor, spread
from frontage.orientation.reflectance.surface import ScannedSurface, scanned_surface
from frontage.solve.surfels import Surfels
from orientation.paintedwalls import (
    LANDSCAPE,
    PORTRAIT,
    Wall,
    looking,
    paint,
    posed,
    scan_of,
)


def echoes(stations, seed=0, pieces=400, points=30, exponents=(-2.0, 0.7), offsets=(0.0, 0.4, -0.25)):
    """Log intensities of pieces of unlike albedo, each seen by every station from its own place."""
    rng = np.random.default_rng(seed)
    piece = np.repeat(np.arange(pieces), points)
    station = rng.integers(0, stations, len(piece))
    ranges = rng.uniform(4.0, 40.0, (pieces, stations))[piece, station]
    cosine = np.cos(rng.uniform(0.0, 1.3, (pieces, stations)))[piece, station]
    albedo = np.log(rng.uniform(0.05, 0.9, pieces))[piece]
    noise = rng.normal(0, 0.15, len(piece))
    noise[rng.random(len(piece)) < 0.03] += 2.0
    a, b = exponents
    tone = albedo + a * np.log(ranges) + b * np.log(cosine) + np.array(offsets)[station] + noise
    return tone, ranges, cosine, station, piece, albedo


def test_exponents_and_offsets_of_stations_are_recovered():
    tone, ranges, cosine, station, piece, albedo = echoes(3)
    model = fit_radiometry(tone, ranges, cosine, station, piece, 3)
    assert model.range_exponent == pytest.approx(-2.0, abs=0.03)
    assert model.cosine_exponent == pytest.approx(0.7, abs=0.03)
    assert model.station_offset == pytest.approx((0.0, 0.4, -0.25), abs=0.03)
    flat = corrected(tone, model, ranges, cosine, station)
    assert 0.1 < np.median(np.abs(flat - albedo)) < 0.13  # the noise stays: 0.67 of its sigma


def test_unknown_range_and_station_leave_tones_as_they_are():
    tone, ranges, cosine, station, piece, _ = echoes(2)
    model = fit_radiometry(tone, ranges, cosine, station, piece, 2)
    ranges[:5], station[:5] = np.nan, -1
    assert np.array_equal(corrected(tone, model, ranges, cosine, station)[:5], tone[:5])


def test_one_station_that_tells_nothing_leaves_the_exponents_near_zero():
    rng = np.random.default_rng(0)
    piece = np.repeat(np.arange(300), 30)
    ranges = rng.uniform(8, 20, 300)[piece] + rng.normal(0, 1e-4, len(piece))
    cosine = np.cos(rng.uniform(0, 1.2, 300))[piece]
    tone = np.log(rng.uniform(0.1, 0.9, 300))[piece] - 2 * np.log(ranges) + rng.normal(0, 0.1, len(piece))
    model = fit_radiometry(tone, ranges, cosine, np.zeros(len(piece), np.int64), piece, 1)
    assert abs(model.range_exponent) < 1.0 and abs(model.cosine_exponent) < 0.01
    assert model.station_offset == (0.0,)


def test_a_few_points_tell_nothing():
    few = np.ones(50)
    model = fit_radiometry(few, few, few, np.zeros(50, np.int64), np.zeros(50, np.int64), 2)
    assert (model.range_exponent, model.cosine_exponent, model.station_offset) == (0.0, 0.0, (0.0, 0.0))


def test_the_paint_of_a_wall_remains_when_range_and_incidence_are_taken_out():
    wall = Wall((0, 0, 0), (1, 0, 0), np.full((350, 600), 0.5, np.float32))
    near, far = (scan_of([wall], 0.05, origin=o, seed=s) for s, o in enumerate([(3, -5, 1.6), (9, -11, 1.6)]))
    xyz = np.concatenate([near.xyz, far.xyz])
    origins = np.concatenate([near.origins, far.origins])
    station = np.repeat([0, 1], [len(near.xyz), len(far.xyz)]).astype(np.int32)
    ray = xyz - origins[station]
    ranges = np.linalg.norm(ray, axis=1)
    intensity = 0.4 * (ray[:, 1] / ranges) * (5.0 / ranges) ** 2 * np.array([1.0, 1.5])[station]
    scan = replace(
        near, xyz=xyz, origins=origins, origin_index=station, intensity=intensity.astype(np.float32)
    )
    tone = scanned_surface(scan).tone
    assert np.std(np.log(intensity)) > 0.4
    assert np.std(tone) < 0.05


def cloud(xyz, tone, spacing=0.02):
    """A surface of points as given; no pieces are needed to draw it."""
    none = np.empty((0, 3))
    pieces = Surfels(none, none, np.empty(0, bool), np.empty(0), np.empty(0))
    return ScannedSurface(
        np.asarray(xyz, float),
        np.full(len(xyz), spacing),
        np.asarray(tone, np.float32),
        "intensity",
        pieces,
        0.0,
    )


def bright_spot(camera, pose, place, factor):
    """Where the rendering shows a bright spot at `place` (x, z) of a wall, px of the rendering, and where
    the camera projects it."""
    x, z = np.meshgrid(np.arange(1.0, 9.0, 0.02), np.arange(0.0, 6.0, 0.02))
    x, z = x.ravel() + 0.003, z.ravel() + 0.007
    spot = np.exp(-0.5 * ((x - place[0]) ** 2 + (z - place[1]) ** 2) / 0.05**2)
    photo = posed(pose, camera)
    drawn = render(photo, cloud(np.column_stack([x, np.zeros_like(x), z]), spot), factor)
    row, column = np.indices(drawn.tone.shape)
    weight = np.where(drawn.tone > 0.02, drawn.tone, 0.0)
    centre = np.array([(weight * (column + 0.5)).sum(), (weight * (row + 0.5)).sum()]) / weight.sum()
    true = camera.project(pose.inverse.apply(np.array([[place[0], 0.0, place[1]]])))[0]
    return centre, true / drawn.scale


@pytest.mark.parametrize("camera", [LANDSCAPE, PORTRAIT], ids=["landscape", "portrait"])
@pytest.mark.parametrize("factor", [1.5, 2.37])
def test_a_bright_spot_appears_where_the_camera_projects_it(camera, factor):
    pose = looking(5.0, -8.0)
    off = [np.subtract(*bright_spot(camera, pose, p, factor)) for p in ((4.0, 2.0), (6.0, 3.5), (5.3, 1.1))]
    assert np.abs(off).max() < 0.05
    assert np.abs(np.mean(off, axis=0)).max() < 0.03


def test_a_camera_on_its_side_sees_the_spot_as_well():
    seen, true = bright_spot(LANDSCAPE, looking(5.0, -8.0, roll=90.0), (4.6, 2.4), 1.6)
    assert np.abs(seen - true).max() < 0.05


def test_pixels_of_the_photo_count_from_the_corner():
    drawn = render(posed(looking(5.0, -8.0)), cloud([[5.0, 0.0, 2.0]], [1.0]), 2.0)
    assert drawn.known.shape == (300, 400)
    assert np.array_equal(drawn.photo_pixels(np.array([[0.0, 0.0], [400.0, 300.0]])), [[0, 0], [800, 600]])


def test_spread_keeps_the_place_of_a_point():
    found = spread(np.array([[10.3, 20.8]]), np.ones((1, 1)), (40, 40), join=1.0)
    row, column = np.nonzero(found.known)
    assert column.mean() + 0.5 == pytest.approx(10.3, abs=0.5) and row.mean() + 0.5 == pytest.approx(
        20.8, abs=0.5
    )
    assert found.mean[20, 10, 0] == pytest.approx(1.0, abs=1e-5)
    nowhere = spread(np.array([[-5.0, 3.0], [60.0, 3.0]]), np.ones((2, 1)), (40, 40))
    assert not nowhere.known.any() and not nowhere.mean.any()


@pytest.mark.parametrize("factor", [1.0, 1.25, 2.0, 3.0])
def test_what_stands_behind_is_not_drawn(factor):
    rng = np.random.default_rng(0)
    board = Wall((4.0, -1.5, 1.0), (1, 0, 0), np.full((100, 100), 1.0, np.float32)).points(0.02, rng)
    wall = Wall((0.0, 0.0, 0.0), (1, 0, 0), np.full((350, 500), 0.1, np.float32)).points(0.02, rng)
    tone = np.repeat([1.0, -1.0], [len(board[0]), len(wall[0])])
    surface = cloud(np.concatenate([board[0], wall[0]]), tone)
    photo = posed(looking(5.0, -8.0))
    drawn = render(photo, surface, factor)
    row, column = np.indices(drawn.known.shape)
    points = drawn.points(np.column_stack([column.ravel(), row.ravel()])).reshape(*drawn.known.shape, 3)
    # The board is looked at through pixels that are clearly inside it, the wall through the others.
    origin, ray = photo.ray(drawn.photo_pixels(np.column_stack([column.ravel(), row.ravel()]) + 0.5))
    at = origin + ray * ((-1.5 - photo.pose.t[1]) / ray[:, 1:2])
    off = np.abs(at[:, [0, 2]] - (5.0, 2.0)).max(1).reshape(row.shape)
    inside, beside = off < 0.85, (off > 1.15) & drawn.known
    assert drawn.known[inside].all() and inside.sum() > 2000
    assert drawn.tone[inside].min() > 0.99
    assert np.abs(points[inside][:, 1] + 1.5).max() < 0.01
    assert beside.sum() > 5000 and drawn.tone[beside].max() < -0.99


@pytest.mark.parametrize("camera", [LANDSCAPE, PORTRAIT], ids=["landscape", "portrait"])
def test_points_behind_pixels_lie_on_the_wall_and_project_back(camera):
    wall = Wall((0.0, 0.0, 0.0), (1, 0, 0), paint(10.0, 7.0))
    surface = scanned_surface(scan_of([wall], noise=0.0))
    photo = posed(looking(5.0, -8.0, heading=12.0, pitch=8.0), camera)
    factor = rendering_factor(photo, surface)
    assert 0.5 < factor / max(1.0, 0.4 * 0.03 * 600 / 8.3) < 1.6
    drawn = render(photo, surface, factor)
    rng = np.random.default_rng(0)
    row, column = np.nonzero(drawn.known)
    pick = rng.choice(len(row), 2000, replace=False)
    at = np.column_stack([column[pick], row[pick]])
    xyz = drawn.points(at)
    inner = (xyz[:, 0] > 0.2) & (xyz[:, 0] < 9.8) & (xyz[:, 2] > 0.2) & (xyz[:, 2] < 6.8)
    assert inner.sum() > 1000
    off = np.abs(xyz[inner, 1])
    assert off.max() < 0.01 and np.median(off) < 0.001
    assert camera.project(photo.pose.inverse.apply(xyz)) == pytest.approx(
        drawn.photo_pixels(at + 0.5), abs=1e-6
    )


def test_a_camera_that_sees_nothing_draws_nothing():
    wall = Wall((0.0, 0.0, 0.0), (1, 0, 0), paint(6.0, 5.0))
    surface = scanned_surface(scan_of([wall], 0.05))
    away = posed(looking(5.0, -8.0, heading=180.0))
    assert rendering_factor(away, surface) == 1.0
    assert not render(away, surface, 4.0).known.any()


def pinhole(size):
    return Camera("SIMPLE_PINHOLE", *size, np.array([600.0, size[0] / 2, size[1] / 2]))


def test_the_size_of_a_rendering_is_that_of_the_photo_over_the_factor():
    surface = cloud([[0.0, 5.0, 0.0]], [0.0])
    for size in ((801, 601), (601, 801)):
        drawn = render(posed(looking(0.0, 0.0, 0.0), pinhole(size)), surface, 3.0)
        assert drawn.known.shape[::-1] == (round(size[0] / 3), round(size[1] / 3))
        assert drawn.scale * drawn.known.shape[::-1] == pytest.approx(size)
