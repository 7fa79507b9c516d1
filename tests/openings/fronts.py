"""Regular fronts as they would have been measured: outlines with known errors."""

import numpy as np

from frontage.model.estimate import Estimate
from frontage.openings.borders.outline import Outline

SIZE = (1.1, 1.7)


def outline(place, sigma, depth=None, shape="rectangle"):
    covariance = np.diag(np.r_[np.square(np.broadcast_to(sigma, 4)), 0.0])
    return Outline(shape, place, 0.0, covariance, (), depth, 0.0)


def front(seed=0, rows=4, columns=5, sigma=0.01, jitter=0.0, change=None):
    """Outlines with errors of `sigma` m of a regular front, and their true boxes (n, 4)."""
    rng = np.random.default_rng(seed)
    found, truth = [], []
    for r in range(rows):
        for c in range(columns):
            x, z = 2.5 * c + rng.normal(0, jitter), 3.2 * r + 1.0 + rng.normal(0, jitter)
            box = np.array([x, z, x + SIZE[0], z + SIZE[1]])
            if change and (r, c) == change[0]:
                box += change[1]
            truth.append(box)
            depth = Estimate(0.15 + rng.normal(0, 0.005), np.array([[0.005**2]]), 20.0)
            found.append(outline(tuple(box + rng.normal(0, sigma, 4)), sigma, depth))
    return found, np.array(truth)
