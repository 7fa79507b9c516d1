"""Figures of the report as numbers for SVG: axes in metres, plans, pictures inline."""

import base64
import math
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.report.data import FacadeView, PictureView, ReportData
from frontage.report.evidence import png_bytes
from frontage.report.openings import DrawnOutline, outlines

_PLAN_PIXELS = 430  # half the figure: a lone point shows as 2 px
_AROUND = 12.0  # m shown around the facades, at most
_EDGE = 2.0  # m shown beyond the last point: room for arrows and names
_FIGURE_WIDTH, _FIGURE_HEIGHT = 860.0, 760.0


@dataclass(frozen=True)
class Tick:
    """A grid line: its place in the figure (px), its label in metres ("" = none)."""

    at: float
    label: str


@dataclass(frozen=True)
class Segment:
    """A facade in plan: both ends and the tip of its outward arrow, in px; its label, "" = none."""

    id: str
    label: str
    x1: float
    y1: float
    x2: float
    y2: float
    tip_x: float
    tip_y: float


@dataclass(frozen=True)
class Figure:
    """A picture of `width` x `height` px with a metre grid, outlines, facades in plan, a scale bar."""

    width: float
    height: float
    href: str
    vertical: tuple[Tick, ...] = ()
    horizontal: tuple[Tick, ...] = ()
    outline: str = ""
    segments: tuple[Segment, ...] = ()
    elements: tuple[DrawnOutline, ...] = ()
    bar: float = 0.0
    bar_label: str = ""


def ortho_figure(view: FacadeView) -> Figure | None:
    """The ortho-image with a line every metre (fewer when large), labelled x and z in m of the frame."""
    if view.ortho is None:
        return None
    return _elevation(view, view.ortho.extent, data_uri(view.ortho.jpeg, "jpeg"))


def evidence_figure(view: FacadeView, picture: PictureView) -> Figure:
    """A picture of the evidence, in the same way."""
    return _elevation(view, picture.extent, data_uri(picture.png, "png"))


def _elevation(view: FacadeView, extent: tuple[float, float, float, float], href: str) -> Figure:
    x0, z0, x1, z1 = extent
    scale = min(_FIGURE_WIDTH / (x1 - x0), _FIGURE_HEIGHT / (z1 - z0))
    place = partial(to_figure, origin=np.array([x0, z1]), scale=float(scale))
    return Figure(
        width=(x1 - x0) * scale,
        height=(z1 - z0) * scale,
        href=href,
        vertical=_ticks(x0, x1, scale, lambda x: (x - x0) * scale),
        horizontal=_ticks(z0, z1, scale, lambda z: (z1 - z) * scale),
        outline=" ".join(f"{x:.1f},{y:.1f}" for x, y in place(view.facade.outline)),
        elements=outlines(view.elements, place) if view.elements else (),
    )


def street_figure(data: ReportData) -> Figure | None:
    """The street seen from above: every building in its own tint, its name at its longest facade."""
    facades = [f for b in data.buildings for f in b.facades]
    longest = {f.facade.building: f.facade.id for f in sorted(facades, key=_length)}
    labels = [f.facade.building if f.facade.id in longest.values() else "" for f in facades]
    return _plan(data.street, data.street_building, facades, labels)


def building_figure(plan: Float, facades: tuple[FacadeView, ...]) -> Figure | None:
    """One building seen from above, with its facades."""
    labels = [f.facade.id.rpartition("/")[2] for f in facades]
    return _plan(plan, np.zeros(len(plan), np.int64), list(facades), labels)


def _length(view: FacadeView) -> float:
    x0, _, x1, _ = view.facade.extent
    return x1 - x0


