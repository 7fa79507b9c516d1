"""Rotations: quaternions there and back, angles to the last digit."""

import numpy as np
import pytest

from frontage.geometry.rigid import (
    Rigid3,
    quaternion_from_rotation,
    rotation_angle,
    rotation_from_quaternion,
)


def about(axis: np.ndarray, angle: float) -> np.ndarray:
    half = angle / 2
    return rotation_from_quaternion(np.array([np.cos(half), *(np.sin(half) * axis / np.linalg.norm(axis))]))


def test_quaternions_come_back_as_the_same_rotation() -> None:
    rng = np.random.default_rng(0)
    special = [np.eye(3), np.diag([1.0, -1, -1]), np.diag([-1.0, 1, -1]), np.diag([-1.0, -1, 1])]
    for R in [*special, *(rotation_from_quaternion(rng.normal(size=4)) for _ in range(200))]:
        q = quaternion_from_rotation(R)
        assert q[0] >= 0 and abs(np.linalg.norm(q) - 1) < 1e-12
        assert np.abs(rotation_from_quaternion(q) - R).max() < 1e-12


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 0.3, 2.0, np.pi - 1e-6, np.pi])
def test_angles_keep_their_digits(angle: float) -> None:
    R = about(np.array([0.3, -0.5, 0.8]), angle)
    assert rotation_angle(R) == pytest.approx(angle, rel=1e-6, abs=1e-15)


def test_a_correction_comes_after_what_it_corrects() -> None:
    a = Rigid3("local", "given", about(np.array([0.1, 0.2, 1.0]), 0.4), np.array([5.0, 2.0, -1.0]))
    b = Rigid3("local", "scanner", about(np.array([1.0, 0.2, 0.0]), -1.1), np.array([0.5, 0.0, 3.0]))
    xyz = np.random.default_rng(0).normal(size=(5, 3))
    both = a.after(b)
    assert (both.to, both.frm) == ("local", "scanner")
    np.testing.assert_allclose(both.apply(xyz), a.apply(b.apply(xyz)), atol=1e-12)
