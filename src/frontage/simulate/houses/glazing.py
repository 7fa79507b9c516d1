"""How a window is divided: fields with bars, sliding sashes, lead cames, and spokes in an arched head."""

from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.model.built import TrueBar, TrueLine
from frontage.simulate.meshing import inset

UPPER_SASH_M, LOWER_SASH_M = 0.015, 0.055  # from the front of a frame back to its sashes
SASH_GLASS_M = (0.035, 0.075)
"""From the front of a frame back to the panes of the upper and of the lower sash."""
STILE_M = 0.042  # width of the wood around the glass of a sash
GLAZING_BAR_M = 0.018  # from the front of a frame back to a bar that only holds small panes
_NARROW_M = 0.045  # bars up to this width hold panes; wider ones are posts between casements
_CAME_M = 0.011


@dataclass(frozen=True)
class Field:
    """A part of a window with the bars that cross it from border to border.

    vertical, horizontal   shares of its width and height at which bars stand, from the left and from below
    width                  m, of these bars
    parts                  what is in the parts between them, where they run in one direction only; () = glass
    """

    vertical: tuple[float, ...] = ()
    horizontal: tuple[float, ...] = ()
    width: float = 0.03
    parts: tuple["Field", ...] = ()


@dataclass(frozen=True)
class Design:
    """How a window is divided and what its divisions are made of.

    field    its bars
    sashes   whether the parts below and above its first transom slide, the lower one behind the upper one
    leads    width and height (m) of the small panes between lead cames; None = none
    diamonds whether these panes stand on a corner
    spokes   radial bars in an arched head, above a transom at its springing; the field is below
    ajar     rad, by which the left one of two casements is turned inwards; negative: the right one
    """

    field: Field
    sashes: bool = False
    leads: tuple[float, float] | None = None
    diamonds: bool = False
    spokes: int = 0
    ajar: float = 0.0


@dataclass(frozen=True, eq=False)
class Division:
    """What divides a window: the fields of `OpeningPlan` that tell it."""

    bars: tuple[TrueBar, ...]
    lines: tuple[TrueLine, ...] = ()
    meeting: float | None = None
    glazing: str = "bars"
    ajar: tuple[float, float, float, float, float] | None = None


def divide(ring: Float, frame_width: float, design: Design) -> Division:
    """Return the bars of an opening with outline `ring` (k, 2) m; each ends at the axis of what stops it."""
    light = inset(ring, frame_width)
    area = shapely.Polygon(light)
    (x0, z0), (x1, z1) = light.min(0), light.max(0)
    lines: list[TrueLine] = []
    bars: list[TrueBar] = []
    if design.spokes:
        z1 = float(ring[2, 1])  # where the arch springs
        bars.append(_bar(area, "horizontal", z1, (x0 - 1, x1 + 1), 0.06))
        lines = _spokes(area, (x0 + x1) / 2, z1, design)
    bars += _field_bars(area, design.field, (x0, z0, x1, z1))
    meeting = z0 + (z1 - z0) * design.field.horizontal[0] if design.sashes else None
    if design.leads:
        lines = _cames(area, design.leads, design.diamonds)
    kind = "leaded" if design.leads else "radial" if design.spokes else "bars"
    placed = tuple(_in_depth(b, meeting) for b in bars)
    ajar = None
    if design.ajar:
        post = placed[0].position
        ajar = (x0, z0, post, z1, design.ajar) if design.ajar > 0 else (post, z0, x1, z1, design.ajar)
    return Division(placed, tuple(lines), meeting, kind, ajar)


def panes(field: Field) -> int:
    """Return how many panes the bars of a field make."""
    if not field.parts:
        return (len(field.vertical) + 1) * (len(field.horizontal) + 1)
    return sum(panes(p) for p in field.parts)


def least_pane(field: Field, width: float, height: float) -> float:
    """Return the least width or height (m) of the panes of a field of `width` x `height` m."""
    wide = np.diff([0.0, *field.vertical, 1.0]) * width
    high = np.diff([0.0, *field.horizontal, 1.0]) * height
    if not field.parts:
        return float(min(wide.min(), high.min())) - field.width
    sizes = [(w, h) for w in wide for h in high]
    return min(least_pane(p, w, h) for p, (w, h) in zip(field.parts, sizes, strict=True))


