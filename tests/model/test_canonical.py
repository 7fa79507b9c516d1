"""The canonical view of a cloud: what its points decide, and what their order and direction do not."""

import numpy as np
import pytest

from frontage.model import Scan, WorldRef
from frontage.model.canonical import canonical_view


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
def test_order_direction_and_handedness_do_not_change_the_view(axes: np.ndarray) -> None:
    scan = cloud()
    order = np.random.default_rng(1).permutation(len(scan))
    view, other = canonical_view(scan), canonical_view(changed(scan, axes, order))
    assert np.abs(view.scan.xyz - other.scan.xyz).max() < 2e-6
    assert np.abs(view.scan.origins - other.scan.origins).max() < 1e-9
    assert view.mirrored == (other.mirrored ^ bool(np.linalg.det(axes) < 0))
    assert np.abs(scan.xyz[view.order] - scan.xyz[order[other.order]]).max() < 2e-6


def test_rows_name_the_same_points() -> None:
    scan = cloud()
    view = canonical_view(scan)
    index = np.array([7, 300, 4])
    assert sorted(view.order[view.rows(index)]) == [4, 7, 300]
    back = view.scan.xyz @ view.axes.T
    assert np.abs(back - scan.xyz[view.order]).max() < 1e-5
    assert np.array_equal(view.scan.intensity, scan.intensity[view.order])


def test_no_wall_runs_along_the_axes() -> None:
    scan = cloud()
    along = canonical_view(scan).axes.T @ np.array([1.0, 0.0, 0.0])
    assert np.abs(along[:2]).min() > 0.3
