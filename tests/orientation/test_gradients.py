"""Oriented gradients do not know dark from light; templates of them are found to a fraction of a pixel."""

import cv2
import numpy as np
import pytest

from frontage.orientation.gradients import Channels, mean_channels, oriented_gradients
from frontage.orientation.templates import _fitted, correlation_surfaces, find_shifts


def picture(seed, size=(420, 520), finest=5):
    """Log tones (h, w) with detail of `finest` px and more, as smooth as a rendering is."""
    rng = np.random.default_rng(seed)
    total = np.zeros(size, np.float32)
    for step in (finest, 11, 30):
        grain = rng.normal(size=(size[0] // step + 4, size[1] // step + 4)).astype(np.float32)
        total += cv2.resize(grain, size[::-1], interpolation=cv2.INTER_CUBIC)
    return cv2.GaussianBlur(total, (0, 0), 1.0)


def moved(tones, shift):
    """The picture whose content lies `shift` px further to the right and down."""
    grid = np.fft.fftfreq(tones.shape[1]), np.fft.fftfreq(tones.shape[0])
    fx, fy = np.meshgrid(*grid)
    turn = np.exp(-2j * np.pi * (fx * shift[0] + fy * shift[1]))
    return np.fft.ifft2(np.fft.fft2(tones) * turn).real.astype(np.float32)


def noisy(tones, sigma, seed):
    """With noise that is correlated as in a joined rendering."""
    grain = np.random.default_rng(seed).normal(size=tones.shape).astype(np.float32)
    grain = cv2.GaussianBlur(grain, (0, 0), 1.0)
    return tones + sigma * grain / grain.std()


def test_the_negative_of_a_picture_has_the_same_channels():
    tones = picture(0)
    a, b = oriented_gradients(tones), oriented_gradients(-tones)
    assert np.abs(a.values).max() > 1.0
    assert np.allclose(a.values, b.values, atol=1e-4)


@pytest.mark.parametrize("gain", [0.05, 20.0])
def test_gain_and_offset_do_not_count(gain):
    tones = picture(1)
    a, b = oriented_gradients(tones), oriented_gradients(gain * tones + 3.0)
    assert np.abs(a.values - b.values).max() < 0.02 * np.abs(a.values).max()


def test_a_change_of_contrast_across_the_picture_hardly_counts():
    tones = picture(2)
    ramp = np.linspace(0.3, 3.0, tones.shape[1], dtype=np.float32)
    a, b = oriented_gradients(tones), oriented_gradients(tones * ramp)
    part = (slice(None), slice(30, -30), slice(30, -30))
    assert np.corrcoef(a.values[part].ravel(), b.values[part].ravel())[0, 1] > 0.95


def test_the_channels_tell_the_direction_of_an_edge():
    across = np.repeat((np.arange(80) > 40).astype(np.float32)[None], 80, axis=0)
    for tones, sign in ((across, 1), (across.T, -1)):
        values = oriented_gradients(tones).values
        at = np.unravel_index(values[2].argmax(), (80, 80))
        assert sign * values[0][at] > 1.0 and abs(values[1][at]) < 1e-3
    diagonal = (np.add.outer(np.arange(80), np.arange(80)) > 80).astype(np.float32)
    values = oriented_gradients(diagonal).values
    at = np.unravel_index(values[2].argmax(), (80, 80))
    assert values[1][at] > 1.0 and abs(values[0][at]) < 1e-3


def test_unknown_places_and_their_border_are_zero():
    known = np.ones((100, 100), bool)
    known[30:50, 30:50] = False
    found = oriented_gradients(picture(3, (100, 100)), known)
    assert not found.known[29:51, 29:51].any() and found.known[28, 28]
    assert not found.values[:, ~found.known].any()
    nothing = oriented_gradients(picture(3, (100, 100)), np.zeros((100, 100), bool))
    assert not nothing.values.any() and np.isfinite(nothing.values).all()


def test_the_mean_of_channels_is_taken_where_they_are_known():
    a, b = (oriented_gradients(picture(k, (60, 60))) for k in (4, 5))
    left = np.zeros((60, 60), bool)
    left[:, :30] = True
    half = Channels(b.values * left, b.known & left)
    both = mean_channels(a, half)
    assert np.allclose(both.values[:, 10:50, 40:50], a.values[:, 10:50, 40:50])
    assert np.allclose(both.values[:, 10:50, 5:25], 0.5 * (a.values + b.values)[:, 10:50, 5:25], atol=1e-6)
    assert np.array_equal(both.known, a.known)


SHIFTS = ((0.0, 0.0), (0.3, -0.4), (3.62, -2.25), (-5.5, 4.8))


@pytest.mark.parametrize("shift", SHIFTS)
def test_a_shift_is_found_to_a_fraction_of_a_pixel(shift):
    tones = picture(6)
    found = find_shifts(oriented_gradients(tones), oriented_gradients(moved(tones, shift)), 10)
    assert found.tried > 150 and len(found) > 0.95 * found.tried
    off = found.shift - shift
    assert np.abs(off).max() < 0.15 and np.abs(off.mean(0)).max() < 0.06
    assert found.score.min() > 0.9


def test_the_negative_is_found_in_the_same_place():
    tones = picture(7)
    found = find_shifts(oriented_gradients(tones), oriented_gradients(moved(-2.0 * tones, (2.3, -1.6))), 8)
    assert len(found) > 0.95 * found.tried
    assert np.abs(found.shift - (2.3, -1.6)).max() < 0.15


def test_standard_errors_are_right():
    squared = []
    for seed in range(6):
        tones, shift = picture(10 + seed), (2.0 + 0.17 * seed, -1.0 + 0.29 * seed)
        photo = noisy(moved(tones, shift), 0.7, seed)
        found = find_shifts(oriented_gradients(tones), oriented_gradients(photo), 8, 48)
        assert len(found) > 20
        good = (np.abs(found.shift - shift) < 1.5).all(1)
        assert good.mean() > 0.97
        squared.append(((found.shift - shift) / found.sigma)[good] ** 2)
        assert 0.01 < np.median(found.sigma) < 0.5
    assert 0.5 < np.sqrt(np.concatenate(squared).mean()) < 1.6


def test_edges_are_found_although_their_surroundings_look_alike():
    """The borders of windows: few are unique within the reach of the search, and most are measured."""
    tones, shift = np.zeros((420, 560), np.float32), (1.4, -0.7)
    for top in range(40, 420, 120):
        for left in range(30, 560, 140):
            tones[top : top + 70, left : left + 50] = -1.0
    tones = cv2.GaussianBlur(tones, (0, 0), 1.0)
    drawn, photo = (oriented_gradients(noisy(t, 0.05, k)) for k, t in enumerate((tones, moved(tones, shift))))
    found, unique = (find_shifts(drawn, photo, 6, 12, unique=u) for u in (False, True))
    assert unique.unique.all() and len(unique) == found.unique.sum() < 0.4 * found.tried
    assert len(found) > 0.6 * found.tried
    assert np.median(np.abs(found.shift - shift)) < 0.15


def test_larger_templates_are_more_precise_and_say_so():
    tones, shift = picture(20), (1.3, -0.6)
    rms, stated = [], []
    drawn, photo = (oriented_gradients(noisy(t, 0.5, k)) for k, t in enumerate((tones, moved(tones, shift))))
    for half in (24, 48):
        found = find_shifts(drawn, photo, 6, 24, half=half)
        rms.append(np.sqrt(((found.shift - shift) ** 2).mean()))
        stated.append(np.median(found.sigma))
    assert rms[1] < 0.7 * rms[0]
    assert stated[1] < 0.7 * stated[0]


def test_a_slanted_edge_is_open_along_itself():
    turn = np.radians(30.0)
    along, across = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    bend = 0.1 * np.outer(across, across) + 0.002 * np.outer(along, along)
    steps, peak = np.arange(-4, 5), np.array([0.2, -0.3])
    off = np.stack(np.meshgrid(steps, steps), axis=-1) - peak
    surface = 0.8 - 0.5 * np.einsum("hwi,ij,hwj->hw", off, bend, off)
    shift, sigma, score = _fitted(surface[None], np.array([4]), np.array([4]))
    assert np.allclose(shift, peak)
    variance = (1 - score[0] ** 2) / score[0] * np.linalg.inv(bend)
    assert np.allclose(sigma**2, np.diag(variance))
    assert sigma.min() > 0.4 * np.sqrt((1 - score[0] ** 2) / score[0] / 0.002)


def test_unrelated_pictures_give_almost_no_peak():
    tried = found = 0
    for seed in range(3):
        shifts = find_shifts(
            oriented_gradients(picture(30 + seed)), oriented_gradients(picture(60 + seed)), 12, 24
        )
        tried, found = tried + shifts.tried, found + len(shifts)
    assert tried > 150
    assert found < 0.05 * tried


def test_nothing_unknown_pulls_a_template():
    tones = picture(8)
    known = np.ones(tones.shape, bool)
    known[:, :250] = False
    photo = noisy(moved(tones, (1.4, -0.7)), 0.3, 0)
    photo[:, :240] += 4.0  # the photo shows something else there, with a strong edge
    found = find_shifts(oriented_gradients(tones, known), oriented_gradients(photo), 8)
    beside = np.abs(found.at[:, 0] - 260) < 20
    assert beside.sum() > 10
    off = found.shift[beside] - (1.4, -0.7)
    assert np.abs(np.median(off, axis=0)).max() < 0.1
    assert np.median(np.abs(off)) < 0.15


def test_templates_without_enough_known_pixels_are_not_tried():
    tones = picture(9, (200, 200))
    known = np.zeros((200, 200), bool)
    known[:, 100:] = True
    at, surfaces = correlation_surfaces(oriented_gradients(tones, known), oriented_gradients(tones), 6)
    assert at[:, 0].min() >= 100 and surfaces.shape == (len(at), 13, 13)
    assert np.abs(surfaces).max() <= 1.0 + 1e-4
    small = find_shifts(oriented_gradients(tones[:50, :50]), oriented_gradients(tones[:50, :50]), 6)
    assert len(small) == 0 and small.tried == 0


def test_large_templates_see_enough_between_gaps():
    """Of a template of 97 px a third is known, which is more than a whole one of 49 px has."""
    tones, shift = picture(11, (320, 320)), (1.3, -0.6)
    known = np.zeros(tones.shape, bool)
    known[np.indices(tones.shape)[1] % 24 < 9] = True
    drawn, photo = oriented_gradients(tones, known), oriented_gradients(moved(tones, shift))
    found = find_shifts(drawn, photo, 6, 12, half=48)
    assert 0.25 < drawn.known.mean() < 0.35 and len(found) > 100
    assert np.median(np.abs(found.shift - shift)) < 0.1
    assert not find_shifts(drawn, photo, 6, 12, half=24).tried


def test_templates_that_overlap_are_compared_at_once_with_the_same_result():
    tones = picture(8, (180, 220))
    known = np.ones(tones.shape, bool)
    known[40:90, 60:120] = False
    template, photo = oriented_gradients(tones, known), oriented_gradients(moved(tones, (1.3, -0.6)))
    dense, alone = {}, {}
    for surfaces, step in ((dense, 4), (alone, 40)):  # the second ones are so few that each is on its own
        at, found = correlation_surfaces(template, photo, 6, step, 30)
        surfaces.update(zip(map(tuple, at.tolist()), found, strict=True))
    assert len(dense) > 30 * 180 * 220 / 61**2 > len(alone) > 3
    for place, surface in alone.items():
        np.testing.assert_allclose(dense[place], surface, atol=1e-5)
