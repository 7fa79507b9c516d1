"""The bundle adjustment: a robust phase, then rounds of least squares, tests and variance components."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.orientation.adjustment.assemble import assemble
from frontage.orientation.adjustment.covariance import degenerate_points, precision
from frontage.orientation.adjustment.datum import datum_of
from frontage.orientation.adjustment.dependence import Dependence
from frontage.orientation.adjustment.dependent import alike_groups, dependent_precision, effective_weights
from frontage.orientation.adjustment.fit import Fit
from frontage.orientation.adjustment.layout import Layout, determined_points, layout_of
from frontage.orientation.adjustment.linearise import (
    camera_points,
    linearise,
    point_derivatives,
    residuals,
)
from frontage.orientation.adjustment.minimise import FIRST_DAMPING, LEAST_DAMPING, Minimum, Reweight, minimise
from frontage.orientation.adjustment.network import Network
from frontage.orientation.adjustment.normal import normal_equations, point_blocks
from frontage.orientation.adjustment.options import AdjustmentOptions
from frontage.orientation.adjustment.readmit import agreeing
from frontage.orientation.adjustment.reliability import (
    failed_tests,
    group_redundancies,
    next_factors,
    variance_ratios,
)
from frontage.orientation.adjustment.result import Adjustment
from frontage.orientation.adjustment.robust import least_squares, plain_weights, robust, scales, within
from frontage.orientation.adjustment.state import State

# One stage each; only the first starts from poor approximate values.
_ROBUST_DAMPING = (FIRST_DAMPING, LEAST_DAMPING, LEAST_DAMPING)
_EARLY = 1e6  # by how much earlier than the last minimisation those of the robust phase may stop


@dataclass
class _Progress:
    """Where the adjustment stands: the state, observations still in use, variance factors, steps so far."""

    state: State
    images: Bool
    surfaces: Bool
    factors: Float
    iterations: int = 0


def adjust(
    network: Network, options: AdjustmentOptions | None = None, dependence: Dependence | None = None
) -> Adjustment:
    """Adjusts a network of photos by least squares.

    The robust phase removes gross errors; it is followed by rounds of least squares, in which the variances
    of the groups are estimated and the worst observation of every photo is removed if it fails its test,
    until nothing changes. Freedoms of the datum that no control fixes are removed by inner constraints.

    dependence  which errors are alike; the covariances of poses, cameras and points take it into account

    Raises NotDetermined, which names the bodies and cameras that the observations do not determine.
    """
    chosen = options or AdjustmentOptions()
    images, surfaces = np.ones(len(network.images), bool), np.ones(len(network.surfaces), bool)
    now = _Progress(State.of(network), images, surfaces, np.ones(network.groups))
    groups = range(network.groups)
    is_robust = any(chosen.loss_of(g) != "none" for g in groups)
    if is_robust:
        _robust_phase(network, now, chosen)
        if chosen.least_squares:
            _set_aside(network, now, chosen)
    for count in range(1, chosen.rounds + 1):
        fit = _fit(network, now, chosen, is_robust and not chosen.least_squares)
        # A removal in the last round would leave a result that does not belong to its observations.
        if count == chosen.rounds or not _revise(network, now, fit, chosen, count):
            break
    if dependence is not None:
        fit = _for_dependent_errors(network, now, fit, dependence, chosen)
    return assemble(network, fit, now.images, now.surfaces, now.iterations, count, chosen)


def _robust_phase(network: Network, now: _Progress, options: AdjustmentOptions) -> None:
    """Minimises the robust loss while its scale, taken from the residuals, shrinks."""
    layout = _lay_out(network, now)
    for damping in _ROBUST_DAMPING:
        now.factors = scales(network, layout, residuals(network, now.state), options)
        loss = robust(network, layout, now.factors, options)
        end = minimise(
            network, now.state, layout, loss, most=options.iterations, damping=damping, early=_EARLY
        )
        _take(now, end)
    estimated = scales(network, layout, residuals(network, now.state), options)
    now.factors = estimated if options.variance_components else np.ones(network.groups)


def _set_aside(network: Network, now: _Progress, options: AdjustmentOptions) -> None:
    """Puts observations with a robust loss aside that lie far outside."""
    layout = _lay_out(network, now)
    near = within(network, residuals(network, now.state), now.factors, options.critical)
    lossy = np.array([options.loss_of(g) != "none" for g in range(network.groups)])
    rows, others = layout.rows, layout.surface_rows
    now.images[rows] = near[0][rows] | ~lossy[network.images.group[rows]]
    now.surfaces[others] = near[1][others] | ~lossy[network.surfaces.group[others]]


def _fit(network: Network, now: _Progress, options: AdjustmentOptions, keep_robust: bool) -> Fit:
    """Minimises with the present observations and factors, and computes the precision."""
    layout = _lay_out(network, now)
    loss: Reweight = least_squares(layout, plain_weights(network, layout, now.factors))
    if keep_robust:
        loss = robust(network, layout, now.factors, options)
    return _fitted(network, now, layout, loss, options)


def _fitted(
    network: Network, now: _Progress, layout: Layout, loss: Reweight, options: AdjustmentOptions
) -> Fit:
    minimum = _take(now, minimise(network, now.state, layout, loss, most=options.iterations))
    rows = linearise(network, now.state, layout, minimum.weights, minimum.residuals)
    equations = normal_equations(layout, rows)
    datum = datum_of(network, now.state, layout, rows)
    return Fit(minimum, layout, equations, datum, precision(equations, datum), now.factors)


def _for_dependent_errors(
    network: Network, now: _Progress, fit: Fit, dependence: Dependence, options: AdjustmentOptions
) -> Fit:
    """Adjusts once more with weights for errors that are alike, and gives the covariances that hold for them.

    Tests, redundancies and the cost are those of the fit before: they are about single observations.
    """
    groups = alike_groups(network, fit, dependence)
    loss = least_squares(fit.layout, effective_weights(fit, groups))
    last = _fitted(network, now, fit.layout, loss, options)
    points, relief = fit.minimum.state.points, dependence.relief
    told = dependent_precision(last.equations, last.precision, points, groups, relief)
    kept = replace(fit.precision, wide=told.wide, points=told.points)
    return replace(last, minimum=replace(last.minimum, cost=fit.minimum.cost), precision=kept)


def _revise(network: Network, now: _Progress, fit: Fit, options: AdjustmentOptions, count: int) -> bool:
    """Updates the factors, removes what fails its test, readmits what was set aside; whether any changed."""
    ratios = variance_ratios(network, fit.layout, fit.rows, fit.precision)
    redundancies = group_redundancies(network, fit.layout, fit.precision)
    factors = next_factors(now.factors, ratios, redundancies, options)
    changed = bool((factors != now.factors).any())
    applied, now.factors = factors / now.factors, factors
    if options.snooping and options.least_squares:
        images, surfaces = failed_tests(
            network, fit.layout, fit.rows, fit.precision, applied, options.critical
        )
        changed |= bool(len(images) or len(surfaces))
        if count == 1 and not (now.images.all() and now.surfaces.all()):
            back = agreeing(network, fit, now.images, now.surfaces, factors, options.critical)
            changed |= bool(len(back[0]) or len(back[1]))
            now.images[back[0]], now.surfaces[back[1]] = True, True
        now.images[images], now.surfaces[surfaces] = False, False
    return changed | bool(np.isnan(fit.minimum.residuals.images[fit.layout.rows]).any())


def _take(now: _Progress, minimum: Minimum) -> Minimum:
    now.state = minimum.state
    now.iterations += minimum.iterations
    return minimum


def _lay_out(network: Network, now: _Progress) -> Layout:
    """Lays out the observations in use whose points are seen and determined."""
    at = residuals(network, now.state)
    images = now.images & np.isfinite(at.images).all(axis=1)
    points = determined_points(network, images, now.surfaces)
    layout = layout_of(network, images, now.surfaces, points)
    weak = _degenerate(network, now.state, layout)
    if not weak.any():
        return layout
    points[layout.points[weak]] = False
    return layout_of(network, images, now.surfaces, points)


def _degenerate(network: Network, state: State, layout: Layout) -> Bool:
    """The active points (a,) whose rays and rows leave a direction open."""
    rows = layout.rows
    xyz = camera_points(network, state, rows)
    by_ray = point_derivatives(network, state, rows, xyz) / network.images.sigma[rows, None, None]
    by_row = network.surfaces.direction / network.surfaces.sigma[:, None]
    nearest = np.full(len(layout.points), np.inf)
    np.minimum.at(nearest, layout.slot, np.linalg.norm(xyz, axis=1))
    return degenerate_points(point_blocks(layout, by_ray, by_row[layout.surface_rows]), nearest)
