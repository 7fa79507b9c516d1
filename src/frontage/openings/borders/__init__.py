"""Measures openings: where exactly their borders lie, how their heads curve, and how deep their frames lie.

Paper B, section 3.2.1, draws lines through the last points of the wall; here every border has a posterior
from the beams on both sides of it, with its standard error. `measure` is the entry: it takes rough boxes and
returns `Outline`s with covariances.
"""
