"""Outlines of openings, and the bars that divide them."""

from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.geometry.ring import rectangle
from frontage.model.built import TrueBar
from frontage.simulate.meshing import inset

CHORD_ERROR_M = 0.0008  # greatest distance of a chord from its arc
SHAPES = ("rectangle", "segmental", "round", "pointed", "triangular", "circle")
_RISE_PER_WIDTH = {"segmental": 1 / 7, "triangular": 1 / 3}  # of heads whose rise is not given


def opening_ring(
    shape: str, x: float, z: float, width: float, height: float, *, rise: float | None = None
) -> Float:
    """Return the outline (k, 2) m, counter-clockwise, of an opening.

    (x, z) is the lower left corner of its bounding box, and `height` includes the arch or gable. `rise` (m)
    is the height of a segmental or triangular head; by default a seventh or a third of the width.

    Raises ValueError for a shape that is not in `SHAPES`, and for an opening that is too low for its head.
    """
    half, middle = width / 2, x + width / 2
    if shape == "rectangle":
        return rectangle(x, z, x + width, z + height)
    if shape == "circle":
        turn = np.linspace(0, 2 * np.pi, _segments(half, 2 * np.pi) + 1)[:-1]
        return np.column_stack([middle + half * np.cos(turn), z + half + half * np.sin(turn)])
    if shape not in SHAPES:
        raise ValueError(f"opening shape {shape!r}: not one of {', '.join(SHAPES)}")
    arch = _arch(shape, half, width * _RISE_PER_WIDTH.get(shape, 0.0) if rise is None else rise)
    spring = height - float(arch[:, 1].max())
    if spring <= 0.02:
        raise ValueError(f"an opening {height:g} m high is too low for a {shape} arch {width:g} m wide")
    foot = np.array([[x, z], [x + width, z]])
    return np.concatenate([foot, arch + np.array([middle, z + spring])])


def _arch(shape: str, half: float, rise: float) -> Float:
    """Returns an arch (k, 2) from its right to its left springing point, centred between them."""
    if shape == "triangular":
        return np.array([[half, 0.0], [0.0, rise], [-half, 0.0]])
    if shape == "segmental":
        radius = (half * half + rise * rise) / (2 * rise)
        reach = float(np.arcsin(half / radius))
        turn = np.linspace(-reach, reach, _segments(radius, 2 * reach) + 1)[::-1]
        arch = np.column_stack([radius * np.sin(turn), radius * np.cos(turn) - (radius - rise)])
    elif shape == "round":
        turn = np.linspace(0, np.pi, _segments(half, np.pi) + 1)
        arch = half * np.column_stack([np.cos(turn), np.sin(turn)])
    else:  # pointed: two arcs about the opposite springing points
        turn = np.linspace(0, np.pi / 3, _segments(2 * half, np.pi / 3) + 1)
        right = np.column_stack([2 * half * np.cos(turn) - half, 2 * half * np.sin(turn)])
        arch = np.concatenate([right, (right * [-1.0, 1.0])[-2::-1]])
    arch[0], arch[-1] = (half, 0.0), (-half, 0.0)
    return arch


def _segments(radius: float, angle: float) -> int:
    step = 2 * np.arccos(1 - min(CHORD_ERROR_M / radius, 0.5))
    return max(4, int(np.ceil(angle / step)))


@dataclass(frozen=True)
class BarLayout:
    """How bars divide an opening.

    style         "grid": evenly; "T": a transom high up, with upright bars only below it;
                  "asymmetric": the first upright at a third of the width, the first transom at two thirds
    vertical, horizontal   number of upright bars (mullions) and of transoms
    main          m, width of the bars where casements meet: the middle upright and the first transom
    thin          m, width of all other bars
    """

    style: str = "grid"
    vertical: int = 0
    horizontal: int = 0
    main: float = 0.08
    thin: float = 0.03


def plan_bars(ring: Float, frame_width: float, layout: BarLayout) -> tuple[TrueBar, ...]:
    """Return the bars of an opening with outline `ring`; each ends where its axis meets the frame."""
    light = inset(ring, frame_width)
    (x0, z0), (x1, z1) = light.min(0), light.max(0)
    uprights = _positions(x0, x1, layout.vertical, layout.style, 1 / 3)
    transoms = _positions(z0, z1, layout.horizontal, layout.style, 2 / 3)
    if layout.style == "T":
        transoms = [z0 + (z1 - z0) * 0.68, *transoms[1:]] if transoms else []
    top = transoms[0] if layout.style == "T" and transoms else z1 + 1.0
    area = shapely.Polygon(light)
    bars = []
    for k, x in enumerate(uprights):
        low, high = _chord(area, [(x, z0 - 1), (x, top)], 1)
        bars.append(TrueBar("vertical", x, (low, high), _width(layout, k, layout.vertical)))
    for k, z in enumerate(transoms):
        low, high = _chord(area, [(x0 - 1, z), (x1 + 1, z)], 0)
        bars.append(
            TrueBar("horizontal", z, (low, high), layout.main if k == 0 and top < z1 else layout.thin)
        )
    return tuple(bars)


def _positions(low: float, high: float, count: int, style: str, first: float) -> list[float]:
    if style != "asymmetric" or count == 0:
        return [low + (high - low) * (k + 1) / (count + 1) for k in range(count)]
    start = low + (high - low) * first
    rest = [start + (high - start) * (k + 1) / count for k in range(count - 1)]
    return [start, *rest]


def _width(layout: BarLayout, k: int, count: int) -> float:
    """Returns the width of upright `k`: casements meet at the middle one, the others are glazing bars."""
    return layout.main if k == (count - 1) // 2 and count % 2 else layout.thin


def _chord(area: shapely.Polygon, line: list[tuple[float, float]], axis: int) -> tuple[float, float]:
    inside = shapely.get_coordinates(shapely.intersection(area, shapely.LineString(line)))[:, axis]
    return float(inside.min()), float(inside.max())
