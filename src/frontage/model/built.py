"""Openings as they were built, which the simulator draws and the scorers compare results with."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, freeze


@dataclass(frozen=True)
class TrueBar:
    """A true window bar: axis "vertical" (position x) or "horizontal" (position z), extent, width; in m."""

    axis: str
    position: float
    extent: tuple[float, float]
    width: float


@dataclass(frozen=True, eq=False)
class BuiltOpening:
    """An opening as built: the edge of its hole in the wall, in the facade frame.

    id            "B02/F1/W3-2"
    kind          the text of an `OpeningKind`
    shape         "rectangle", "segmental", "round", "pointed", "triangular", "circle"
    ring          (k, 2) m (x, z), counter-clockwise as seen from the street; chord error of arcs < 1 mm
    wall_y        m, y of the wall that holds it (0 = main plane, negative = front of an oriel)
    depth         m, from the wall to the front of the frame or leaf
    bars          between the sides of the frame
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
