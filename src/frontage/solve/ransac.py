"""RANSAC with local optimisation, for every minimal problem of the project.

This is RANSAC (Fischler and Bolles 1981; paper A, section 2.1) with the truncated quadratic score of MSAC
(Torr and Zisserman 2000) and the local optimisation of Chum, Matas and Kittler (2003). Hypotheses are scored
in blocks: the residuals of a block on a subset of the rows form one matrix, so that no early-out test is
needed.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int


class Estimator(Protocol):
    """A minimal problem over n rows of data, which the estimator itself holds."""

    sample_size: int

    def __len__(self) -> int:
        """The number of rows n."""

    def draw(self, rng: np.random.Generator, count: int) -> Int:
        """Draws minimal samples: row numbers (count, sample_size) int64."""

    def minimal(self, samples: Int) -> Float:
        """Fits models (j, p) through the samples (k, sample_size); degenerate samples are dropped."""

    def residuals(self, models: Float, rows: Int | slice) -> Array:
        """Returns signed or absolute residuals (j, r), float32 or float64, of models (j, p) at `rows`."""

    def fit(self, rows: Int, weights: Float) -> Float | None:
        """Fits a model (p,) to many rows by weighted least squares; None when they are degenerate."""


@dataclass(frozen=True, eq=False)
class Consensus:
    """The best model of a search.

    model       (p,)
    inliers     (n,) bool
    score       MSAC score per unit weight, 0 (best) to 1 (worst)
    share       share of the weight that the inliers have, 0..1
    hypotheses  number of samples that were tried
    """

    model: Float
    inliers: Bool
    score: float
    share: float
    hypotheses: int


def needed_hypotheses(share: float, sample_size: int, confidence: float) -> float:
    """Samples needed for one without outliers with probability `confidence`: ln(1 - eta) / ln(1 - w^m)."""
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
    """Finds the model with the lowest truncated quadratic score ``sum w min(r^2, T^2)``.

    Hypotheses are scored in blocks on `score_rows` random rows. The `keep` best are scored on `verify_rows`,
    and the better half of them is improved by three least-squares fits to their own inliers with a shrinking
    threshold. The inliers of the result are taken from all rows.

    threshold  T, in the unit of the residuals
    weights    (n,) non-negative weights of the rows, for instance the area that each represents

    Returns None when no sample gave a model.
    """
    n = len(estimator)
    if n < estimator.sample_size:
        return None
    weight = np.ones(n, np.float32) if weights is None else np.asarray(weights, np.float32)
    verify = rng.permutation(n)[:verify_rows]
    rows = verify[:score_rows]
    models, tried = _sample(
        estimator,
        rows,
        weight[rows],
        threshold,
        rng,
        confidence=confidence,
        most=max_hypotheses,
        keep=keep,
        block=block,
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
    *,
    confidence: float,
    most: int,
    keep: int,
    block: int,
) -> tuple[Float, int]:
    """Returns the `keep` best models (j, p) of minimal samples, best first, and the number of samples."""
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
    """MSAC scores (j,) and shares of the inliers (j,), both per unit weight."""
    squared = estimator.residuals(models, rows) / np.float32(threshold)
    squared *= squared
    total = float(weight.sum(dtype=np.float64))
    share = (squared < 1.0).astype(np.float32) @ weight / total
    np.minimum(squared, 1.0, out=squared)
    return (squared @ weight / total).astype(np.float64), share.astype(np.float64)


def _optimise(
    estimator: Estimator, models: Float, rows: Int, weight: Array, threshold: float
) -> tuple[Float, float]:
    """Returns the best of the kept models and their refits, with its score on `rows` of `weight` (r,)."""
    best_model, best_score = models[0], np.inf
    ranked, _ = _score(estimator, models, rows, weight, threshold)
    total = float(weight.sum(dtype=np.float64))
    # Several of the kept models are the same structure: only the better half on more rows is refitted.
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
