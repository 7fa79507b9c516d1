"""Levenberg-Marquardt steps on the reduced normal equations."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy import linalg

from frontage.geometry.arrays import Float
from frontage.orientation.adjustment.datum import Datum, datum_of
from frontage.orientation.adjustment.layout import Layout
from frontage.orientation.adjustment.linearise import (
    Residuals,
    Weights,
    camera_prior_rows,
    linearise,
    mount_prior_rows,
    prior_rows,
    residuals,
)
from frontage.orientation.adjustment.network import Network
from frontage.orientation.adjustment.normal import NormalEquations, inverse_blocks, normal_equations
from frontage.orientation.adjustment.state import State

FIRST_DAMPING = 1e-4
LEAST_DAMPING = 1e-9
_MOST_DAMPING = 1e8
_UNDAMPED = 1e-7
_LEAST_MISSED = 1e-3  # share of its promise that a step may miss without showing it, by coincidence
_AT_REST = 1e-7  # expected decrease of the cost, in squared sigmas, per square root of the number of unknowns
_UNSEEN_COST = 1e6  # squared sigmas of an image point that its camera cannot see

Reweight = Callable[[Residuals], tuple[Weights, float]]
"""Gives the weights of a robust loss at residuals, and the cost of all observations under that loss."""


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where a minimisation ended: the state, its residuals and weights, the cost, the steps and why."""

    state: State
    residuals: Residuals
    weights: Weights
    cost: float
    iterations: int
    reason: str


def minimise(
    network: Network,
    start: State,
    layout: Layout,
    reweight: Reweight,
    *,
    most: int,
    damping: float = LEAST_DAMPING,
    early: float = 1.0,
) -> Minimum:
    """Minimises the weighted squares in `most` steps; `early` > 1 stops so many times earlier."""
    now = _evaluate(network, start, reweight)
    goal = early * _AT_REST * np.sqrt(layout.columns + 3 * len(layout.points))
    for step in range(1, most + 1):
        rows = linearise(network, now.state, layout, now.weights, now.residuals)
        equations = normal_equations(layout, rows)
        datum = datum_of(network, now.state, layout, rows)
        new, expected, damping = _try(network, now, equations, datum, reweight, damping, goal)
        rest = _next_decrease(now.cost - new.cost, expected, damping)
        now = replace(new if new.cost < now.cost else now, iterations=step)
        if rest <= goal:
            return replace(now, reason="converged: the corrections are negligible against their sigmas")
        if damping >= _MOST_DAMPING:
            return replace(now, reason="no step lowers the cost")
        damping = max(damping / 30.0, LEAST_DAMPING)
    return replace(now, reason=f"{most} iterations")


def _try(
    network: Network,
    now: Minimum,
    equations: NormalEquations,
    datum: Datum,
    reweight: Reweight,
    damping: float,
    goal: float,
) -> tuple[Minimum, float, float]:
    """Raises the damping until a step lowers the cost; returns its end, its promise, the damping."""
    while True:
        wide, points, expected = _solve(equations, datum, damping)
        new = _evaluate(network, _moved(now.state, equations.layout, wide, points), reweight)
        at_rest = expected <= goal and damping <= FIRST_DAMPING
        if at_rest or new.cost < now.cost or damping >= _MOST_DAMPING:
            return new, expected, damping
        damping *= 10.0


def _next_decrease(actual: float, expected: float, damping: float) -> float:
    """The decrease of the cost that the step after this one would promise.

    A step of Gauss and Newton that misses its promise by the share r leaves about r^2 of it to the next one.
    A damped step may leave as much again in weak directions.
    """
    if damping > FIRST_DAMPING:
        return np.inf
    if damping > _UNDAMPED or expected <= 0.0:
        return expected
    missed = abs(actual / expected - 1.0)
    return expected * float(np.clip(missed, _LEAST_MISSED, 1.0)) ** 2


def _evaluate(network: Network, state: State, reweight: Reweight) -> Minimum:
    at = residuals(network, state)
    weights, cost = reweight(at)
    cost += sum(float(p[1] @ p[1]) for p in prior_rows(network, state) if p is not None)
    miss = np.concatenate([camera_prior_rows(network, state)[1], mount_prior_rows(network, state)[1]])
    return Minimum(state, at, weights, cost + float(miss @ miss), 0, "")


def squared(layout: Layout, at: Residuals, weights: Weights) -> Float:
    """Squared residuals (m_a + k_a,) of the rows of a layout in sigmas, those of unseen points constant."""
    images = (at.images[layout.rows] ** 2).sum(axis=1) * weights.images[layout.rows] ** 2
    images = np.where(np.isfinite(images), images, _UNSEEN_COST)
    surfaces = (at.surfaces[layout.surface_rows] * weights.surfaces[layout.surface_rows]) ** 2
    return np.concatenate([images, surfaces])


def _solve(equations: NormalEquations, datum: Datum, damping: float) -> tuple[Float, Float, float]:
    """The corrections (u,) and (a, 3), and the decrease of the squared sigmas that they promise."""
    inverse = inverse_blocks(equations.V, damping)
    diagonal = np.diag(equations.U)
    U = equations.U + np.diag(damping * diagonal + (diagonal == 0))
    S, right = equations.reduce(inverse, U)
    scale = 1.0 / np.sqrt(np.diag(U))
    held = np.linalg.qr(datum.constraints * scale[:, None])[0]
    scaled = S * scale[:, None] * scale + held @ held.T
    scaled[np.diag_indices_from(scaled)] += 1e-14
    wide = np.asarray(linalg.solve(scaled, right * scale, assume_a="sym"), np.float64) * scale
    points = equations.back_substitute(inverse, wide)
    gain = -float(equations.wide_gradient @ wide) - float((equations.point_gradient * points).sum())
    return wide, points, gain


def _moved(state: State, layout: Layout, wide: Float, points: Float) -> State:
    parameters = []
    for i, camera in enumerate(state.cameras):
        change = np.zeros(len(camera.params))
        change[layout.free[i]] = wide[layout.camera_columns(i)]
        parameters.append(change)
    bodies = wide[: 6 * layout.bodies].reshape(-1, 6)
    mounts = np.zeros((len(layout.mounted), 6))
    for i, free in enumerate(layout.mounted):
        mounts[i, free] = wide[layout.mount_columns(i)]
    return state.moved(bodies, tuple(parameters), mounts, layout.points, points)
