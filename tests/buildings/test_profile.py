"""The profile of a front tells where its face is."""

import numpy as np
import pytest

from frontage.buildings.fronts.leaves import FrontLeaves
from frontage.buildings.fronts.profile import BIN_M, FrontProfile
from frontage.buildings.fronts.signals import eaves, tracked_offset


def _profile(offset: np.ndarray) -> FrontProfile:
    """Returns a profile of which only the offset is measured."""
    n = len(offset)
    nothing, none = np.full(n, np.nan), np.zeros((n, 1))
    return FrontProfile(
        0.0, offset, nothing, nothing, np.full((n, 6), np.nan), nothing, none, none, 0.0, nothing
    )


@pytest.mark.parametrize("room", [[-2.0], [-2.0, np.nan], [-0.6, -2.0, -4.0]])
def test_a_door_that_shows_the_room_does_not_move_the_face_of_the_front(room: list[float]) -> None:
    offset = np.zeros(40)
    offset[20 : 20 + len(room)] = room
    at = np.linspace(0.0, 40 * BIN_M, 81)
    assert np.abs(_profile(offset).face_at(at)).max() < 1e-9


def test_a_part_of_the_front_that_is_set_back_keeps_its_own_face() -> None:
    offset = np.zeros(40)
    offset[20:30] = -2.0  # 2.5 m wide
    assert _profile(offset).face_at(np.array([25 * BIN_M]))[0] == pytest.approx(-2.0)


def test_what_stands_out_keeps_its_own_face() -> None:
    offset = np.zeros(40)
    offset[20:22] = 0.4
    assert _profile(offset).face_at(np.array([21 * BIN_M]))[0] == pytest.approx(0.4)


def test_a_front_without_any_measured_bin_lies_on_its_line() -> None:
    assert _profile(np.full(4, np.nan)).face_at(np.array([0.5])).tolist() == [0.0]


def test_an_entablature_before_a_recessed_wall_is_its_eaves() -> None:
    bin_, z = (a.ravel() for a in np.meshgrid(np.arange(12), np.arange(0.0, 10.0, 0.25)))
    recessed = (bin_ >= 4) & (bin_ < 8) & (z < 8.0)
    d = np.where(recessed, -1.1, 0.0)  # between columns, with the entablature above it
    at = FrontLeaves((bin_ + 0.5) * BIN_M, d, z, z, 0.25)
    rel = d - np.where((bin_ >= 4) & (bin_ < 8), -1.1, 0.0)
    assert np.allclose(eaves(bin_, at, rel, np.ones(len(z), bool), 12), 9.75)


def _leaves(bins: range, d: float, number: int) -> tuple[np.ndarray, np.ndarray]:
    """Returns the bins and the offsets m of so many leaves in each of the bins."""
    return np.repeat(np.array(bins), number), np.full(number * len(bins), d)


def _tracked(*parts: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Returns the offset of a front of 40 bins with the leaves of all parts."""
    return tracked_offset(*(np.concatenate(column) for column in zip(*parts, strict=True)), 40)


def test_the_wall_of_a_room_that_shows_more_than_the_front_before_it_is_not_the_front() -> None:
    front, room = _leaves(range(40), 0.05, 20), _leaves(range(10, 28), -4.5, 45)
    assert np.abs(_tracked(front, room)).max() < 0.15


def test_a_wide_recess_without_wall_before_it_is_followed() -> None:
    front = [_leaves(part, 0.05, 40) for part in (range(14), range(26, 40))]
    offset = _tracked(*front, _leaves(range(14, 26), -2.0, 40))
    assert np.abs(offset[16:24] + 2.0).max() < 0.15
    assert max(np.abs(offset[:12]).max(), np.abs(offset[28:]).max()) < 0.15


def test_a_wall_that_slants_from_the_line_of_its_front_is_followed() -> None:
    slant = [_leaves(range(k, k + 1), -0.05 * k, 40) for k in range(40)]
    assert np.abs(_tracked(*slant) + 0.05 * np.arange(40)).max() < 0.15
