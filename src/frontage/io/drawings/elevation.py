"""What a drawing of a facade holds, whatever the file: lines on layers, dimensions, levels, one sheet.

Coordinates (x, h) are metres in the plane of the facade: x of the facade frame, h the height above the datum.
"""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, freeze
from frontage.model.opening import OpeningKind

LAYERS = {
    "ORTHO_IMAGE": (8, 13, "the ortho-image, an underlay"),
    "OUTLINE": (7, 50, "outline of the measured facade"),
    "WALL_LINES": (8, 18, "parts of the wall before or behind the main plane: oriels, plinths, setbacks"),
    "PROTRUSIONS": (3, 25, "balconies, cornices, steps and other things on the wall"),
    "BARS": (9, 13, "window bars"),
    "LEVELS": (6, 13, "levels above the datum"),
    "DIMENSIONS": (2, 13, "dimensions in metres"),
    "LABELS": (7, 13, "names of openings"),
} | {
    f"OPENING_{kind.name}": (colour, 35, f"openings: {kind}")
    for kind, colour in zip(OpeningKind, (5, 1, 4, 30, 40, 140, 6), strict=True)
}
"""Layers with their AutoCAD colour index, line weight in 1/100 mm, and what they hold."""


@dataclass(frozen=True, eq=False)
class Line:
    """A closed line (k, 2) m on a layer; dashed where it is uncertain.

    tag    id of the element that it outlines, "" = none
    facts  further facts about that element: name and value
    """

    layer: str
    points: Float
    dashed: bool = False
    tag: str = ""
    facts: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        freeze(self, points=((None, 2), np.float64))


@dataclass(frozen=True)
class Dimension:
    """A distance between two points (x, h) m along one axis; the dimension line is at the coordinate `at`."""

    axis: str  # "x" or "h"
    start: tuple[float, float]
    end: tuple[float, float]
    at: float

    @property
    def length(self) -> float:
        """The measured distance, m."""
        k = 0 if self.axis == "x" else 1
        return abs(self.end[k] - self.start[k])


@dataclass(frozen=True)
class Level:
    """A level: its name and its height m above the datum."""

    name: str
    height: float


@dataclass(frozen=True)
class Label:
    """A short text centred at (x, h) m."""

    text: str
    at: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Underlay:
    """An ortho-image under the lines: file, its path relative to the drawing, upper left corner, size.

    corner  (x, h) m
    size    width and height m; `pixels` the same in px
    """

    path: str
    jpeg: bytes
    corner: tuple[float, float]
    size: tuple[float, float]
    pixels: tuple[int, int]


@dataclass(frozen=True)
class Sheet:
    """Paper and scale of a drawing: name and landscape size (width, height) mm, and the scale 1:scale."""

    paper: str
    size: tuple[float, float]
    scale: int

    @property
    def words(self) -> str:
        """At which scale the sheet shows the facade."""
        return f"Scale 1:{self.scale} on {self.paper}"

    def metres(self, millimetres: float) -> float:
        """Return a length on paper in metres of the facade."""
        return millimetres * self.scale / 1000.0


@dataclass(frozen=True, eq=False)
class Elevation:
    """The drawing of one facade.

    zero    m, height of z = 0 of the facade frame: h = zero + z
    bounds  x0, h0, x1, h1 m of everything that is drawn, without dimensions
    title   lines of the title block
    """

    facade: str
    zero: float
    sheet: Sheet
    bounds: tuple[float, float, float, float]
    lines: tuple[Line, ...]
    dimensions: tuple[Dimension, ...]
    levels: tuple[Level, ...]
    labels: tuple[Label, ...]
    title: tuple[str, ...]
    underlay: Underlay | None = None


LEFT_MM, RIGHT_MM, BOTTOM_MM, TOP_MM = 30.0, 62.0, 40.0, 12.0
"""Room on paper around a facade: dimensions on the left and below, levels on the right."""

BORDER_MM, TITLE_MM = 10.0, 34.0
"""Width of the border of a sheet, and height of the title block within it."""

_PAPERS = (("A4", 297, 210), ("A3", 420, 297), ("A2", 594, 420), ("A1", 841, 594), ("A0", 1189, 841))
_SCALES = (50, 100, 200, 500, 1000)


def sheet_for(width: float, height: float) -> Sheet:
    """Return the smallest sheet for a facade of this size (m): at 1:50 if A0 can hold it, else smaller."""
    for scale in _SCALES:
        w = width * 1000 / scale + LEFT_MM + RIGHT_MM + 2 * BORDER_MM
        h = height * 1000 / scale + BOTTOM_MM + TOP_MM + TITLE_MM + 2 * BORDER_MM
        for name, across, up in _PAPERS:
            if w <= across and h <= up:
                return Sheet(name, (float(across), float(up)), scale)
    name, across, up = _PAPERS[-1]
    room = min((across - LEFT_MM - RIGHT_MM - 2 * BORDER_MM) / width,
               (up - BOTTOM_MM - TOP_MM - TITLE_MM - 2 * BORDER_MM) / height)  # fmt: skip
    return Sheet(name, (float(across), float(up)), int(np.ceil(1.0 / room)) * 1000)


def place_on_sheet(elevation: Elevation) -> tuple[float, float]:
    """Return where (x0, h0) of the bounds comes to lie on the sheet, mm from its lower left corner."""
    x0, h0, x1, h1 = elevation.bounds
    (w, h), scale = elevation.sheet.size, elevation.sheet.scale
    wide, high = (x1 - x0) * 1000 / scale, (h1 - h0) * 1000 / scale
    left = BORDER_MM + LEFT_MM + max(w - 2 * BORDER_MM - LEFT_MM - RIGHT_MM - wide, 0.0) / 2
    free = h - 2 * BORDER_MM - TITLE_MM - BOTTOM_MM - TOP_MM - high
    return left, BORDER_MM + TITLE_MM + BOTTOM_MM + max(free, 0.0) / 2
