"""Whether the confidence in window bars is a probability: fitted on some houses, checked on others."""

from collections.abc import Sequence

import numpy as np

from _barscore import Judged, reliability
from _common import table
from frontage.crossbars import judge as inforce

_NATS = np.arange(2.0, 40.1, 0.5)
_DESCRIBED = np.arange(0.70, 0.996, 0.005)


def confidence_tables(judged: Sequence[Judged], houses: Sequence[str]) -> None:
    """Print both figures of `judge.probability` as fitted to each half of the houses, and reliability tables.

    Windows that are left undecided are not among them: what would have been chosen is not told.
    """
    decided = [j for j in judged if j.exact is not None and j.resolved and j.confidence > 0]
    halves = [
        [j for j in decided if (j.case in houses[: len(houses) // 2]) == first] for first in (True, False)
    ]
    names = (f"{houses[0]} to {houses[len(houses) // 2 - 1]}", f"{houses[len(houses) // 2]} to {houses[-1]}")
    rows = []
    for name, own, other in zip(names, halves, halves[::-1], strict=True):
        if min(len(own), len(other)) < 10:
            return
        fit = fitted(own)
        rows.append([f"fitted to {name}", *_row(fit, own), *_row(fit, other)[2:]])
    force = (inforce._DESCRIBED, inforce._NATS)
    rows.append(["in force, both halves", *_row(force, decided), "-", "-"])
    header = ("figures", "described", "nats", "score there", "base there", "score on the others", "base")
    table("Confidence: mean negative logarithm of the probability given to what came out", header, rows)
    for name, own in zip(names, halves, strict=True):
        table(f"Confidence of ours, {name}", ("confidence", "windows", "mean", "exact"), reliability(own))


def fitted(judged: Sequence[Judged]) -> tuple[float, float]:
    """The figures (described, nats) that give what came out the highest probability."""
    margin, exact = _margins(judged)
    grid = [(d, n) for d in _DESCRIBED for n in _NATS]
    return min(grid, key=lambda pair: _score(pair, margin, exact))


def _row(pair: tuple[float, float], judged: Sequence[Judged]) -> list[str]:
    margin, exact = _margins(judged)
    share = exact.mean()
    base = -float(np.mean(np.log(np.where(exact, share, 1 - share))))
    return [f"{pair[0]:.3f}", f"{pair[1]:.1f}", f"{_score(pair, margin, exact):.3f}", f"{base:.3f}"]


def _score(pair: tuple[float, float], margin: np.ndarray, exact: np.ndarray) -> float:
    p = pair[0] / (1.0 + np.exp(-margin / pair[1]))
    return -float(np.mean(np.log(np.where(exact, p, 1 - p))))


def _margins(judged: Sequence[Judged]) -> tuple[np.ndarray, np.ndarray]:
    """Margins in nats, from the confidences, and whether the layouts are right."""
    share = np.array([j.confidence for j in judged]) / inforce._DESCRIBED
    share = np.clip(share, 1e-9, 1 - 1e-9)
    return inforce._NATS * np.log(share / (1 - share)), np.array([bool(j.exact) for j in judged])
