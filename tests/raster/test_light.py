"""Gains on light: what is saturated was at least as bright, everything else is scaled."""

import numpy as np

from frontage.raster.light import brightened, code_scale, linear_light, scaled

GAIN = np.full((1, 1, 3), np.log(0.5))


def shown(code, gain=GAIN):
    return brightened(np.array([[code]], np.uint8), gain)[0, 0].tolist()


def test_light_is_scaled():
    for code in (30, 120, 200, 230):
        (found, *_) = shown((code, code, code))
        assert abs(linear_light(np.uint8(found)) / linear_light(np.uint8(code)) - 0.5) < 0.02


def test_saturated_white_stays_white_and_saturated_colours_are_scaled():
    assert shown((255, 255, 255)) == [255, 255, 255]
    red, green, _ = shown((255, 60, 50))
    assert red < 200 and green < 45
    assert shown((255, 255, 255), -GAIN) == [255, 255, 255]


def test_white_fades_without_a_step():
    codes = np.repeat(np.arange(220, 256, dtype=np.uint8)[None, :, None], 3, axis=2)
    found = brightened(codes, np.broadcast_to(GAIN, codes.shape))[0, :, 0].astype(int)
    assert (np.diff(found) >= 0).all() and np.diff(found).max() <= 20


def test_the_fourth_channel_stays():
    codes = np.random.default_rng(0).integers(0, 256, (40, 50, 4)).astype(np.uint8)
    gain = np.random.default_rng(1).normal(0.0, 0.5, (40, 50, 3))
    scale = np.dstack([code_scale(gain), np.ones((40, 50), np.float32)])
    found = scaled(codes, scale)
    assert np.array_equal(found[..., 3], codes[..., 3])
    assert np.array_equal(found[..., :3], brightened(np.ascontiguousarray(codes[..., :3]), gain))
