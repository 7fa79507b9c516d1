"""Checks for the tests of any room: Jacobians against differences, invariance to motions of the world."""

from collections.abc import Callable

import numpy as np

from frontage.geometry.arrays import Float


def numeric_jacobian(function: Callable[[Float], Float], at: Float, step: float = 1e-6) -> Float:
    """Returns the Jacobian (m, p) of `function` (p,) -> (m,) at `at` by central differences."""
    columns = [(function(at + e) - function(at - e)) / (2 * step) for e in np.eye(len(at)) * step]
    return np.stack(columns, axis=-1)


def assert_jacobian(
    function: Callable[[Float], Float], jacobian: Float, at: Float, step: float = 1e-6, rtol: float = 1e-5
) -> None:
    """Asserts that `jacobian` (m, p) agrees with central differences to `rtol` of its largest entry."""
    numeric = numeric_jacobian(function, at, step)
    assert np.abs(jacobian - numeric).max() <= rtol * max(np.abs(numeric).max(), 1e-12)


def world_motion(azimuth: float, shift: tuple[float, float, float]) -> tuple[Float, Float]:
    """Returns a rotation (3, 3) by `azimuth` rad about the vertical and a translation (3,) m."""
    c, s = np.cos(azimuth), np.sin(azimuth)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), np.asarray(shift, np.float64)


def assert_invariant(measure: Callable[[Float], Float], xyz: Float, tolerance: float) -> None:
    """Asserts that `measure` (n, 3) -> (k,) keeps its values when the points are turned about the vertical
    and shifted."""
    here = measure(xyz)
    for azimuth, shift in ((0.7, (12.0, -7.0, 3.0)), (3.9, (-250.0, 431.0, 80.0))):
        R, t = world_motion(azimuth, shift)
        assert np.abs(measure(xyz @ R.T + t) - here).max() <= tolerance
