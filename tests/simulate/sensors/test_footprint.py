"""The beam's cross-section: size at range, Gaussian edges."""

import numpy as np
import pytest
from scipy.special import ndtr

from frontage.simulate.sensors.footprint import beam_pattern, sub_rays
from laser_scenes import instrument


@pytest.mark.parametrize("count", [1, 7, 19, 37])
def test_pattern_is_a_centred_average(count: int) -> None:
    node, weight = beam_pattern(count)
    assert weight.sum() == pytest.approx(1) and len(node) == count
    np.testing.assert_allclose(weight @ node, 0, atol=1e-15)
    if count > 1:
        moments = (node * weight[:, None]).T @ node
        np.testing.assert_allclose(moments, np.eye(2) / 4, atol=1e-14)


@pytest.mark.parametrize("distance", [2.0, 20.0, 100.0])
def test_footprint_has_the_diameter_of_the_beam(distance: float) -> None:
    beam = instrument(exit_beam=0.004, divergence=3e-4, subrays=19)
    direction = np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]])
    start, d = sub_rays(beam, np.zeros((3, 3)), direction, 5)
    at = start + distance * d
    off = at - np.einsum("nkj,nj->nk", at, direction)[..., None] * direction[:, None]
    second = np.einsum("k,nkj,nkj->n", beam_pattern(19)[1], off, off) / 2
    diameter = 4 * np.sqrt(second)  # the 1/e2 diameter of a Gaussian beam is four standard deviations
    np.testing.assert_allclose(diameter, np.hypot(0.004, 3e-4 * distance), rtol=1e-6)
    assert beam.footprint(distance) == pytest.approx(np.hypot(0.004, 3e-4 * distance))


def test_an_edge_cuts_the_power_like_a_gaussian() -> None:
    beam = instrument(exit_beam=0.005, divergence=4e-4, subrays=19)
    n = 2000
    start, d = sub_rays(beam, np.zeros((n, 3)), np.tile([0.0, 1.0, 0.0], (n, 1)), 0)
    x = (start + 25.0 * d)[..., 0]
    sigma = beam.footprint(25.0) / 4
    for edge in (-1.0, -0.3, 0.0, 0.6, 1.4):
        share = ((x < edge * sigma) @ beam_pattern(19)[1]).mean()  # over all turns of the pattern
        assert share == pytest.approx(ndtr(edge), abs=0.045)
