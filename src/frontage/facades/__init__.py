"""Facades: every main plane of a building with its frame, outline, layers and covariance.

This room implements paper A: the principal plane by RANSAC (section 2.1) and the local reference frame of the
facade at the barycentre of its inliers (section 2.2). It extends the paper to all facades of a building, with
a robust refinement, a covariance and the street side told from the rays. The entry function is
`find_facades`.
"""

from frontage.facades.find import find_facades
from frontage.facades.options import FacadeOptions

__all__ = ["FacadeOptions", "find_facades"]
