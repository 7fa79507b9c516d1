"""Holes of symmetric facades are filled by option only, from the other half, and marked as inferred."""

import numpy as np
import pytest

import ortho_wall as wall
from frontage.model import INFERRED, NOT_SEEN
from frontage.ortho import OrthoOptions
from frontage.ortho.bands import Bands
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.symmetry import fill_by_symmetry

HOLE = np.s_[300:420, 150:330]
AXIS_PX = 437.0  # not the middle of the picture


def picture(symmetric: bool):
    """A picture (600, 900, 3) of a wall, symmetric about a column or not."""
    half = wall.texture(9.0, 6.0, seed=3)
    if not symmetric:
        return half
    away = np.abs(np.arange(900) + 0.5 - AXIS_PX).astype(int)
    return half[:, away]


def drawn(truth):
    """The bands of a facade of which one photo shows everything but a hole, with noise of the camera."""
    raster = OrthoRaster((0.0, 6.0), 0.01, 900, 600)
    bands = Bands(raster)
    noise = np.random.default_rng(1).normal(0, 4, truth.shape)
    bands.pixels[..., :3] = np.clip(truth + noise, 0, 255)
    bands.pixels[..., 3], bands.source[:], bands.gsd[:] = 255, 1, 0.004
    bands.pixels[HOLE], bands.source[HOLE], bands.gsd[HOLE] = 0, NOT_SEEN, np.nan
    bands.source[:, :10] = 0
    return bands, raster


def test_a_hole_is_filled_from_the_other_half_and_marked():
    truth = picture(symmetric=True)
    bands, raster = drawn(truth)
    fill_by_symmetry(bands, raster, OrthoOptions(fill="symmetry"))
    assert (bands.source[HOLE] == INFERRED).all() and (bands.pixels[HOLE][..., 3] == 255).all()
    off = np.abs(bands.pixels[HOLE][..., :3].astype(float) - truth[HOLE])
    assert 2.0 < off.mean() < 5.0  # the noise, and no shift: neighbouring pixels differ by more
    assert (bands.source[:, :10] == 0).all() and np.isfinite(bands.gsd[HOLE]).all()
    outside = np.ones(bands.source.shape, bool)
    outside[HOLE] = False
    assert not (bands.source[outside] == INFERRED).any()


@pytest.mark.parametrize(("symmetric", "fill"), [(True, "nothing"), (False, "symmetry")])
def test_holes_stay_empty_without_the_option_and_without_symmetry(symmetric, fill):
    bands, raster = drawn(picture(symmetric))
    fill_by_symmetry(bands, raster, OrthoOptions(fill=fill))
    assert (bands.source[HOLE] == NOT_SEEN).all() and (bands.pixels[HOLE] == 0).all()