def _field_bars(area: shapely.Polygon, field: Field, box: tuple[float, float, float, float]) -> list[TrueBar]:
    x0, z0, x1, z1 = box
    xs = [x0 + (x1 - x0) * s for s in field.vertical]
    zs = [z0 + (z1 - z0) * s for s in field.horizontal]
    bars = [_bar(area, "vertical", x, (z0, z1), field.width) for x in xs]
    bars += [_bar(area, "horizontal", z, (x0, x1), field.width) for z in zs]
    columns, rows = [x0, *xs, x1], [z0, *zs, z1]
    boxes = [(columns[i], rows[j], columns[i + 1], rows[j + 1])
             for i in range(len(xs) + 1) for j in range(len(zs) + 1)]  # fmt: skip
    for part, own in zip(field.parts, boxes, strict=True) if field.parts else ():
        bars += _field_bars(area, part, own)
    return bars


def _bar(
    area: shapely.Polygon, axis: str, position: float, between: tuple[float, float], width: float
) -> TrueBar:
    """Returns a bar that ends at the frame, or before it at the ends given."""
    low, high = between
    ends = [(position, low), (position, high)] if axis == "vertical" else [(low, position), (high, position)]
    inside = shapely.get_coordinates(shapely.intersection(area, shapely.LineString(ends)))
    along = inside[:, 1 if axis == "vertical" else 0]
    return TrueBar(axis, position, (float(along.min()), float(along.max())), width)


def _in_depth(bar: TrueBar, meeting: float | None) -> TrueBar:
    """Sets how far behind the front of the frame a bar stands."""
    narrow = GLAZING_BAR_M if bar.width <= _NARROW_M else 0.0
    if meeting is None:
        behind = narrow
    elif bar.axis == "horizontal" and abs(bar.position - meeting) < 1e-9:
        behind = UPPER_SASH_M
    else:
        middle = bar.position if bar.axis == "horizontal" else sum(bar.extent) / 2
        behind = (LOWER_SASH_M if middle < meeting else UPPER_SASH_M) + 0.01
    return TrueBar(bar.axis, bar.position, bar.extent, bar.width, behind)


def _spokes(area: shapely.Polygon, x: float, z: float, design: Design) -> list[TrueLine]:
    turns = np.pi * np.arange(1, design.spokes + 1) / (design.spokes + 1)
    far = [(x + 9 * np.cos(t), z + 9 * np.sin(t)) for t in turns]
    return [_clipped(area, ((x, z), end), 0.028) for end in far]


def _cames(area: shapely.Polygon, size: tuple[float, float], diamonds: bool) -> list[TrueLine]:
    """Returns lead cames that divide an area into small rectangles, or diamonds, of the given size."""
    x0, z0, x1, z1 = area.bounds
    w, h = size
    ends: list[tuple[tuple[float, float], tuple[float, float]]] = []
    if diamonds:
        slope, high = h / w, z1 - z0
        run = high / slope
        for x in np.arange(x0 - run, x1 + run, w):
            ends += [((x, z0), (x + run, z1)), ((x + w / 2, z1), (x + w / 2 + run, z0))]
    else:
        nx, nz = max(2, round((x1 - x0) / w)), max(2, round((z1 - z0) / h))
        ends += [((x, z0 - 1), (x, z1 + 1)) for x in np.linspace(x0, x1, nx + 1)[1:-1].tolist()]
        ends += [((x0 - 1, z), (x1 + 1, z)) for z in np.linspace(z0, z1, nz + 1)[1:-1].tolist()]
    crossing = [e for e in ends if shapely.LineString(e).intersection(area).length > 0.02]
    return [_clipped(area, e, _CAME_M) for e in crossing]


def _clipped(
    area: shapely.Polygon, ends: tuple[tuple[float, float], tuple[float, float]], width: float
) -> TrueLine:
    xz = shapely.get_coordinates(shapely.intersection(area, shapely.LineString(ends)))
    (xa, za), (xb, zb) = xz[0].tolist(), xz[-1].tolist()
    return TrueLine(((xa, za), (xb, zb)), width)
