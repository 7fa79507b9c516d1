"""Helpers of arrays."""

import numpy as np
import pytest

from frontage.geometry.arrays import distinct, drawn


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
