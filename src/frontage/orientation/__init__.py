"""Orientation of free photos against each other and against the scan (paper B, section 2.2).

`ties` matches the photos with one another and forms blocks (2.2.1, with pycolmap). `orient.orient_photos` is
the entry function that takes blocks into the frame of a scan (2.2.2). Its steps: a block is drawn on its
walls and searched for on the walls of the scan (`place`), control points are found by drawing the scan as
each photo would see it (`control`), everything is adjusted together (`adjustment`), and every photo is
checked by drawing the scan again (`verify`). `paper` is the paper's own chain, to compare with. `free`
adjusts photos without a scan.
"""

from frontage.orientation.free import adjusted_block
from frontage.orientation.nouns import Block, KeyPoints, PairMatches
from frontage.orientation.options import OrientationOptions
from frontage.orientation.orient import orient_photos
from frontage.orientation.result import Drawing, Orientation, OrientedPhoto, Unoriented

__all__ = [
    "Block",
    "Drawing",
    "KeyPoints",
    "Orientation",
    "OrientationOptions",
    "OrientedPhoto",
    "PairMatches",
    "Unoriented",
    "adjusted_block",
    "orient_photos",
]
