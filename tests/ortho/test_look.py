"""One look for a street: what photos shared by buildings tell of their light."""

import numpy as np
import pytest

from frontage.ortho.look import common_look

RNG = np.random.default_rng(5)


def rows(gain: np.ndarray) -> np.ndarray:
    return np.stack([gain, np.full(3, -0.2), np.full(3, 0.05)])


def test_shared_photos_bring_a_terrace_to_one_look_whatever_a_bad_one_says() -> None:
    exposure = {f"P{k}": RNG.normal(0, 0.7, 3) for k in range(12)}
    base = RNG.normal(0, 0.5, (4, 3))  # log light of the houses' own looks
    houses = {
        f"B{b}": {f"P{k}": rows(exposure[f"P{k}"] - base[b]) for k in range(2 * b, 2 * b + 6)}
        for b in range(4)
    }
    houses["B1"]["P4"] = houses["B1"]["P4"] + 1.5  # a cloud passed
    found = common_look(houses)
    shown = np.stack([base[b] + found[f"B{b}"] for b in range(4)])
    assert np.ptp(shown, axis=0).max() < 0.02
    assert np.abs(np.mean(list(found.values()), axis=0)).max() < 1e-3


def test_a_building_that_shares_no_photo_stays_as_it_is() -> None:
    found = common_look({"A": {"P1": rows(np.ones(3))}, "B": {"P2": rows(-np.ones(3))}, "C": {}})
    assert all(np.abs(value).max() < 1e-12 for value in found.values())
    assert common_look({}) == {}


def test_pictures_of_one_look_stay() -> None:
    same = {"P1": rows(np.array([0.3, 0.2, 0.1])), "P2": rows(np.zeros(3))}
    assert np.stack(list(common_look({"A": same, "B": same}).values())) == pytest.approx(0.0, abs=1e-12)
