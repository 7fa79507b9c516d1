"""Likelihoods of the places of borders."""

import numpy as np
import pytest

from frontage.openings.borders.scores import blurred_scores, correlated, side_scores


def test_pairs_are_scored_together_as_alone() -> None:
    rng = np.random.default_rng(7)
    pairs = [(rng.normal(-0.1, 0.1, n), rng.normal(0.1, 0.1, m)) for n, m in ((50, 40), (0, 0), (0, 9))]
    e, blurs = np.arange(-0.05, 0.05, 0.001), (0.002, 0.01)
    together = blurred_scores(pairs, e, blurs, (0.01, 0.02))
    alone = [[side_scores(*pair, e, blur, (0.01, 0.02)) for pair in pairs] for blur in blurs]
    assert together == pytest.approx(np.array(alone), abs=1e-9)
    assert not together[:, 1].any()


@pytest.mark.parametrize("length", [1, 8, 40])
def test_rows_are_correlated_one_by_one(length: int) -> None:
    rows, kernel = np.random.default_rng(8).random((3, 60)), np.random.default_rng(9).random(length)
    assert correlated(rows, kernel) == pytest.approx(
        np.array([np.correlate(row, kernel, "valid") for row in rows])
    )
