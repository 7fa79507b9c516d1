"""One LO-RANSAC for every minimal problem of the project.

Fischler and Bolles (1981) with the truncated quadratic score of MSAC (Torr and Zisserman 2000), the
local optimisation of Chum, Matas and Kittler (2003) and hypotheses scored in blocks: a block of
hypotheses against a subset of the rows is one matrix, so no early-out test is needed.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int


class Estimator(Protocol):
    """A minimal problem over `n` rows of data, which the estimator itself holds."""

    sample_size: int

    def __len__(self) -> int:
        """Number of rows n."""

    def draw(self, rng: np.random.Generator, count: int) -> Int:
        """(count, sample_size) int64 rows of minimal samples."""

    def minimal(self, samples: Int) -> Float:
        """Models (j, p) through the samples (k, sample_size); degenerate samples are dropped."""

    def residuals(self, models: Float, rows: Int | slice) -> Array:
        """Signed or absolute residuals (j, r), float32 or float64, of the models (j, p) at `rows`."""

    def fit(self, rows: Int, weights: Float) -> Float | None:
        """Weighted least-squares model (p,) of many rows, or None when they are degenerate."""


@dataclass(frozen=True, eq=False)
class Consensus:
    """The best model (p,), its inlier mask (n,), its MSAC score per unit weight (0 best,
    1 worst) and the work done.
    """

    model: Float
    inliers: Bool
    score: float
    share: float
    hypotheses: int


def needed_hypotheses(share: float, sample_size: int, confidence: float) -> float:
    """Samples after which an all-inlier one was drawn with `confidence`: ln(1 - eta) / ln(1 - w^m)."""
    good = min(max(share, 1e-9) ** sample_size, 1 - 1e-12)
    return float(np.log1p(-confidence) / np.log1p(-good))


def lo_ransac(
    estimator: Estimator,
    threshold: float,
    rng: np.random.Generator,
    *,
    weights: Float | None = None,
    confidence: float = 0.99,
    max_hypotheses: int = 2048,
    score_rows: int = 2500,
    verify_rows: int = 20_000,
    keep: int = 10,
    block: int = 128,
) -> Consensus | None:
    """The model with the lowest truncated quadratic score ``sum w min(r^2, T^2)``.

    Hypotheses are scored in blocks on `score_rows` random rows; the `keep` best are scored on `verify_rows`
    and the better half is improved by three least-squares fits on its own inliers with a shrinking
    threshold. The inliers are of all rows.

    threshold  T, in the unit of the residuals
    weights    (n,) non-negative weights of the rows (for instance the area each stands for)

    Returns None when no sample gave a model.
    """
    n = len(estimator)
    if n < estimator.sample_size:
        return None
    weight = np.ones(n, np.float32) if weights is None else np.asarray(weights, np.float32)
    verify = rng.permutation(n)[:verify_rows]
    rows = verify[:score_rows]
    models, tried = _sample(
        estimator, rows, weight[rows], threshold, rng, confidence, max_hypotheses, keep, block
    )
    if not models.size:
        return None
    model, score = _optimise(estimator, models, verify, weight[verify], threshold)
    inliers = np.abs(estimator.residuals(model[None], slice(None))[0]) < threshold
    share = float(weight[inliers].sum() / weight.sum())
    return Consensus(model, inliers, score, share, tried)


def _sample(
    estimator: Estimator,
    rows: Int,
    weight: Array,
    threshold: float,
    rng: np.random.Generator,
    confidence: float,
    most: int,
    keep: int,
    block: int,
) -> tuple[Float, int]:
    """The `keep` best models (j, p) of blocks of minimal samples, best first, and how many were tried."""
    models, scores = np.empty((0, 0)), np.empty(0)
    tried, needed = 0, float(block)
    while tried < min(needed, most):
        tried += block
        fresh = estimator.minimal(estimator.draw(rng, block))
        if len(fresh) == 0:
            continue
        got, shares = _score(estimator, fresh, rows, weight, threshold)
        models = np.vstack([models, fresh]) if models.size else fresh
        scores = np.concatenate([scores, got])
        best = np.argsort(scores, kind="stable")[:keep]
        if best[0] >= len(scores) - len(got):
            share = float(shares[best[0] - (len(scores) - len(got))])
            needed = needed_hypotheses(share, estimator.sample_size, confidence)
        models, scores = models[best], scores[best]
    return models, tried


def _score(
    estimator: Estimator, models: Float, rows: Int | slice, weight: Array, threshold: float
) -> tuple[Float, Float]:
    """MSAC scores (j,) and inlier weight shares (j,), both per unit weight."""
    squared = estimator.residuals(models, rows) / np.float32(threshold)
    squared *= squared
    total = float(weight.sum(dtype=np.float64))
    share = (squared < 1.0).astype(np.float32) @ weight / total
    np.minimum(squared, 1.0, out=squared)
    return (squared @ weight / total).astype(np.float64), share.astype(np.float64)


def _optimise(
    estimator: Estimator, models: Float, rows: Int, weight: Array, threshold: float
) -> tuple[Float, float]:
    """The best model and its score on `rows`, of those kept and their refits; weight (r,) of the rows."""
    best_model, best_score = models[0], np.inf
    ranked, _ = _score(estimator, models, rows, weight, threshold)
    total = float(weight.sum(dtype=np.float64))
    # several of the kept are the same structure: the half that is best on more rows is worth a refit
    for start in models[np.argsort(ranked, kind="stable")[: (len(models) + 1) // 2]]:
        model = start
        for factor in (3.0, 1.5, 1.0, 0.0):
            squared = (estimator.residuals(model[None], rows)[0] / np.float32(threshold)) ** 2
            score = float(np.minimum(squared, 1.0) @ weight / total)
            if score < best_score:
                best_model, best_score = model, score
            near = np.flatnonzero(squared < factor**2)
            if len(near) <= estimator.sample_size:
                break
            refitted = estimator.fit(rows[near], weight[near].astype(np.float64))
            if refitted is None:
                break
            model = refitted
    return best_model, best_score
