"""Openings as they were built, which the simulator draws and the scorers compare results with."""

from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Float, freeze


@dataclass(frozen=True)
class TrueBar:
    """A true window bar: axis "vertical" (position x) or "horizontal" (position z), extent, width; in m.

    `behind` is how far its front lies behind the front of the frame (to some mm): narrow glazing bars stand
    back, and so does the lower one of two sashes.
    """

    axis: str
    position: float
    extent: tuple[float, float]
    width: float
    behind: float = 0.0


@dataclass(frozen=True)
class TrueLine:
    """A thin piece that divides glass but is no mullion or transom: a spoke of an arched head, a lead came.

    line    both ends (x, z) m of its centre line
    width   m
    """

    line: tuple[tuple[float, float], tuple[float, float]]
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
    glazing       "bars": nothing but `bars` divides it; "radial": so do `lines` in its head; "leaded":
                  `lines` are the cames of small panes
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
    glazing: str = field(default="bars", kw_only=True)
    lines: tuple[TrueLine, ...] = field(default=(), kw_only=True)

    def __post_init__(self) -> None:
        freeze(self, ring=((None, 2), np.float64))
