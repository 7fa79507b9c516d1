"""Openings that share rows, columns and sizes: pooled where the facade is regular, and only there."""

import numpy as np
import pytest

from frontage.openings.layout.groups import between_members
from frontage.openings.layout.pooling import pool
from openings.fronts import front, outline


def errors(outlines, truth):
    return np.array([o.place for o in outlines]) - truth


@pytest.mark.parametrize("jitter", [0.0, 0.005, 0.02])
def test_pooling_improves_and_stays_honest(jitter):
    before, after, normalised = [], [], []
    for seed in range(6):
        found, truth = front(seed, jitter=jitter)
        pooled = pool(found)
        before.append(errors(found, truth))
        after.append(errors(pooled, truth))
        sigma = np.sqrt([np.diag(o.covariance)[[0, 2, 1, 3]] for o in pooled])
        normalised.append(after[-1] / sigma)
    gain = np.std(after) / np.std(before)
    assert gain < (0.7 if jitter == 0.0 else 0.85)
    assert 0.75 < np.sqrt(np.mean(np.square(normalised))) < 1.25


def test_depths_of_like_windows_are_shared():
    found, _ = front(1)
    depths = np.array([o.depth.value for o in pool(found)])
    assert np.abs(depths - 0.15).max() < 0.5 * np.abs([o.depth.value - 0.15 for o in found]).max()
    # less than one alone, but never less than what all of them have in common
    assert all(0.001 < o.depth.sigma[0] < p.depth.sigma[0] for o, p in zip(pool(found), found, strict=True))


@pytest.mark.parametrize(
    "change", [(0.0, -0.3, 0.0, 0.0), (0.0, 0.0, 0.08, 0.0), (0.12, 0.0, 0.12, 0.0), (0.0, 0.1, 0.0, 0.1)]
)
def test_a_window_that_differs_keeps_its_own_borders(change):
    found, truth = front(2, sigma=0.004, change=((1, 2), np.array(change)))
    pooled = pool(found)
    odd = 7
    assert np.abs(pooled[odd].place - truth[odd]).max() < 0.015
    others = np.delete(errors(pooled, truth), odd, axis=0)
    assert np.std(others) < 0.8 * 0.004


def test_irregular_fronts_are_left_alone():
    rng = np.random.default_rng(5)
    boxes = [(3.0 * k + rng.uniform(0, 1), rng.uniform(1, 1.8)) for k in range(8)]
    found = [outline((x, z, x + rng.uniform(0.8, 1.6), z + rng.uniform(1.2, 2.0)), 0.003) for x, z in boxes]
    pooled = pool(found)
    assert np.abs([np.subtract(a.place, b.place) for a, b in zip(pooled, found, strict=True)]).max() < 0.004
    assert not any(o.pooled for o in pooled)


def test_a_poor_border_is_told_by_the_others_and_says_so():
    found, truth = front(3, sigma=0.002)
    blurred = outline(tuple(truth[8] + (0.0, 0.0, 0.05, 0.0)), (0.002, 0.06, 0.002, 0.002), found[8].depth)
    pooled = pool([*found[:8], blurred, *found[9:]])
    assert abs(pooled[8].place[2] - truth[8][2]) < 0.006
    assert pooled[8].pooled
    assert np.sqrt(pooled[8].covariance[1, 1]) < 0.01


def test_variance_between_members():
    rng = np.random.default_rng(6)
    groups = [tuple(range(10 * k, 10 * k + 10)) for k in range(5)]
    sigma = np.full(50, 0.005)
    equal, apart = rng.normal(0, 0.005, 50), rng.normal(0, np.hypot(0.005, 0.02), 50)
    assert between_members(equal, sigma, groups) < 0.004
    assert 0.014 < between_members(apart, sigma, groups) < 0.03
    assert between_members(equal, sigma, [(0, 1)]) == 1.0  # two members tell nothing of their scatter


def test_nothing_to_pool():
    assert pool([]) == []
    found, _ = front(0, rows=1, columns=2)
    assert pool(found) == found
