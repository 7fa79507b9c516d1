"""Helpers of arrays."""

import numpy as np
import pytest

from frontage.geometry.arrays import distinct


@pytest.mark.parametrize("values", [[], [7], [3, 3, 3], [5, -2, 5, 0, -2, 9]])
def test_distinct_values_rise_and_come_once(values: list[int]) -> None:
    found = distinct(np.array(values, np.int64))
    assert found.tolist() == sorted(set(values))
