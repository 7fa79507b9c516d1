"""Resampling, depth buffers and gridding on small arrays with known answers."""

import cv2
import numpy as np
import pytest

from frontage.raster import gridding, tiles
from frontage.raster import interpolation as between
from frontage.raster import resample as resampling
from frontage.raster.sourcemap import SourceMap, fitted
from frontage.raster.zbuffer import local_spacing, splat_depth


def resample(picture, at, jacobian, interpolation="adaptive"):
    """The colours (m, n, 3) of a map given pixel by pixel."""
    sampled = resampling.resample(
        picture, SourceMap.of_pixels(at, np.asarray(jacobian, float)), interpolation
    )
    assert (sampled[..., 3] == 255).all()
    return sampled[..., :3]


def grid(h: int, w: int, scale: float, at=(0.0, 0.0)) -> np.ndarray:
    u, v = np.meshgrid(at[0] + (np.arange(w) + 0.5) * scale, at[1] + (np.arange(h) + 0.5) * scale)
    return np.stack([u, v], axis=-1).astype(np.float32)


def noise(h: int, w: int, sigma: float = 0.0) -> np.ndarray:
    picture = np.random.default_rng(0).integers(0, 256, (h, w, 3)).astype(np.uint8)
    return cv2.GaussianBlur(picture, (0, 0), sigma) if sigma else picture


@pytest.mark.parametrize("interpolation", ["bilinear", "nearest"])
def test_the_identity_changes_nothing(interpolation):
    picture = noise(60, 80)
    assert np.array_equal(resample(picture, grid(60, 80, 1.0), np.eye(2), interpolation), picture)


def test_half_a_pixel_there_and_back_softens_less_than_bilinear():
    picture = noise(60, 80, 1.0)
    inner = (slice(5, -5), slice(5, -5))
    change = {}
    for interpolation in ("adaptive", "bilinear"):
        there = resample(picture, grid(60, 80, 1.0, (0.5, 0.5)), np.eye(2), interpolation)
        back = resample(there, grid(60, 80, 1.0, (-0.5, -0.5)), np.eye(2), interpolation)
        change[interpolation] = np.abs(back[inner].astype(int) - picture[inner]).mean()
    assert 0.0 < change["adaptive"] < 0.4 * change["bilinear"]
    same = resample(picture, grid(60, 80, 1.0), np.eye(2)).astype(int)
    assert np.abs(same - picture)[inner].mean() < 1.0


@pytest.mark.parametrize("factor", [1.6, 2.5, 7.0])
def test_minifying_a_fine_pattern_gives_its_mean_and_no_moire(factor):
    stripes = np.zeros((700, 700, 3), np.uint8)
    stripes[:, ::2] = 255
    n = int(700 / factor) - 12
    at = grid(n, n, factor, (3 * factor, 3 * factor))
    ours = resample(stripes, at, factor * np.eye(2)).astype(float)[4:-4, 4:-4]
    bilinear = resample(stripes, at, factor * np.eye(2), "bilinear").astype(float)[4:-4, 4:-4]
    assert ours.std() < (0.4 * bilinear.std() if factor < 2 else 12)
    light = 188 if factor >= 2 else 128  # half the light is code 188, half the code value 128
    assert abs(ours.mean() - light) < 6


def test_magnifying_is_sharper_than_bilinear_and_does_not_ring():
    edge = np.full((40, 40, 3), 50, np.uint8)
    edge[:, 20:] = 200
    at = grid(160, 160, 0.25)
    ours = resample(edge, at, 0.25 * np.eye(2))
    linear = resample(edge, at, 0.25 * np.eye(2), "bilinear")
    assert ours.min() == 50 and ours.max() == 200
    assert (
        np.abs(np.diff(ours[80, :, 0].astype(int))).max()
        > np.abs(np.diff(linear[80, :, 0].astype(int))).max()
    )


def test_an_oblique_view_is_filtered_along_its_long_axis_only():
    rows = np.zeros((300, 300, 3), np.uint8)
    rows[::8] = 255  # lines across the axis that is not minified
    J = np.array([[3.0, 0.0], [0.0, 1.0]])
    at = np.stack(np.meshgrid((np.arange(90) + 0.5) * 3, np.arange(250) + 0.5), axis=-1).astype(np.float32)
    picture = resample(rows, at, J)
    assert picture[64:72].max() > 120


