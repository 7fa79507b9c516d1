"""Facades: every main plane of a building with its frame, outline, layers and covariance (paper A,
2.1-2.2).
"""

from frontage.facades.find import find_facades
from frontage.facades.options import FacadeOptions

__all__ = ["FacadeOptions", "find_facades"]
