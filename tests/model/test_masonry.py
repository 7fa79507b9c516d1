"""The shared assumptions: consistent with each other, and frozen."""

from dataclasses import FrozenInstanceError, asdict

import numpy as np
import pytest

from frontage.model.masonry import MASONRY, TOLERANCES


def test_sizes_are_those_of_masonry():
    assert all(value > 0 for value in asdict(MASONRY).values())
    assert MASONRY.half_brick < MASONRY.relief < MASONRY.facade_reach
    assert MASONRY.person < MASONRY.door_height < MASONRY.room_height


def test_walls_are_parallel_within_their_tolerance():
    assert np.degrees(np.arccos(TOLERANCES.parallel_cos)) == pytest.approx(TOLERANCES.parallel_deg)


def test_assumptions_cannot_be_changed_in_passing():
    with pytest.raises(FrozenInstanceError):
        MASONRY.half_brick = 0.2  # type: ignore[misc]