def test_unknown_positions_do_not_affect_the_others():
    picture = noise(60, 80, 1.0)
    at = grid(60, 80, 1.0)
    at[:20] = np.nan
    assert np.array_equal(resample(picture, at, np.eye(2), "bilinear")[25:], picture[25:])


@pytest.mark.parametrize("scale", [0.4, 1.0, 1.6, 2.7])
def test_resampling_by_strips_gives_the_same_result(scale, monkeypatch):
    picture, at = noise(400, 500, 1.0), grid(120, 150, scale, (10.3, 20.7))
    whole = resample(picture, at, scale * np.eye(2))
    monkeypatch.setattr(resampling, "_CACHE_BYTES", 0)
    page = np.zeros((200, 300, 4), np.uint8)
    window = page[30:150, 40:190]
    resampling.resample(picture, SourceMap.of_pixels(at, scale * np.eye(2)), out=window)
    assert np.array_equal(window[..., :3], whole) and page.any(-1).sum() == 120 * 150
    part = np.s_[17:90, 33:140]
    found = resampling.resample(picture, SourceMap.of_pixels(at, scale * np.eye(2)), window=part)
    assert np.array_equal(found[..., :3], whole[part])


def test_grey_values_and_rough_averages_are_those_of_the_picture():
    for scale in (0.6, 1.0, 1.6, 4.7):
        picture, at = noise(400, 500, 6.0), grid(80, 90, scale, (10.3, 20.7))
        positions = SourceMap.of_pixels(at, scale * np.eye(2))
        whole = resampling.resample(picture, positions)
        grey = resampling.resample(picture, positions, out=np.empty((80, 90), np.uint8))
        of_colours = whole[..., :3] @ np.array([0.299, 0.587, 0.114])
        assert np.abs(grey - of_colours).max() < 4.0
        rough = resampling.resample(picture, positions, rough=True)
        assert np.abs(rough[..., :3].astype(int) - whole[..., :3]).max() <= 4
    stripes = np.zeros((64, 64, 3), np.uint8)
    stripes[:, ::2] = 255
    positions = SourceMap.of_pixels(grid(8, 8, 4.0, (16.0, 16.0)), 4.0 * np.eye(2))
    exact, rough = (resampling.resample(stripes, positions, rough=r)[4, 4, 0] for r in (False, True))
    assert (abs(int(exact) - 188) < 3) and (abs(int(rough) - 128) < 3), "equal parts of black and white"


def test_the_error_of_a_fitted_map_is_measured():
    def lens(column, row, depth):
        u, v, w = 30.0 + 0.9 * column, 20.0 - 1.1 * row, 1.0 + 0.05 * column + 0.02 * row + 0.006 * depth
        bent = 1.0 + 1e-5 * ((u - 30) ** 2 + (v - 20) ** 2)
        return np.stack([900.0 * u * bent / w, 900.0 * v * bent / w], axis=-1)

    m, n = 60, 80
    depth = np.random.default_rng(0).uniform(-1, 1, (m, n)).astype(np.float32)
    row, column = (np.arange(k) * (2.0 / k) - 1.0 + 1.0 / k for k in (m, n))
    truth = lens(*np.broadcast_arrays(column[None, :], row[:, None], depth))
    for degree in (1, 3, 6):
        found = fitted(lens, degree, 2)
        g0, g1, g2 = found.factors
        powers = (g0 - g2, g1, 2 * g2)
        at = SourceMap(powers, (m, n), np.eye(2), found.low, found.high, depth=depth)
        u, v = at.planes((1000.0, 2000.0), 2.0)
        error = np.abs(np.stack([(u + 0.5) / 2 + 1000, (v + 0.5) / 2 + 2000], -1) - truth).max()
        assert 0.3 * found.error < error + 0.001 and error < 1.1 * found.error + 0.01
        part = at.planes((1000.0, 2000.0), 2.0, np.s_[7:20, 5:31])
        assert np.allclose(part, np.stack([u, v])[:, 7:20, 5:31], atol=0.002)
    assert fitted(lens, 6, 2).error < 0.01 < fitted(lens, 1, 2).error
    assert fitted(lambda c, r, d: np.full((len(c), 2), np.nan), 3, 0).error == np.inf


