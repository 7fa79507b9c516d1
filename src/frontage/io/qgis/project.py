"""What a QGIS project shows: layers in groups, and a sheet (print layout) per elevation."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from frontage.io.drawings.elevation import Sheet

Shape = Literal["Point", "Line", "Polygon", "Raster"]
Colour = tuple[int, int, int]
Box = tuple[float, float, float, float]
"""x0, y0, x1, y1, m."""


@dataclass(frozen=True)
class Look:
    """How a vector layer is drawn.

    stroke  colour of lines, and of points
    width   mm on paper, of lines; of points their size
    fill    colour of areas; None = not filled
    by      a column whose values have colours of their own (`colours`) in place of `stroke`, "" = none
    turned  a column with the bearing (degrees) to which points are turned, "" = none
    dashed  an expression of QGIS that tells of which areas the border is dashed, "" = of none
    label   an expression of QGIS that labels the features, "" = no labels
    """

    stroke: Colour
    width: float
    fill: Colour | None = None
    by: str = ""
    colours: tuple[tuple[str, Colour], ...] = ()
    turned: str = ""
    dashed: str = ""
    label: str = ""


@dataclass(frozen=True)
class Layer:
    """A layer.

    key      its id in the project: letters, digits and underscores. QGIS makes ids of its own for those of
             ten characters or fewer, which sheets then do not find
    source   path relative to the project file; "|layername=openings" and "|subset=..." follow it for vectors
    shape    of its features, or "Raster"
    look     how its features are drawn; None for a raster
    depths   whether the raster holds depths, not colours
    upright  whether it lies in the plane of a facade, not in the CRS of the project
    shown    whether it is visible when the project opens
    """

    key: str
    name: str
    source: str
    shape: Shape
    look: Look | None = None
    depths: bool = False
    upright: bool = False
    shown: bool = True

    @property
    def provider(self) -> str:
        """What QGIS reads it with."""
        return "gdal" if self.shape == "Raster" else "ogr"


@dataclass(frozen=True)
class Group:
    """Layers and groups under a name, the uppermost first."""

    name: str
    items: "tuple[Layer | Group, ...]"
    shown: bool = True

    @property
    def layers(self) -> Iterator[Layer]:
        """All layers, those of its groups as well."""
        for item in self.items:
            yield from item.layers if isinstance(item, Group) else (item,)


@dataclass(frozen=True)
class Plate:
    """An elevation on a sheet: its name, paper and scale, what it shows, and its title block.

    bounds  m in the plane of the facade, of what lies in the middle of the sheet
    layers  keys, the uppermost first
    """

    name: str
    sheet: Sheet
    bounds: Box
    layers: tuple[str, ...]
    title: tuple[str, ...]


@dataclass(frozen=True)
class QgisProject:
    """A project: its title, the CRS of what is not upright, its groups and plates, and the first view.

    extent    m in that CRS; None = nothing has a place
    left_out  sentences on what the project does not show
    """

    title: str
    crs: str | None
    groups: tuple[Group, ...]
    plates: tuple[Plate, ...]
    extent: Box | None
    left_out: tuple[str, ...] = ()

    @property
    def layers(self) -> Iterator[Layer]:
        """All layers of all groups."""
        for group in self.groups:
            yield from group.layers
