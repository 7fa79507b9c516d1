"""Variance components of the groups (Helmert, Foerstner) and the test of every observation (Baarda)."""

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int
from frontage.orientation.adjustment.covariance import Precision
from frontage.orientation.adjustment.layout import Layout
from frontage.orientation.adjustment.linearise import Linearised
from frontage.orientation.adjustment.network import Network
from frontage.orientation.adjustment.options import AdjustmentOptions
from frontage.orientation.adjustment.robust import limit_2d

_UNCONTROLLED = 0.02  # redundancy below which the residual of an observation says nothing about its error
_POWER = 0.84  # sigmas: a bias this far beyond the critical value is found with a probability of 80 %
_LEAST_FACTOR, _MOST_FACTOR = 1e-8, 1e8


def group_redundancies(network: Network, layout: Layout, precision: Precision) -> Float:
    """The sum (g,) of the redundancies of the observations of every group."""
    images = np.bincount(
        network.images.group[layout.rows], np.einsum("mii->m", precision.images), network.groups
    )
    surfaces = np.bincount(network.surfaces.group[layout.surface_rows], precision.surfaces, network.groups)
    return np.asarray(images + surfaces, np.float64)


def variance_ratios(network: Network, layout: Layout, rows: Linearised, precision: Precision) -> Float:
    """By how much the variance (g,) of every group differs from the one in the weights: v'Pv / redundancy."""
    images = np.bincount(network.images.group[layout.rows], (rows.miss**2).sum(axis=1), network.groups)
    surfaces = np.bincount(network.surfaces.group[layout.surface_rows], rows.surface_miss**2, network.groups)
    redundancy = group_redundancies(network, layout, precision)
    return np.asarray((images + surfaces) / np.maximum(redundancy, 1e-12), np.float64)


def next_factors(factors: Float, ratios: Float, redundancies: Float, options: AdjustmentOptions) -> Float:
    """The variance factors (g,) for the next round; the same where they no longer change.

    Groups whose redundancy is too small keep their stated variances.
    """
    if not options.variance_components:
        return factors
    large = (redundancies >= options.least_redundancy) & options.estimates(len(factors))
    # A tenth of the standard error of a factor is no change that matters.
    rest = np.abs(ratios - 1.0) <= 0.005 + 0.1 * np.sqrt(2.0 / np.maximum(redundancies, 1.0))
    updated = np.where(rest, factors, np.clip(factors * ratios, _LEAST_FACTOR, _MOST_FACTOR))
    return np.where(large, updated, 1.0)


def failed_tests(
    network: Network, layout: Layout, rows: Linearised, precision: Precision, ratios: Float, critical: float
) -> tuple[Int, Int]:
    """Image rows and surface rows that fail their test and are the worst of their photo and of their point.

    Errors of one observation spread over its neighbours, so only the worst is removed at a time. `ratios`
    (g,) divide the variances of the groups.
    """
    image_group = network.images.group[layout.rows]
    surface_group = network.surfaces.group[layout.surface_rows]
    score = np.concatenate(
        [
            _image_scores(rows, precision, critical) / ratios[image_group],
            _surface_scores(rows, precision, critical) / ratios[surface_group],
        ]
    )
    family = np.concatenate([layout.photo, len(network.photos) + surface_group])
    point = np.concatenate([layout.slot, layout.surface_slot])
    worst = _worst(score, family) & _worst(score, point) & (score > 1.0)
    count = len(layout.rows)
    return layout.rows[worst[:count]], layout.surface_rows[worst[count:]]


def _image_scores(rows: Linearised, precision: Precision, critical: float) -> Float:
    """Test values (m_a,) of the residual vectors over their critical values, squared."""
    size, axes = np.linalg.eigh(precision.images)
    along = np.einsum("mij,mi->mj", axes, rows.miss) ** 2
    tested = size > _UNCONTROLLED
    value = np.where(tested, along / np.where(tested, size, 1.0), 0.0).sum(axis=1)
    limit = np.array([np.inf, critical**2, limit_2d(critical) ** 2])[tested.sum(axis=1)]
    return np.asarray(value / limit, np.float64)


def _surface_scores(rows: Linearised, precision: Precision, critical: float) -> Float:
    tested = precision.surfaces > _UNCONTROLLED
    safe = np.where(tested, precision.surfaces, 1.0)
    return np.asarray(np.where(tested, rows.surface_miss**2 / safe, 0.0) / critical**2, np.float64)


def _worst(score: Float, family: Int) -> Bool:
    """Marks the row with the highest score of every family."""
    order = np.lexsort((-score, family))
    first = np.ones(len(order), bool)
    first[1:] = family[order][1:] != family[order][:-1]
    marked = np.zeros(len(score), bool)
    marked[order[first]] = True
    return marked


def detectable_bias(redundancy: Float, sigma: Float, critical: float) -> Float:
    """The least bias that the test finds in 80 of 100 cases, in the unit of `sigma`; inf where none."""
    controlled = redundancy > _UNCONTROLLED
    safe = np.sqrt(np.where(controlled, redundancy, 1.0))
    return np.where(controlled, (critical + _POWER) * sigma / safe, np.inf)
