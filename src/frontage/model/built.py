"""Openings as they were built: what the simulator draws and the scorers compare with."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, freeze


@dataclass(frozen=True)
class TrueBar:
    """A window bar: axis "vertical" (position x) or "horizontal" (position z), extent along it, width; m."""

    axis: str
    position: float
    extent: tuple[float, float]
    width: float


@dataclass(frozen=True, eq=False)
class BuiltOpening:
    """An opening as built: the hole in the wall (reveal edge), in the facade frame.

    id            "B02/F1/W3-2"
    kind          "window", "door", "shopfront", "passage", "garage", "basement"
    shape         "rectangle", "segmental", "round", "pointed", "triangular", "circle"
    ring          (k, 2) m (x, z), counter-clockwise as seen from the street, chord error of arcs < 1 mm
    wall_y        m, y of the wall it is cut into (0 = main plane, negative = an oriel's front)
    depth         m, wall to the front of the frame or leaf
    bars          between the frame's sides
    shutters      "none", "open" (beside the hole) or "closed" (the hole is flush)
    """

    id: str
    kind: str
    shape: str
    ring: Float
    wall_y: float
    depth: float
    bars: tuple[TrueBar, ...]
    shutters: str
    glazed: bool

    def __post_init__(self) -> None:
        freeze(self, ring=((None, 2), np.float64))
