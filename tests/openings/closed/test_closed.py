"""Shutters level with the wall: found by how they look in rows and columns, and nothing else there."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.geometry.ring import ring_contains
from frontage.model.estimate import Provenance
from frontage.openings import find_openings
from frontage.openings.borders.shapes import ring_of
from frontage.openings.closed.channels import scan_layer, wall_points
from frontage.openings.closed.steps import OpeningForm, wall_steps
from frontage.openings.wall.beams import sort_beams
from fronts import EYE, box_of, scan_wall

SIZE = (9.0, 9.0)
GRID = [(x, z, x + 1.1, z + 1.5) for z in (0.8, 3.6, 6.4) for x in (0.9, 3.1, 5.3, 7.3)]
SHUT = 5  # of the grid
HOLES = [box for k, box in enumerate(GRID) if k != SHUT]


@pytest.fixture(scope="module")
def wall():
    """A front whose grid of windows lacks one."""
    return scan_wall(HOLES, spacing=0.03, size=SIZE, returned=0.5)


def brightness(scan, seed=0):
    """Intensity (n,) of an even wall: range, incidence, speckle."""
    way = scan.xyz - EYE
    range_ = np.linalg.norm(way, axis=1)
    noise = np.exp(np.random.default_rng(seed).normal(0.0, 0.15, len(way)))
    return 0.3 * (way[:, 1] / range_) * (8.0 / range_) ** 2 * noise


def within(scan, box):
    x, z = scan.xyz[:, 0], scan.xyz[:, 2]
    return (x > box[0]) & (x < box[2]) & (z > box[1]) & (z < box[3])


def shutters(facade, scan):
    """Openings found where the grid lacks one."""
    middle = np.array([GRID[SHUT][0] + 0.55, GRID[SHUT][1] + 0.75])
    openings = find_openings(facade, scan).openings
    assert sum(o.provenance is not Provenance.INFERRED for o in openings) >= len(HOLES)
    return [o for o in openings if (o.ring.min(0) < middle).all() and (o.ring.max(0) > middle).all()]


@pytest.mark.parametrize("by", ["intensity", "colour"])
def test_a_closed_shutter_is_found_where_the_grid_expects_a_window(wall, by):
    facade, scan = wall
    leaf = within(scan, GRID[SHUT])
    if by == "intensity":
        seen = replace(scan, intensity=(brightness(scan) * np.where(leaf, 0.6, 1.0)).astype(np.float32))
    else:
        noise = np.random.default_rng(2).normal(0.0, 8.0, (len(leaf), 3))
        colour = np.where(leaf[:, None], (60, 90, 70), (170, 160, 140)) + noise
        seen = replace(scan, rgb=np.clip(colour, 0, 255).astype(np.uint8))
    (found,) = shutters(facade, seen)
    assert found.kind == "window" and found.provenance is Provenance.MEASURED and found.confidence > 0.99
    assert np.abs(box_of(found) - GRID[SHUT]).max() < 0.015
    assert found.depth is not None and abs(found.depth.value) < 0.005


def test_without_intensity_and_colour_nothing_is_found(wall):
    assert shutters(*wall) == []


def test_a_whole_column_of_closed_shutters_is_found_along_the_rows():
    column = [GRID[k] for k in (1, 5, 9)]
    facade, scan = scan_wall([b for b in GRID if b not in column], spacing=0.03, size=SIZE, returned=0.5)
    leaf = np.any([within(scan, box) for box in column], axis=0)
    seen = replace(scan, intensity=(brightness(scan) * np.where(leaf, 0.6, 1.0)).astype(np.float32))
    boxes = np.array([box_of(o) for o in find_openings(facade, seen).openings])
    for box in column:
        assert np.abs(boxes - box).max(1).min() < 0.025


@pytest.mark.parametrize("depth", [-0.02, 0.01, 0.03, 0.06])
def test_relief_alone_tells_a_shutter_before_or_behind_the_wall(wall, depth):
    facade, scan = wall
    xyz, leaf = scan.xyz.copy(), within(scan, GRID[SHUT])
    xyz[leaf] += (xyz[leaf] - EYE) * (depth / 8.0)
    (found,) = shutters(facade, replace(scan, xyz=xyz))
    assert np.abs(box_of(found) - GRID[SHUT]).max() < 0.03
    assert found.depth is not None and found.depth.value == pytest.approx(depth, abs=0.005)


@pytest.mark.parametrize(("shade", "number"), [(1.0, 0), (0.6, 1)])
def test_what_steps_back_and_looks_like_the_wall_is_a_blind_window(wall, shade, number):
    facade, scan = wall
    xyz, leaf = scan.xyz.copy(), within(scan, GRID[SHUT])
    xyz[leaf] += (xyz[leaf] - EYE) * (0.04 / 8.0)
    light = brightness(scan) * np.where(leaf, shade, 1.0)
    found = shutters(facade, replace(scan, xyz=xyz, intensity=light.astype(np.float32)))
    assert len(found) == number


def test_a_closed_shutter_under_an_arch_has_the_arch_of_its_like():
    rings = [ring_of("round", box, 0.55)[0] for box in GRID]
    rng = np.random.default_rng(0)
    p = np.column_stack([rng.uniform(0, s, 90000) for s in SIZE])
    inside = np.array([ring_contains(ring, p) for ring in rings])
    pane = inside[[k for k in range(len(GRID)) if k != SHUT]].any(0)
    keep = ~pane | (rng.random(len(p)) < 0.3)
    facade, scan = scan_wall([], spacing=0.03, size=SIZE)
    xyz = np.column_stack([p[:, 0], 0.2 * pane + rng.normal(0, 0.003, len(p)), p[:, 1]])[keep]
    xyz += (xyz - EYE) * (xyz[:, 1:2] / 8.0)
    index = np.arange(len(xyz))
    scan = replace(scan, xyz=xyz, origin_index=np.zeros(len(xyz), np.int32))
    facade = replace(facade, support=index, inliers=index)
    dark = np.where(inside[SHUT][keep], 0.6, 1.0)
    (found,) = shutters(facade, replace(scan, intensity=(brightness(scan) * dark).astype(np.float32)))
    assert found.shape == "round"
    assert np.abs(box_of(found) - GRID[SHUT]).max() < 0.03


def plain(scan):
    return np.ones(len(scan.xyz))


def course(scan):
    """A string course of other stone runs through the place."""
    return np.where((scan.xyz[:, 2] > 3.6) & (scan.xyz[:, 2] < 5.1), 0.6, 1.0)


def repair(scan):
    """A patch of plaster at the place, half as high as a window."""
    return np.where(within(scan, (3.0, 3.5, 4.3, 4.3)), 0.6, 1.0)


def shade(scan):
    """Something without sharp borders."""
    away = np.hypot(scan.xyz[:, 0] - 3.65, scan.xyz[:, 2] - 4.35)
    return 1.0 - 0.5 * np.exp(-((away / 0.7) ** 2))


def blocks(scan):
    """Stones of half a metre, each of its own brightness."""
    column, row = np.floor(scan.xyz[:, 0] / 0.55), np.floor(scan.xyz[:, 2] / 0.5)
    return 0.7 + 0.3 * np.modf(np.abs(np.sin(12.9898 * column + 78.233 * row)) * 43758.5453)[0]


@pytest.mark.parametrize("look", [plain, course, repair, shade, blocks])
def test_what_else_differs_on_a_wall_is_no_shutter(wall, look):
    facade, scan = wall
    seen = replace(scan, intensity=(brightness(scan) * look(scan)).astype(np.float32))
    assert shutters(facade, seen) == []


def test_a_panel_where_no_opening_is_expected_is_left_alone(wall):
    facade, scan = wall
    panel = within(scan, (2.1, 2.4, 3.0, 3.5))
    seen = replace(scan, intensity=(brightness(scan) * np.where(panel, 0.5, 1.0)).astype(np.float32))
    assert not any(box_of(o)[0] > 1.95 and box_of(o)[2] < 3.1 for o in find_openings(facade, seen).openings)


def intensity_of(facade, scan, look):
    seen = replace(scan, intensity=(brightness(scan) * look(scan)).astype(np.float32))
    surface = wall_points(facade, seen, sort_beams(facade, seen), (0.05, 0.05))
    return scan_layer(surface, facade, seen)


def test_intensity_is_freed_of_range_and_incidence(wall):
    facade, scan = wall
    xz, values = intensity_of(facade, scan, plain).near((0.0, 0.0, *SIZE))
    (x, z), value = xz.T, values[:, 1]
    corners = [
        value[(np.abs(x - a) < 0.5) & (np.abs(z - b) < 0.5)].mean() for a in (0.5, 8.5) for b in (0.4, 8.5)
    ]
    raw = np.log(brightness(scan))
    assert np.ptp(raw) > 3.0 * np.ptp(corners) and np.ptp(corners) < 0.1


def test_the_wall_tells_how_large_its_own_steps_are(wall):
    facade, scan = wall
    form = OpeningForm("rectangle", 1.1, 1.5, 0.0)
    covariance = [
        wall_steps(intensity_of(facade, scan, look).picture.without(GRID), form) for look in (plain, blocks)
    ]
    assert (covariance[1][:, 1, 1] > 4.0 * covariance[0][:, 1, 1]).all()


def bricks(scan, size, seed):
    """Factors (n,) of stones of a size, each of its own."""
    column, row = np.floor(scan.xyz[:, 0] / size), np.floor(scan.xyz[:, 2] / size)
    return 0.8 + 0.4 * np.modf(np.abs(np.sin(12.9898 * column + 78.233 * row + seed)) * 43758.5453)[0]


@pytest.mark.parametrize("shown", ["intensity", "colour", "both"])
def test_intensity_and_colour_tell_together_what_neither_tells_alone(wall, shown):
    facade, scan = wall
    leaf = within(scan, GRID[SHUT])
    noise = np.random.default_rng(2).normal(0.0, 4.0, (len(leaf), 1))
    grey = 150.0 * bricks(scan, 0.3, 1)[:, None] * (0.84 if shown != "intensity" else 1.0) ** leaf[:, None]
    dark = bricks(scan, 0.24, 2) * (0.84 if shown != "colour" else 1.0) ** leaf
    rgb = np.repeat(np.clip(grey + noise, 0, 255).astype(np.uint8), 3, axis=1)
    seen = replace(scan, rgb=rgb, intensity=(brightness(scan) * dark).astype(np.float32))
    assert len(shutters(facade, seen)) == (shown == "both")


def test_many_closed_windows_are_told_by_the_wall_beside_them(wall):
    """They are no witnesses of what the wall shows by itself."""
    shut = [GRID[k] for k in (1, 2, 4, 5, 6, 9, 10)]
    facade, scan = scan_wall([b for b in GRID if b not in shut], spacing=0.03, size=SIZE, returned=0.5)
    leaf = np.any([within(scan, box) for box in shut], axis=0)
    seen = replace(scan, intensity=(brightness(scan) * np.where(leaf, 0.7, 1.0)).astype(np.float32))
    boxes = np.array([box_of(o) for o in find_openings(facade, seen).openings])
    assert all(np.abs(boxes - box).max(1).min() < 0.03 for box in shut)


@pytest.mark.parametrize("rays", [True, False])
def test_a_grille_level_with_the_wall_is_an_opening_of_the_row(rays):
    """Bars that send back as much as gaps do, a pane behind them."""
    facade, scan = scan_wall(GRID, spacing=0.03, size=SIZE, depth=0.1, rays=rays)
    leaf = within(scan, GRID[SHUT])
    bars = leaf & (np.modf(scan.xyz[:, 0] / 0.1)[0] < 0.45)
    xyz = scan.xyz.copy()
    xyz[bars] -= (xyz[bars] - EYE) * (xyz[bars, 1] / (xyz[bars, 1] - EYE[1]))[:, None]
    (found,) = shutters(facade, replace(scan, xyz=xyz))
    assert np.abs(box_of(found) - GRID[SHUT]).max() < 0.03


@pytest.mark.parametrize("by", [0.85, 1.15])
def test_a_poster_of_another_size_in_the_row_is_no_window(by):
    """It stands on the row's line, where the wall has room between two columns."""
    columns = [box for box in GRID if box[0] in (0.9, 7.3)]
    facade, scan = scan_wall(columns, spacing=0.03, size=SIZE, returned=0.5)
    for size, taken in ((1.0, 1), (by, 0)):
        box = (3.5, 3.6, 3.5 + 1.1 * size, 5.1)
        poster = np.where(within(scan, box), 0.5, 1.0)
        seen = replace(scan, intensity=(brightness(scan) * poster).astype(np.float32))
        found = [box_of(o) for o in find_openings(facade, seen).openings]
        assert sum(3.3 < b[0] < 3.7 and abs(b[1] - 3.6) < 0.1 for b in found) == taken
