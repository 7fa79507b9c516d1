"""Tells what lies behind the openings of a relief: a frame, a passage, or a room that is not the facade.

Frames stand within the thickness of the outer wall. Solid brick walls are 24 or 36.5 cm thick (one or one and
a half bricks) without render, and insulated walls set their frames no deeper. What a scan sees behind that is
therefore a room behind glass, unless it is a surface that a person could walk up to: continuous, and at least
as wide as the narrowest door leaf, 61 cm (DIN 18101), such as the back of a loggia, a passage or a door in a
deep portal.
"""

import numpy as np

from frontage.geometry.arrays import Array, Bool
from frontage.raster import gridding

DEEPEST_REVEAL_M = 0.4  # one and a half bricks, 36.5 cm, and the render on both sides
_PASSAGE_M = 0.61  # DIN 18101, narrowest door leaf
_CONTINUED = 0.5  # share of the cells around that must continue a surface
_BORDER_CELLS = 3  # beside a wide surface, whose border is not continued on all sides


def room_cells(y: Array, size: float, step: float) -> Bool:
    """Returns the cells that show rooms behind glass, (h, w) bool, of a relief y (h, w) m.

    They are deeper than any reveal and do not belong to a continuous surface as wide as a door. `size` m is
    the edge of a cell; neighbours within `step` m of each other continue a surface.
    """
    with np.errstate(invalid="ignore"):
        deep = y > DEEPEST_REVEAL_M
    return deep & ~solid_cells(deep, y, size, step)


def solid_cells(among: Bool, y: Array, size: float, step: float) -> Bool:
    """Returns the cells (h, w) `among` those given that belong to a surface as wide as a door.

    The surface is that of a relief y (h, w) m with cells of `size` m; neighbours within `step` m of each
    other continue it.
    """
    if not among.any():
        return among
    solid = _continuous(among, y, step)
    whole = gridding.closed(solid, np.full(y.shape, 1.0))
    wide = ~gridding.closed(~whole, np.full(y.shape, 0.5 * _PASSAGE_M / size))  # opening of the surface
    return among & (gridding.distance_to(wide) <= _BORDER_CELLS)


def _continuous(among: Bool, y: Array, step: float) -> Bool:
    """Returns the cells (h, w) `among` those given that half of 24 neighbours continue within `step` m."""
    padded = np.pad(y, 2, constant_values=np.nan)
    width = padded.shape[1]
    row, column = np.nonzero(among)
    at, own = (row + 2) * width + column + 2, y[row, column]
    friends = np.zeros(len(at), np.int64)
    for i in range(-2, 3):
        for j in range(-2, 3):
            with np.errstate(invalid="ignore"):
                friends += np.abs(padded.ravel()[at + (i * width + j)] - own) <= step
    found = np.zeros_like(among)
    found[row, column] = friends - 1 >= _CONTINUED * 24
    return found
