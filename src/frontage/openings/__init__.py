"""Openings: windows, doors and protrusions of a facade, found in its points and beams.

Paper B (Becker & Haala 2008), sections 3.1 and 3.2. The default method weighs, cell by cell, the beams that
the wall stopped against those that went through it, finds the best layout of rectangles exactly, and measures
every border with its likelihood; `paper` is the cell decomposition as published. `wall` observes the beams,
`layout` finds the openings, `borders` measures them, `closed` finds those that are closed level with the
wall, and `protrusions` finds what stands out of it.

The entry is `find_openings`; `frontage.openings.duplicates` settles openings that several facades of a
building show, and `frontage.catalog` numbers them.
"""

from frontage.openings.find import FoundOpenings, find_openings
from frontage.openings.options import OpeningOptions

__all__ = ["FoundOpenings", "OpeningOptions", "find_openings"]
