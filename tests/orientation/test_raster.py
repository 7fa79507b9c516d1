"""Reflectance images show a scan as somebody at the scanner sees it, and know the points behind pixels."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3
from frontage.model.scan import Grid
from frontage.orientation.reflectance.raster import (
    facade_reflectance,
    panorama_reflectance,
    pull_push,
    raster_reflectance,
    reflectance_images,
)
from frontage.orientation.reflectance.surface import point_tones, scanned_surface
from raster_scans import EYE, SIZE, scan_raster, within

SIGN = (1.0, 3.5, 3.0, 5.0)  # x0, z0, x1, z1 of a bright board: to the left of the scanner, high up
NOWHERE = within((0, 0, 0, 0))


def wall(lost=NOWHERE, **more):
    """A scan of a wall of one reflectance with a bright board; intensity falls with range and incidence."""
    scan, _ = scan_raster(lost, noise=more.pop("noise", 0.0), street=False, step=0.008, **more)
    return replace(scan, intensity=intensity(scan.xyz))


def intensity(xyz):
    board = within(SIGN)(xyz[:, 0], xyz[:, 2])
    distance = np.linalg.norm(xyz - EYE, axis=1)
    cosine = (xyz[:, 1] - EYE[1]) / distance
    return (np.where(board, 0.8, 0.2) * cosine * (9.0 / distance) ** 2).astype(np.float32)


def on_board(image, margin=0.1):
    x0, z0, x1, z1 = SIGN
    inner = within((x0 + margin, z0 + margin, x1 - margin, z1 - margin))
    return inner(image.xyz[..., 0], image.xyz[..., 2])


def test_the_board_is_bright_and_stands_to_the_upper_left():
    image = raster_reflectance(wall())
    board = on_board(image)
    row, column = np.nonzero(board)
    rows, columns = np.nonzero(image.known)
    assert column.max() < columns.mean() and row.max() < rows.mean()
    beside = image.known & ~on_board(image, -0.1)
    assert image.pixels[board].min() > 1.5 * np.median(image.pixels[beside])


@pytest.mark.parametrize(
    "stored",
    [
        pytest.param(lambda g: g[::-1], id="rows down"),
        pytest.param(lambda g: g[:, ::-1], id="columns to the left"),
        pytest.param(lambda g: g[::-1, ::-1], id="upside down"),
        pytest.param(lambda g: g.T, id="rows and columns exchanged"),
        pytest.param(lambda g: g[::-1].T, id="turned by a quarter"),
    ],
)
def test_the_picture_is_the_same_however_the_raster_is_stored(stored):
    scan = wall()
    assert scan.grid is not None
    other = replace(scan, grid=Grid(np.ascontiguousarray(stored(scan.grid.index))))
    a, b = raster_reflectance(scan), raster_reflectance(other)
    assert np.array_equal(a.pixels, b.pixels) and np.array_equal(a.xyz, b.xyz, equal_nan=True)


def test_holes_of_three_pixels_are_closed_and_larger_ones_stay_black():
    scan = wall()
    assert scan.grid is not None
    index = scan.grid.index.copy()
    column = index.shape[1] // 2
    full = np.flatnonzero((index[:, column - 35 : column + 30] >= 0).all(1))
    row = int(full[len(full) // 2])
    index[row : row + 3, column : column + 3] = -1
    index[row : row + 4, column + 20 : column + 24] = -1
    index[row, column - 30 : column - 10] = -1  # long, but narrow
    image = raster_reflectance(replace(scan, grid=Grid(index)))
    turned = slice(None, None, -1)  # the raster is stored from the bottom up
    known, pixels, xyz = image.known[turned], image.pixels[turned], image.xyz[turned]
    assert known[row : row + 3, column : column + 3].all() and known[row, column - 30 : column - 10].all()
    assert (pixels[row : row + 3, column : column + 3] > 0).all()
    assert np.isnan(xyz[row : row + 3, column : column + 3]).all()
    assert not known[row : row + 4, column + 20 : column + 24].any()
    assert (pixels[row : row + 4, column + 20 : column + 24] == 0).all()


def test_tones_do_not_depend_on_range_and_incidence():
    scan = wall(noise=0.001)
    assert scan.intensity is not None
    plain = ~within(SIGN)(scan.xyz[:, 0], scan.xyz[:, 2])
    tone = point_tones(scan)
    assert len(tone) == len(scan)
    before, after = np.log(scan.intensity[plain]).std(), tone[plain].std()
    assert before > 0.1 and after < before


def test_points_between_pixels_lie_between_their_points():
    image = raster_reflectance(wall())
    row, column = np.nonzero(np.isfinite(image.xyz[..., 0]))
    rng = np.random.default_rng(0)
    some = rng.choice(len(row), 500)
    at = np.column_stack([column[some], row[some]]) + rng.uniform(0.05, 0.95, (500, 2))
    xyz = image.points(at)
    found = np.isfinite(xyz).all(1)
    assert found.mean() > 0.95
    own = image.xyz[row[some], column[some]]
    assert np.abs(xyz[found, 1]).max() < 1e-6
    assert 0.001 < np.median(np.linalg.norm(xyz - own, axis=1)[found]) < 0.08
    centre = np.column_stack([column[some], row[some]]) + 0.5
    assert np.allclose(image.points(centre), own, atol=1e-9)


def test_points_across_a_jump_are_not_mixed():
    scan = wall()
    assert scan.grid is not None
    behind = scan.xyz[:, 0] > 5.0
    ray = scan.xyz - np.array(EYE)
    xyz = np.where(behind[:, None], np.array(EYE) + 1.5 * ray, scan.xyz)
    image = raster_reflectance(replace(scan, xyz=xyz))
    h, w = image.pixels.shape
    grid = np.stack(np.meshgrid(np.arange(1, w, 0.25), np.arange(1, h, 0.25)), -1).reshape(-1, 2)
    y = image.points(grid)[:, 1]
    y = y[np.isfinite(y)]
    assert ((np.abs(y) < 0.3) | (y > 3.5)).all() and (y > 3.5).any()


def test_a_cloud_with_stations_is_looked_at_from_there():
    scan = replace(wall(), grid=None)
    images = reflectance_images(scan)
    assert 1 <= len(images) <= 8
    seen = np.concatenate([i.xyz[np.isfinite(i.xyz[..., 0])] for i in images])
    off = np.abs(seen[:, 1])  # along the border of the wall depths are means of few points
    assert np.quantile(off, 0.9) < 0.01 and off.max() < 0.2
    assert np.ptp(seen[:, 0]) > 0.9 * SIZE[0]
    image = max(images, key=lambda i: on_board(i).sum())
    board, beside = on_board(image), image.known & ~on_board(image, -0.1)
    assert np.median(image.pixels[board]) > 1.5 * np.median(image.pixels[beside])


def test_a_facade_is_drawn_to_scale():
    surface = scanned_surface(wall())
    frame = Rigid3("local", "facade", np.eye(3), np.zeros(3))
    image = facade_reflectance(surface, frame, (0.0, 0.0, *SIZE), 0.05)
    assert image.pixels.shape == (120, 200)
    row, column = np.nonzero(image.known)
    expected = np.column_stack([(column + 0.5) * 0.05, np.zeros(len(row)), SIZE[1] - (row + 0.5) * 0.05])
    assert np.abs(image.xyz[row, column] - expected).max() < 0.02
    x0, z0, x1, z1 = (round(v / 0.05) for v in SIGN)
    inside = image.pixels[120 - z1 + 2 : 120 - z0 - 2, x0 + 2 : x1 - 2]
    assert np.median(inside) > 1.5 * np.median(image.pixels[image.known])


def test_what_is_unknown_is_filled_smoothly():
    known = np.zeros((40, 60), np.bool_)
    known[:, :5] = known[:, -5:] = True
    values = np.where(np.arange(60) < 30, 0.2, 0.8)[None].repeat(40, 0).astype(np.float32) * known
    filled = pull_push(values, known)
    assert np.array_equal(filled[known], values[known])
    assert filled.min() >= 0.2 - 1e-6 and filled.max() <= 0.8 + 1e-6
    assert np.abs(np.diff(filled, axis=1)).max() < 0.3


def test_scans_that_give_no_picture_say_why():
    scan = wall()
    with pytest.raises(ValueError, match="neither intensity nor colour"):
        raster_reflectance(replace(scan, intensity=None))
    with pytest.raises(ValueError, match="no raster"):
        raster_reflectance(replace(scan, grid=None))
    lost = replace(scan, grid=None, origins=np.empty((0, 3)), origin_index=np.full(len(scan), -1, np.int32))
    with pytest.raises(ValueError, match="no stations"):
        reflectance_images(lost)
    assert reflectance_images(lost, eye=np.array(EYE))
    with pytest.raises(ValueError, match="neither intensity nor colour"):
        panorama_reflectance(scanned_surface(scan, "geometry"), np.array(EYE))