def test_the_nearest_surface_wins_and_discs_close_gaps():
    x, y = np.meshgrid(np.arange(4.5, 100, 6), np.arange(4.5, 100, 6))
    wall = np.column_stack([x.ravel(), y.ravel()])
    xy = np.vstack([wall, [[50.5, 50.5]]])
    depth = np.r_[np.full(len(wall), 9.0), 4.0]
    buffer = splat_depth(xy, depth, np.r_[np.full(len(wall), 4.5), 2.0], (100, 100))
    assert np.isfinite(buffer[4:-4, 4:-4]).all()
    assert buffer[50, 50] == 4.0 and buffer[52, 50] == 4.0 and buffer[54, 50] == 9.0
    assert np.isinf(splat_depth(xy, depth, np.zeros(len(xy)), (100, 100))).mean() > 0.9


def test_spacing_is_measured_where_the_points_are():
    rng = np.random.default_rng(0)
    fine = np.column_stack([rng.uniform(0, 4, 40_000), np.zeros(40_000), rng.uniform(0, 4, 40_000)])
    coarse = np.column_stack([rng.uniform(10, 14, 10_000), np.zeros(10_000), rng.uniform(0, 4, 10_000)])
    spacing, count = local_spacing(np.vstack([fine, coarse]))
    assert np.median(spacing[:40_000]) == pytest.approx(0.02, rel=0.1)
    assert np.median(spacing[40_000:]) == pytest.approx(0.04, rel=0.1)
    assert count.min() >= 1
    some = np.array([3, 45_000])
    of_some = local_spacing(np.vstack([fine, coarse]), of=some)
    assert np.array_equal(of_some, (spacing[some], count[some]))


def test_quantiles_by_cell():
    cell = np.array([0, 0, 0, 3, 3])
    q, count = gridding.cell_quantiles(cell, np.array([3.0, 1, 2, 10, 20]), (2, 2), (0.0, 0.5, 1.0))
    assert count.tolist() == [[3, 0], [0, 2]]
    assert q[:, 0, 0] == pytest.approx([1, 2, 3]) and q[:, 1, 1] == pytest.approx([10, 15, 20])
    assert np.isnan(q[:, 0, 1]).all()


def test_bilinear_and_nearest_values_between_cells():
    field = np.arange(12.0).reshape(3, 4)
    u, v = np.array([-1.0, 0.5, 3.0, 9.0]), np.array([0.25, 2.0])
    assert np.allclose(between.bilinear(field, u, v), [[1.0, 1.5, 4.0, 4.0], [8.0, 8.5, 11.0, 11.0]])
    assert np.array_equal(between.nearest(field, u, v), field[[0, 2]][:, [0, 0, 3, 3]])
    assert np.allclose(between.bilinear(np.ones((1, 1)), u, v), 1.0)


