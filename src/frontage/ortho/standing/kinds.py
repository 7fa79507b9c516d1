"""Tells by size and shape what an object before a facade is.

Sizes of cars, people and street furniture are known within a few decimetres, those of trees within a factor
of two. Every kind therefore has log-normal distributions of its length, width and extent in height, of the
height of its top, and of its roundness: the share of the smallest principal variance of the points within
half a metre, large in foliage and small on surfaces and lines. With equal priors, the probability of a kind
is its share of the likelihood. "Other" is wide in everything, so that what fits no kind becomes other.
"""

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.occluder import OCCLUDER_KINDS

# Median and standard deviation of the logarithm: length, width, extent and top in m, roundness.
# A scan sees one or two sides, so lengths and widths are also smaller than those of the whole object.
_SIZES = {
    "tree": ((3.5, 0.6), (2.8, 0.6), (5.5, 0.5), (6.5, 0.45), (0.10, 0.6)),
    "car": ((4.1, 0.25), (1.5, 0.35), (1.2, 0.25), (1.5, 0.15), (0.02, 0.8)),
    "lamp": ((0.5, 0.8), (0.2, 0.7), (4.5, 0.4), (5.0, 0.35), (0.01, 1.0)),
    "person": ((0.55, 0.35), (0.35, 0.45), (1.45, 0.2), (1.68, 0.12), (0.03, 0.8)),
    "sign": ((0.6, 0.5), (0.12, 0.6), (2.2, 0.4), (2.5, 0.25), (0.01, 1.0)),
    "wire": ((10.0, 0.6), (0.2, 0.8), (0.4, 0.8), (7.0, 0.4), (0.003, 1.0)),
    "other": ((1.5, 1.3), (0.8, 1.3), (1.5, 1.0), (2.0, 0.9), (0.03, 1.3)),
}


def chances(length: float, width: float, extent: float, top: float, roundness: float) -> Float:
    """Returns the probabilities (7,) of `OCCLUDER_KINDS` for an object of such sizes, m."""
    measured = np.log(np.maximum([length, width, extent, top, roundness], 1e-3))
    table = np.array([_SIZES[kind] for kind in OCCLUDER_KINDS])
    middle, sigma = np.log(table[..., 0]), table[..., 1]
    score = (-0.5 * ((measured - middle) / sigma) ** 2 - np.log(sigma)).sum(1)
    likelihood = np.exp(score - score.max())
    return np.asarray(likelihood / likelihood.sum())
