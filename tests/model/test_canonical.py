"""The canonical frame and order of a cloud: its points decide them, their order and direction do not."""

import numpy as np
import pytest

from frontage.model import Scan, WorldRef
from frontage.model.canonical import canonical_axes, canonical_order, is_mirrored, turned


def cloud(n: int = 4000) -> Scan:
    """A corner of two walls with a sensor, a few points of which coincide."""
    rng = np.random.default_rng(5)
    xyz = np.column_stack([rng.gamma(2.0, 4.0, n), rng.normal(0, 0.01, n), rng.uniform(0, 9, n)])
    xyz[: n // 4, :2] = xyz[: n // 4, 1::-1] / 2
    xyz[-20:] = xyz[:20]
    return Scan(
        "corner",
        xyz,
        WorldRef(np.zeros(3)),
        np.array([[3.0, -9.0, 1.7]]),
        np.zeros(n, np.int32),
        intensity=rng.uniform(size=n).astype(np.float32),
    )


def changed(scan: Scan, axes: np.ndarray, order: np.ndarray) -> Scan:
    """The cloud turned or mirrored, in another order."""
    return Scan(
        "changed",
        (scan.xyz @ axes.T)[order],
        scan.world,
        scan.origins @ axes.T,
        scan.origin_index[order],
        intensity=scan.intensity[order],
    )


C, S = np.cos(0.7), np.sin(0.7)
TURN = np.array([[C, -S, 0.0], [S, C, 0.0], [0.0, 0.0, 1.0]])
MIRROR = np.diag([-1.0, 1.0, 1.0])


@pytest.mark.parametrize("axes", [np.eye(3), TURN, MIRROR, TURN @ MIRROR])
def test_order_direction_and_handedness_do_not_change_the_points(axes: np.ndarray) -> None:
    scan = cloud()
    shuffle = np.random.default_rng(1).permutation(len(scan))
    moved = changed(scan, axes, shuffle)
    frames = [canonical_axes(s.xyz) for s in (scan, moved)]
    one, other = (turned(s, frame) for s, frame in zip((scan, moved), frames, strict=True))
    orders = [canonical_order(s.xyz) for s in (one, other)]
    assert np.abs(one.xyz[orders[0]] - other.xyz[orders[1]]).max() < 2e-6
    assert np.abs(one.origins - other.origins).max() < 1e-9
    assert is_mirrored(frames[0]) == (is_mirrored(frames[1]) ^ bool(np.linalg.det(axes) < 0))
    assert np.abs(scan.xyz[orders[0]] - scan.xyz[shuffle[orders[1]]]).max() < 2e-6


def test_the_frame_is_orthogonal_and_keeps_the_plumb_line() -> None:
    scan = cloud()
    axes = canonical_axes(scan.xyz)
    assert np.allclose(axes @ axes.T, np.eye(3))
    assert axes[:, 2].tolist() == [0.0, 0.0, 1.0]
    assert np.abs(turned(scan, axes).xyz @ axes.T - scan.xyz).max() < 1e-5


def test_no_wall_runs_along_the_axes() -> None:
    along = canonical_axes(cloud().xyz).T @ np.array([1.0, 0.0, 0.0])
    assert np.abs(along[:2]).min() > 0.3


def test_points_of_one_voxel_follow_one_another() -> None:
    xyz = np.random.default_rng(0).uniform(0, 3, (5000, 3))
    step = np.linalg.norm(np.diff(xyz[canonical_order(xyz)], axis=0), axis=1)
    assert np.median(step) < 0.5 < np.median(np.linalg.norm(np.diff(xyz, axis=0), axis=1))
    assert len(canonical_order(np.empty((0, 3)))) == 0
