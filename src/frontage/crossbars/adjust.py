"""Places the bars of a window by least squares, from the edges that every view shows of them.

Unknown are the centre and the width of every bar, the depth of their plane, how far each stands off that
plane, and by how much each view is displaced because of its pose. What a bar shows of its side face adds to
the edge that is turned towards the camera. The standard errors follow from the normal equations, scaled by
what the residuals tell.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.crossbars.division import Line
from frontage.crossbars.readings import Readings
from frontage.geometry.arrays import Array, Float
from frontage.model import Estimate

_EDGE_PX = 0.3  # standard error of an edge in one view, px of the photo
_EDGE_M = 0.001  # and of the edge itself: bars are not ideal prisms
_SIDE_M = (0.010, 0.008)  # depth of a bar's side face that its edge turned to the camera includes, and spread
_TURNED_M = 0.006  # by which that differs from edge to edge
_OFF_M = 0.01  # by which bars stand off their common plane: posts, casements, glazing bars
_WIDTH_M = 0.01  # by which the width may differ from the one that the layout was chosen with
_PLACE_M = 0.05
_POSE_M = 0.0005  # least displacement of a view
_PRIOR_DOF = 8.0  # how much the standard error of an edge is known beforehand
_ROBUST = 2.0  # standard errors from which a reading counts less
_ROUNDS = 8


@dataclass(frozen=True, eq=False)
class Adjusted:
    """Bars in their places with standard errors m of position and width, and the depth of their plane."""

    lines: tuple[Line, ...]
    sigma: Float
    sigma_width: Float
    depth: Estimate[float]


@dataclass(frozen=True, eq=False)
class Shown:
    """How views show a window, across x and across z.

    tilt, gsd, pose  (v, 2), see `WallView`; m per px; m by which their poses err
    """

    tilt: Float
    gsd: Float
    pose: Float


@dataclass(frozen=True)
class Known:
    """The depth m of the bars behind the wall and its standard error, before their edges were read."""

    depth: float
    sigma: float


def adjust(lines: Sequence[Line], readings: Readings, views: Shown, depth: float, known: Known) -> Adjusted:
    """Returns bars as the views show them.

    readings  of the lines, on a plane at `depth` m
    """
    n = len(lines)
    axis = np.array([line.axis for line in lines])[readings.bar]
    tilt = views.tilt[readings.view, axis]
    turned = tilt * readings.side < 0  # edges on the side of a bar that the camera sees
    columns = (
        _indicator(readings.bar, n),
        _indicator(readings.bar, n) * (0.5 * readings.side[:, None]),
        _indicator(readings.bar, n) * -tilt[:, None],
        np.stack([-tilt, -tilt * turned], axis=1),
        _indicator(2 * readings.view + axis, 2 * len(views.tilt)),
    )
    places, widths = ([getattr(line, name) for line in lines] for name in ("position", "width"))
    mean = np.concatenate(
        [places, widths, np.zeros(n), [known.depth - depth, _SIDE_M[0]], np.zeros(2 * len(views.tilt))]
    )
    spread = np.concatenate(
        [
            np.repeat([_PLACE_M, _WIDTH_M, _OFF_M], n),
            [known.sigma, _SIDE_M[1]],
            np.maximum(views.pose, _POSE_M).ravel(),
        ]
    )
    px = views.gsd[readings.view, axis]
    sigma = np.sqrt((_EDGE_PX * px) ** 2 + _EDGE_M**2 + turned * (_TURNED_M * tilt) ** 2)
    x, covariance = _solved(np.hstack(columns), readings.at, sigma, mean, spread)
    error = np.sqrt(np.diag(covariance))
    placed = tuple(
        replace(line, position=float(c), width=float(w))
        for line, c, w in zip(lines, x[:n], x[n : 2 * n], strict=True)
    )
    found = Estimate(depth + float(x[3 * n]), covariance[3 * n, 3 * n, None, None], float(len(axis)))
    return Adjusted(placed, error[:n], error[n : 2 * n], found)


def _indicator(number: Array, count: int) -> Float:
    """Returns rows (m, count) with a one at the number of each."""
    return np.asarray(number[:, None] == np.arange(count)[None, :], np.float64)


def _solved(A: Float, at: Float, sigma: Float, mean: Float, spread: Float) -> tuple[Float, Float]:
    """Returns the unknowns and their covariance, by reweighted least squares about what is known before.

    The readings are as good as their residuals tell, as far as there are enough of them; displacements of
    views and what is known before keep their standard errors.
    """
    prior = np.diag(1.0 / spread**2)
    weight: Array = np.ones(len(at))
    scale, x = 1.0, mean
    inverse: Array = np.diag(spread**2)
    for _ in range(_ROUNDS if len(at) else 0):
        W = weight / (scale * sigma**2)
        inverse = np.linalg.inv(A.T @ (W[:, None] * A) + prior)
        x = mean + inverse @ (A.T @ (W * (at - A @ mean)))
        r = (at - A @ x) / sigma
        free = float(weight.sum() - np.einsum("ij,ij,i->", A @ inverse, A, W))
        scale = (_PRIOR_DOF + float(weight @ r**2)) / (_PRIOR_DOF + max(free, 0.0))
        weight = 1.0 / (1.0 + r**2 / (scale * _ROBUST**2))
    return x, inverse
