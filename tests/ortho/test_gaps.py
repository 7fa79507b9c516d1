"""Gaps between the samples of a wall: lattices, sparse and dense parts, lone samples."""

import numpy as np
import pytest

from frontage.ortho.gaps import local_gaps
from frontage.ortho.orthoraster import OrthoRaster

RASTER = OrthoRaster((0.0, 0.0), 0.01, 1000, 600)


def scattered(spacing, seed=0):
    """Samples (n, 2) px at random with this spacing on the raster."""
    rng = np.random.default_rng(seed)
    count = int(RASTER.width * RASTER.height / spacing**2)
    return rng.uniform([0, 0], [RASTER.width, RASTER.height], (count, 2))


@pytest.mark.parametrize("spacing", [2.0, 5.0, 14.0])
def test_random_samples_have_the_spacing_of_their_density(spacing):
    gaps = local_gaps(scattered(spacing), RASTER, spacing)
    assert np.median(gaps.px) == pytest.approx(spacing, rel=0.15)


def test_a_part_that_is_five_times_sparser_than_typical_is_found():
    dense, sparse = scattered(3.0), scattered(15.0, seed=1)
    at = np.concatenate([dense[dense[:, 0] < 500], sparse[sparse[:, 0] >= 500]])
    gaps = local_gaps(at, RASTER, 3.0)
    rows = np.array([300])
    assert gaps.at(rows, np.array([150]))[0, 0] == pytest.approx(3.0, rel=0.25)
    assert gaps.at(rows, np.array([850]))[0, 0] == pytest.approx(15.0, rel=0.25)


def test_without_neighbours_the_typical_spacing_is_taken():
    for at in (np.zeros((0, 2)), np.array([[500.0, 300.0]])):
        assert (local_gaps(at, RASTER, 4.0).px == 4.0).all()
