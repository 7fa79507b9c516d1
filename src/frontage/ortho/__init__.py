"""Metric ortho-images of facades (paper A, section 3).

`make_ortho` is the entry function. It projects every pixel of a facade's raster into the photo that shows it
best, by homography or on the measured relief (3.1), resamples the photo there (3.2), and fills what no photo
shows from the scan. Every pixel keeps its position in the world, its source and its effective resolution.
"""

from frontage.ortho.make import make_ortho
from frontage.ortho.options import OrthoOptions

__all__ = ["OrthoOptions", "make_ortho"]