@pytest.mark.parametrize("divided", [(1, 1), (3, 4), (5, 2)])
@pytest.mark.parametrize("first", [(-7, -3), (0, 0), (11, 26), (200, 300)])
def test_cells_divided_into_pixels_are_interpolated_like_any_others(divided, first):
    field = np.random.default_rng(1).random((9, 7, 3)).astype(np.float32)
    u, v = ((np.arange(f, f + 40) + 0.5) / d - 0.5 for f, d in zip(first, divided, strict=True))
    off = 1e-4  # cells: no longer the same pixels in every cell
    assert np.allclose(between.bilinear(field, u, v), between.bilinear(field, u + off, v + off), atol=4 * off)
    at = (np.broadcast_to(a, (40, 40)).astype(np.float32) for a in (u[None, :], v[:, None]))
    there = cv2.remap(field, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    assert np.allclose(between.bilinear(field, u, v), there, atol=1e-3)
    c, r = (np.clip(np.rint(a), 0, n - 1).astype(int) for a, n in ((u, 7), (v, 9)))
    assert np.array_equal(between.nearest(field[..., 0], u, v), field[r][:, c, 0])


@pytest.mark.parametrize("rows", [5, 40])
def test_few_rows_are_interpolated_like_many(rows):
    field = np.random.default_rng(2).random((20, 30)).astype(np.float32)
    u, v = np.linspace(-1.0, 31.0, 47), np.linspace(0.3, 18.9, rows)
    at = (np.broadcast_to(a, (rows, 47)).astype(np.float32) for a in (np.clip(u, 0, 29)[None, :], v[:, None]))
    there = cv2.remap(field, *at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    assert np.allclose(between.bilinear(field, u, v), there, atol=0.05)


@pytest.mark.parametrize("radius", [0.4, 1.0, 2.3, 5.0, 12.0])
def test_closing_is_that_of_a_disc_across_blocks(radius, monkeypatch):
    rng = np.random.default_rng(2)
    mask = rng.random((90, 130)) < 0.15 / max(radius, 1.0)
    around = np.pad(mask, 30)
    steps = np.argwhere(np.hypot(*np.mgrid[-12:13, -12:13]) <= radius) - 12
    grown = np.any([np.roll(around, step, (0, 1)) for step in steps], axis=0)
    closed = np.all([np.roll(grown, step, (0, 1)) for step in steps], axis=0)[30:-30, 30:-30]
    monkeypatch.setattr(gridding, "_BLOCK_PX", 32)
    found = gridding.closed(mask, np.full(mask.shape, radius))
    assert (found != closed).mean() < (0.02 if radius > 8 else 1e-9), "large discs are good to two per cent"


def test_no_position_is_lost_among_bands_of_rows():
    row = np.random.default_rng(3).uniform(-200.0, 900.0, 3000)
    order, band = gridding.by_rows(row)
    for first, last in ((-200, -1), (0, 100), (333, 335), (880, 2000)):
        chosen = order[gridding.of_rows(band, first, last)]
        wanted = np.flatnonzero((row >= first) & (row <= last))
        assert set(wanted) <= set(chosen) and len(chosen) < len(wanted) + 600


def test_closing_fills_narrow_gaps_and_grows_no_edge():
    block = np.zeros((80, 80), bool)
    block[20:60, 20:60:4] = True
    closed = gridding.closed(block, np.full(block.shape, 4.0))
    assert closed[25:55, 22:55].all()
    assert not closed[:, :19].any() and not closed[:19].any()
    assert not gridding.closed(block, np.full(block.shape, 1.0))[30, 22:24].all()


def test_growing_is_that_of_a_disc():
    point = np.zeros((41, 41), bool)
    point[20, 20] = True
    away = np.hypot(*np.mgrid[-20:21, -20:21])
    for radius in (0.4, 2.5, 6.0):
        assert np.array_equal(gridding.grown(point, np.full(point.shape, radius)), away <= radius)


def test_distances_within_reach_are_those_of_octagons():
    point = np.zeros((61, 61), bool)
    point[30, 30] = True
    away = np.hypot(*np.mgrid[-30:31, -30:31])
    found = gridding.distance_within(point, 20.0)
    assert found[30, 30] == 0 and (found[30, 31:50] == np.arange(1, 20)).all()
    assert (np.abs(found - away)[away <= 18] <= 0.08 * away[away <= 18] + 1.0).all()
    assert (found[away > 23] == 20).all()
    assert (gridding.distance_within(np.zeros((5, 5), bool), 3.0) == 3).all()


def test_nearest_known_value_fills():
    field = np.full((5, 9), np.nan)
    field[2, 0], field[2, 8] = 1.0, 2.0
    assert gridding.nearest_filled(field)[2].tolist() == [1, 1, 1, 1, pytest.approx(1.5, abs=0.5), 2, 2, 2, 2]


def test_tiles_cover_once():
    count = np.zeros((1000, 700), int)
    for tile in tiles.tiles(1000, 700, 256):
        count[tile.window] += 1
        assert max(tile.shape) <= 256
    assert (count == 1).all()


def test_bands_beyond_memory_are_memory_maps(monkeypatch):
    monkeypatch.setattr(tiles, "IN_MEMORY", 1000)
    band = tiles.allocate((50, 40), np.float32, np.nan)
    assert isinstance(band, np.memmap) and np.isnan(band).all()
    band[3, 4] = 7.0
    assert band[3, 4] == 7.0
    assert not isinstance(tiles.allocate((2, 2), np.uint8), np.memmap)
