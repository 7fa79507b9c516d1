"""Metric ortho-images of facades (paper A, section 3)."""

from frontage.ortho.make import make_ortho
from frontage.ortho.options import OrthoOptions

__all__ = ["OrthoOptions", "make_ortho"]
