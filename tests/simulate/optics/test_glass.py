"""Panes: Fresnel's equations, stacks of sheets, coatings, and the conservation of energy."""

import numpy as np
import pytest

from frontage.simulate.optics.glass import INDEX, Panes, draw_panes, fresnel, pane_optics


def panes(sheets: int, coating: float = 0.0, absorbed: float = 0.0, n: int = 1) -> Panes:
    return Panes(np.full(n, sheets), np.full(n, coating), np.full(n, absorbed), np.full(n, 0.001))


def test_fresnel_at_normal_and_grazing_incidence() -> None:
    normal, grazing = fresnel(np.array([1.0, 0.0]))
    assert normal == pytest.approx(((INDEX - 1) / (INDEX + 1)) ** 2, abs=1e-15)
    assert normal == pytest.approx(0.0426, abs=1e-4)  # the 4 % of window glass
    assert grazing == pytest.approx(1.0, abs=1e-12)


def test_fresnel_at_brewsters_angle_reflects_s_light_only() -> None:
    angle = np.arctan(INDEX)
    # there the refracted ray is at a right angle to the reflected one, so r_s = sin(2a - 90 deg)
    r_s = np.sin(2 * angle - np.pi / 2) ** 2
    assert fresnel(np.cos(np.array([angle])))[0] == pytest.approx(r_s / 2, abs=1e-14)


def test_fresnel_obeys_snell_at_seventy_degrees() -> None:
    a = np.radians(70)
    b = np.arcsin(np.sin(a) / INDEX)
    s, p = np.sin(a - b) / np.sin(a + b), np.tan(a - b) / np.tan(a + b)
    assert fresnel(np.cos(np.array([a])))[0] == pytest.approx((s * s + p * p) / 2, abs=1e-14)


def test_clear_stacks_lose_nothing_and_reflect_like_their_surfaces() -> None:
    cosine = np.linspace(0.05, 1, 50)
    r = fresnel(cosine)
    one, through = pane_optics(panes(1, n=50), cosine)
    np.testing.assert_allclose(
        one, 2 * r / (1 + r), atol=1e-14
    )  # the series r + (1-r)^2 r + (1-r)^2 r^3 + ...
    two, less = pane_optics(panes(2, n=50), cosine)
    np.testing.assert_allclose(one + through, 1, atol=1e-14)
    np.testing.assert_allclose(two + less, 1, atol=1e-14)
    # two sheets from one: R + T^2 R / (1 - R^2)
    np.testing.assert_allclose(two, one + through**2 * one / (1 - one**2), atol=1e-14)


def test_films_and_absorption_reduce_the_transmitted_light() -> None:
    cosine = np.array([1.0, 0.5, 0.2])
    clear = pane_optics(panes(2, n=3), cosine)
    coated = pane_optics(panes(2, 0.6, n=3), cosine)
    tinted = pane_optics(panes(2, 0.6, 0.05, n=3), cosine)
    assert (coated[0] > clear[0]).all() and (coated[1] < clear[1]).all()
    assert (tinted[1] < coated[1]).all()
    assert (tinted[0] + tinted[1] < 1).all() and (tinted[0] > 0).all()


def test_windows_of_a_house_are_alike_and_transmit_less_at_longer_wavelengths() -> None:
    group = np.repeat(np.arange(30), 20)
    cosine = np.ones(len(group))
    through = {}
    for wavelength in (532, 905, 1550):
        drawn = draw_panes(group, wavelength, np.random.default_rng(4))
        through[wavelength] = pane_optics(drawn, cosine)[1].reshape(30, 20)
    assert through[532].mean() > through[905].mean() > through[1550].mean() > 0.2
    within, between = through[905].std(1).mean(), through[905].mean(1).std()
    assert within < 0.7 * between
    assert within > 0  # some panes were exchanged