def _plan(points: Float, group: Array, facades: list[FacadeView], labels: list[str]) -> Figure | None:
    if not len(points):
        return None
    ends = [facade_ends(view) for view in facades]
    # Stray points can lie a kilometre away: what is shown is the facades and their surroundings.
    shown = np.vstack(ends) if ends else points
    margin = _AROUND if ends else 1.0
    low, high = shown.min(0) - margin, shown.max(0) + margin
    near = ((points >= low) & (points <= high)).all(1)
    points, group = points[near], group[near]
    some = np.vstack([points, shown])
    low, high = np.maximum(some.min(0) - _EDGE, low), np.minimum(some.max(0) + _EDGE, high)
    size = high - low
    scale = min(_FIGURE_WIDTH / size[0], 520.0 / size[1], 30.0)  # one 10 cm point stays 3 px
    pixel = partial(to_figure, origin=np.array([low[0], high[1]]), scale=float(scale))
    bar = nice(size[0] / 5)
    return Figure(
        width=float(size[0] * scale),
        height=float(size[1] * scale),
        href=plan_image(pixel(points), group, size * scale),
        segments=tuple(_segment(v, t, pixel(e)) for v, t, e in zip(facades, labels, ends, strict=True)),
        bar=bar * scale,
        bar_label=f"{bar:g} m",
    )


def to_figure(xy: Float, origin: Float, scale: float) -> Float:
    """Plan (n, 2) m to figure (n, 2) px, y down."""
    return (xy - origin) * (scale, -scale)


def facade_ends(view: FacadeView) -> Float:
    """Both ends of a facade in plan (2, 2) m local, left end first as seen from the street."""
    x0, _, x1, _ = view.facade.extent
    return view.facade.frame.apply(np.array([[x0, 0.0, 0.0], [x1, 0.0, 0.0]]))[:, :2]


def _segment(view: FacadeView, label: str, ends: Float) -> Segment:
    along = ends[1] - ends[0]
    # Right as seen from the street is x; in the figure (y down) the street lies a quarter turn clockwise.
    outward = np.array([-along[1], along[0]]) / max(float(np.hypot(*along)), 1e-9)
    tip = ends.mean(0) + 22 * outward
    (x1, y1), (x2, y2) = ends.tolist()
    return Segment(view.facade.id, label, x1, y1, x2, y2, float(tip[0]), float(tip[1]))


def plan_image(xy: Float, group: Array, size: Float) -> str:
    """Point density as a PNG with a transparent ground; each building has its tint."""
    zoom = min(1.0, _PLAN_PIXELS / float(size.max()))
    w, h = (max(1, math.ceil(v * zoom)) for v in size)
    c, r = np.clip((xy * zoom).astype(np.int64), 0, [w - 1, h - 1]).T
    count = np.bincount(r * w + c, minlength=w * h).reshape(h, w)
    last = np.full(w * h, -1, np.int64)
    order = np.argsort(group, kind="stable")  # buildings are drawn over what belongs to none
    last[(r * w + c)[order]] = group[order]
    tint = np.where(last.reshape(h, w) >= 0, 60 + (last.reshape(h, w) * 67) % 180, 0)
    hsv = np.dstack([tint, np.where(last.reshape(h, w) >= 0, 110, 0), np.full((h, w), 150)]).astype(np.uint8)
    strength = np.clip(90 + 45 * np.log1p(count), 0, 255) * (count > 0)
    image = np.dstack([cv2.cvtColor(hsv, cv2.COLOR_HSV2BGR), strength.astype(np.uint8)])
    return png_uri(image)


def png_uri(image: Array) -> str:
    """A picture (h, w, 4) uint8 BGRA as PNG inside the page."""
    return data_uri(png_bytes(image), "png")


def data_uri(data: bytes, kind: str) -> str:
    """A "png" or "jpeg" inside the page."""
    return f"data:image/{kind};base64," + base64.b64encode(data).decode()


def _ticks(low: float, high: float, scale: float, place: object) -> tuple[Tick, ...]:
    """Lines every metre where they stay 12 px apart, labels where they stay 34 px apart."""
    step = nice(max(1.0, 12 / scale))
    label = nice(max(step, 34 / scale))
    count = range(math.ceil(low / step), math.floor(high / step) + 1)
    values = [k * step for k in count]
    return tuple(Tick(place(v), f"{v:g}" if _multiple(v, label) else "") for v in values)  # type: ignore[operator]


def _multiple(value: float, of: float) -> bool:
    return abs(value / of - round(value / of)) < 1e-6


def nice(value: float) -> float:
    """The smallest of 1, 2, 5 times a power of ten that is not below `value`."""
    power = 10.0 ** math.floor(math.log10(value))
    return next(m * power for m in (1, 2, 5, 10) if m * power >= value * (1 - 1e-9))
