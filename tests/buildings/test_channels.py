"""Cuts move to the step; a gap must be seen through."""

import numpy as np

from frontage.buildings.fronts.profile import BIN_M, FrontProfile
from frontage.buildings.split.channels import sharpest
from frontage.buildings.split.gaps import open_bins
from frontage.solve.segmentation import change_points


def _gap(behind: bool) -> np.ndarray:
    n = 60
    wall = np.ones(n, bool)
    wall[30:36] = False
    value = np.where(wall, 0.0, np.nan)
    colour, rows, relief = np.full((n, 6), np.nan), np.ones((n, 8)), np.zeros((n, 8))
    profile = FrontProfile(0.0, value, value, value, colour, value, rows, relief, 0.0, wall * 40.0)
    s = (np.repeat(np.flatnonzero(wall), 10) + 0.5) * BIN_M
    d = np.zeros(len(s))
    if behind:
        s, d = np.append(s, (np.arange(30, 36) + 0.5) * BIN_M), np.append(d, np.full(6, -5.0))
    return open_bins(profile, s, d, np.full(len(s), 3.0), np.full(len(s), 4.0))


def test_a_stretch_without_wall_is_open_only_if_seen_through() -> None:
    assert np.flatnonzero(_gap(behind=True)).tolist() == list(range(30, 36))
    assert not _gap(behind=False).any()


def test_a_cut_moves_to_the_step() -> None:
    signal = np.repeat([0.0, 1.0], 40)[:, None]
    assert sharpest(signal, np.full_like(signal, 0.1), np.array([37]), 14).tolist() == [40]


def test_poorly_measured_bins_do_not_cut() -> None:
    signal = np.repeat([0.0, 5.0, 0.0, 5.0], 20)[:, None]
    weight = np.repeat([1.0, 1.0, 0.01, 0.01], 20)[:, None]
    assert change_points(signal, 20.0, 5, weight=weight).tolist() == [20]
    assert change_points(signal, 20.0, 5).tolist() == [20, 40, 60]
