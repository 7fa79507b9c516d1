"""Metrics with 95 % intervals, by bootstrap over the items that they were computed from."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from frontage.geometry.arrays import Array, Float

_DRAWS = 1000
_LEVEL = 0.95
_CHUNK = 4_000_000  # values drawn at once, which limits the memory to about 32 MB

Statistic = Callable[[Array], Array]
"""Maps drawn items (b, n) or (b, n, k) to one value per draw (b,)."""


@dataclass(frozen=True)
class Metric:
    """A value with its 95 % interval, the number of items behind it, and its unit.

    `value` is None when there are no items; `low` and `high` are None with fewer than two.
    """

    value: float | None
    low: float | None
    high: float | None
    n: int
    unit: str = ""


@dataclass(frozen=True)
class ScorePart:
    """The score of one part of a result: metrics by name, one row per item for inspection, and notes."""

    figures: Mapping[str, Metric]
    items: tuple[Mapping[str, Any], ...] = field(default=())
    notes: tuple[str, ...] = field(default=())


@dataclass(frozen=True)
class Absent:
    """A part that could not be scored because the result does not contain it, and the reason."""

    reason: str


def metric(items: Array, statistic: Statistic, unit: str = "", seed: int = 0) -> Metric:
    """Computes a statistic of items (n,) or (n, k) with its percentile bootstrap interval (Efron 1979).

    Items are drawn with replacement 1000 times; draws whose statistic is not finite are ignored.
    """
    items = np.asarray(items, np.float64)
    n = len(items)
    if n == 0:
        return Metric(None, None, None, 0, unit)
    value = float(statistic(items[None])[0])
    if not np.isfinite(value):
        return Metric(None, None, None, n, unit)
    if n == 1:
        return Metric(value, None, None, 1, unit)
    rng = np.random.default_rng(seed)
    rows = max(1, _CHUNK // items.size)
    drawn: list[Float] = []
    for start in range(0, _DRAWS, rows):
        index = rng.integers(0, n, (min(rows, _DRAWS - start), n))
        drawn.append(np.asarray(statistic(items[index]), np.float64))
    draws = np.concatenate(drawn)
    draws = draws[np.isfinite(draws)]
    tail = (1 - _LEVEL) / 2
    low, high = (float(v) for v in np.quantile(draws, [tail, 1 - tail])) if len(draws) else (value, value)
    return Metric(value, low, high, n, unit)


def median(items: Array) -> Array:
    """Median of every draw."""
    return np.asarray(np.median(items, axis=1))


def mean(items: Array) -> Array:
    """Mean of every draw."""
    return np.asarray(items.mean(axis=1))


def rms(items: Array) -> Array:
    """Root mean square of every draw."""
    return np.asarray(np.sqrt((items**2).mean(axis=1)))


def p95(items: Array) -> Array:
    """The 95th percentile of every draw."""
    return np.asarray(np.quantile(items, 0.95, axis=1))


def within(items: Array, bound: float) -> Array:
    """Share of the items of every draw whose absolute value is at most `bound`."""
    return np.asarray((np.abs(items) <= bound).mean(axis=1))


def detection(items: Array, which: str) -> Array:
    """Precision, recall or F1 ("f1") of items (b, n, 3): found and true, found but not true, missed."""
    hit, extra, missed = (items[..., k].sum(axis=1) for k in range(3))
    below = {"precision": hit + extra, "recall": hit + missed, "f1": hit + (extra + missed) / 2}[which]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(hit / below)


def detections(items: Array, ending: str = "") -> dict[str, Metric]:
    """Precision, recall and F1 of items (n, 3) as metrics; `ending` is appended to their names."""
    return {
        f"{which}{ending}": metric(items, lambda v, w=which: detection(v, w))  # type: ignore[misc]
        for which in ("precision", "recall", "f1")
    }


def normalised(errors: Array, prefix: str, dof: int = 1) -> dict[str, Metric]:
    """Compares errors with the standard errors that were reported for them; realistic ones give 1 and 0.95.

    errors  (n,) error / sigma, or with dof > 1 the squared Mahalanobis distances (NEES, Bar-Shalom 2001)
    """
    from scipy.stats import chi2

    squared = np.asarray(errors, np.float64) ** (2 if dof == 1 else 1)
    limit = float(chi2.ppf(_LEVEL, dof))
    return {
        f"{prefix}_normalised": metric(squared, lambda v: np.sqrt(mean(v) / dof)),
        f"{prefix}_within_95": metric(squared, lambda v: within(v, limit)),
    }
