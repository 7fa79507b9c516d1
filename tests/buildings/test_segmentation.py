"""`change_points` by dynamic programming."""

import numpy as np

from frontage.solve.segmentation import change_points


def test_steps_are_found_in_place() -> None:
    rng = np.random.default_rng(0)
    signal = np.repeat([0.0, 5.0, 1.0], [30, 20, 25])[:, None] + rng.normal(size=(75, 1))
    assert change_points(signal, 20.0, 5).tolist() == [30, 50]


def test_noise_and_drift_give_no_change_point() -> None:
    rng = np.random.default_rng(1)
    ramp = np.linspace(0, 20, 100)[:, None] + rng.normal(size=(100, 1))
    assert len(change_points(ramp, 20.0, 5, np.array([True]))) == 0
    assert len(change_points(ramp, 20.0, 5)) > 0


def test_unmeasured_bins_are_ignored() -> None:
    signal = np.repeat([0.0, 9.0], 20)[:, None]
    signal[18:23] = np.nan
    cut = change_points(signal, 10.0, 4)
    assert len(cut) == 1
    assert 18 <= cut[0] <= 23
