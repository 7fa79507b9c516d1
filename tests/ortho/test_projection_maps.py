"""Maps of tiles into photos: as exact as asked, with as few terms as that takes."""

import numpy as np
import pytest

import ortho_wall as wall
from frontage.ortho import OrthoOptions
from frontage.ortho.orthoraster import facade_raster
from frontage.ortho.project import MAP_ERROR_PX, full_projection, map_tile
from frontage.raster.tiles import Tile

FACADE = wall.facade(12.0, 8.0)
RASTER = facade_raster(FACADE, OrthoOptions(margin=0.0))


def terms(at):
    return sum(power.shape[0] * power.shape[1] for power in at.powers)


@pytest.mark.parametrize("low, high", [(0.0, 0.0), (-0.02, 0.03), (-1.4, -1.39), (-0.9, 0.4)])
@pytest.mark.parametrize("tile", [Tile(100, 228, 500, 628), Tile(0, 768, 400, 1168)])
def test_a_map_is_as_exact_as_asked(low, high, tile):
    photo = wall.photo(FACADE, wall.camera(4000, 3000), (3.0, -10.0, -3.0))
    y = np.random.default_rng(1).uniform(low, high, tile.shape).astype(np.float32)
    to_photo = full_projection(photo, FACADE, RASTER)
    column, row = np.arange(tile.c0, tile.c1) + 0.5, np.arange(tile.r0, tile.r1) + 0.5
    truth = to_photo(column[None, :], row[:, None], y)
    for most in (MAP_ERROR_PX, 0.25):
        at = map_tile(to_photo, tile, y, most)
        error = np.abs(np.stack(at.planes((-0.5, -0.5), 1.0), -1) - truth).max()
        assert error < most + 0.005, "terms without effect and single precision"
        assert not at.exact


def test_a_small_tile_takes_few_terms():
    photo = wall.photo(FACADE, wall.camera(4000, 3000), (3.0, -7.0, -3.0))
    tile = Tile(100, 228, 500, 628)
    y = np.random.default_rng(1).uniform(-0.02, 0.03, tile.shape).astype(np.float32)
    assert terms(map_tile(full_projection(photo, FACADE, RASTER), tile, y)) < 40  # of 108 of degrees 5 and 2
