"""Helpers of arrays."""

import numpy as np
import pytest

from frontage.geometry.arrays import distinct, drawn, extent, rising, sorted_groups


@pytest.mark.parametrize("values", [[], [7], [3, 3, 3], [5, -2, 5, 0, -2, 9]])
def test_distinct_values_rise_and_come_once(values: list[int]) -> None:
    found = distinct(np.array(values, np.int64))
    assert found.tolist() == sorted(set(values))


def test_the_same_places_are_drawn_in_whatever_order_they_come() -> None:
    rng = np.random.default_rng(2)
    places = rng.uniform(-50, 50, (20_000, 2))
    some, order = drawn(places, 5000), rng.permutation(len(places))
    again = order[drawn(places[order], 5000)]
    assert np.array_equal(np.sort(again), some)
    assert 4700 < len(some) < 5300
    assert np.abs(places[some].mean(0)).max() < 1.5  # spread all over
    assert len(drawn(places, 20_000)) == 20_000


@pytest.mark.parametrize("number", [0, 1, 7, 511, 512, 2000])
def test_the_extent_of_places_is_that_of_their_columns(number: int) -> None:
    places = np.random.default_rng(number).normal(0, 10, (number, 3))
    low, high = extent(places)
    assert np.array_equal(low, places.min(0, initial=np.inf))
    assert np.array_equal(high, places.max(0, initial=-np.inf))


@pytest.mark.parametrize("digits", [0, 1, 12])
def test_equal_values_rise_as_they_come(digits: int) -> None:
    values = np.round(np.random.default_rng(digits).uniform(-5, 5, 3000), digits)
    assert np.array_equal(rising(values), np.argsort(values, kind="stable"))
    assert len(rising(values[:0])) == 0


@pytest.mark.parametrize("largest", [0, 40, 1 << 62])
def test_groups_hold_equal_keys_as_they_come(largest: int) -> None:
    key = np.random.default_rng(3).integers(0, largest, 500, endpoint=True)
    order, start = sorted_groups(key)
    assert np.array_equal(order, np.argsort(key, kind="stable"))
    assert np.array_equal(key[order][start], np.unique(key))
    assert [len(v) for v in sorted_groups(key[:0])] == [0, 0]
