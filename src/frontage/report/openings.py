"""Openings and protrusions on the page: outlines for SVG, rows of the table, share of windows in the wall."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.geometry.ring import box_sigmas, ring_area, ring_area_sigma
from frontage.model import DOORS, Elements, Facade, Opening, Protrusion, Provenance
from frontage.report.drawing import error_band
from frontage.report.layouts import layout_words
from frontage.report.numbers import Fact
from frontage.report.windows import bar_ring

_ROOM = 26.0  # px that a label needs in its opening


@dataclass(frozen=True)
class DrawnOutline:
    """An element in a figure: SVG points, class, title; paths of its errors' band and of its bars; label."""

    points: str
    css: str
    title: str
    band: str = ""
    bars: str = ""
    label: str = ""
    x: float = 0.0
    y: float = 0.0


@dataclass(frozen=True)
class Row:
    """One element in the table, as text."""

    id: str
    kind: str
    place: str
    size: str
    depth: str
    bars: str
    sigma: str
    provenance: str
    confidence: str


def outlines(elements: Elements, to_pixel: Callable[[Float], Float]) -> tuple[DrawnOutline, ...]:
    """Protrusions below, openings above; `to_pixel` takes (k, 2) m to (k, 2) px."""
    below = [_protrusion(p, to_pixel) for p in elements.protrusions]
    return (*below, *(_opening(o, to_pixel) for o in elements.openings))


def _opening(o: Opening, to_pixel: Callable[[Float], Float]) -> DrawnOutline:
    ring = to_pixel(o.ring)
    (x0, y0), (x1, y1) = ring.min(0), ring.max(0)
    short = o.id.rpartition("/")[2]
    return DrawnOutline(
        points=_points(ring),
        css=str(o.provenance),
        title=f"{o.id}: {o.kind}, {_size(o.ring)}, {o.provenance}",
        band=" ".join(f"M{_points(to_pixel(edge))}Z" for edge in error_band(o)),
        bars=" ".join(f"M{_points(to_pixel(bar_ring(bar)))}Z" for bar in o.bars),
        label=short if x1 - x0 > _ROOM and y1 - y0 > _ROOM / 2 else "",
        x=float(x0 + x1) / 2,
        y=float(y0 + y1) / 2,
    )


def _protrusion(p: Protrusion, to_pixel: Callable[[Float], Float]) -> DrawnOutline:
    title = f"{p.id}: {p.kind}, {_size(p.ring)}, {-float(p.front.value):.2f} m before the wall"
    return DrawnOutline(_points(to_pixel(p.ring)), "protrusion", title)


def _points(ring: Float) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in ring)


def rows(elements: Elements) -> list[Row]:
    """Openings by floor and bay, then protrusions."""
    ordered = sorted(elements.openings, key=lambda o: (o.floor, o.bay, o.id))
    return [_opening_row(o) for o in ordered] + [_protrusion_row(p) for p in elements.protrusions]


def _opening_row(o: Opening) -> Row:
    return Row(
        id=o.id,
        kind=o.kind if o.shape in ("rectangle", "") else f"{o.kind}, {o.shape}",
        place=f"{o.floor}, {o.bay}",
        size=_size(o.ring),
        depth="–" if o.depth is None else _with_sigma(float(o.depth.value), float(o.depth.sigma[0])),
        bars="–" if o.glazing is None else layout_words(o.glazing),
        sigma=_sides(box_sigmas(o.ring, o.ring_covariance)),
        provenance=str(o.provenance) + (f", on {o.on.rpartition('/')[2]}" if o.on else ""),
        confidence=f"{o.confidence:.2f}",
    )


def _protrusion_row(p: Protrusion) -> Row:
    front = _with_sigma(float(p.front.value), float(p.front.sigma[0]))
    sigma = _millimetres(p.sigma)
    return Row(p.id, p.kind, "", _size(p.ring), front, "", sigma, str(p.provenance), f"{p.confidence:.2f}")


def _size(ring: Float) -> str:
    w, h = np.ptp(ring, axis=0)
    return f"{w:.2f} × {h:.2f} m"


def _with_sigma(value: float, sigma: float) -> str:
    """A length in m with its standard error in mm."""
    return f"{value:.3f} m ± {_millimetres(sigma)}"


def _sides(sigmas: Iterable[float]) -> str:
    """Standard errors in mm; one number where all four are alike."""
    texts = [_millimetres(s) for s in sigmas]
    if len(set(texts)) == 1:
        return texts[0]
    return " · ".join(text.removesuffix(" mm") for text in texts) + " mm"


def _millimetres(sigma: float) -> str:
    return f"{1000 * sigma:.0f} mm" if math.isfinite(sigma) else "?"


def opening_facts(facade: Facade, elements: Elements) -> list[Fact]:
    """How many openings, of which kinds; the share of windows in the wall."""
    found = elements.openings
    inferred = sum(o.provenance is Provenance.INFERRED for o in found)
    remark = f"{inferred} of them inferred, never seen" if inferred else ""
    facts = [Fact("Openings", _counts([o.kind for o in found]) or "none found", remark)]
    if elements.protrusions:
        facts.append(Fact("Protrusions", _counts([p.kind for p in elements.protrusions])))
    if found and (share := window_share(facade, elements)) is not None:
        part, sigma, area = share
        error = f"σ {100 * sigma:.2f} % of the borders" if math.isfinite(sigma) else "σ not known"
        remark = f"{error}; the wall shows on {facade.coverage:.0%} of the outline"
        facts.append(Fact("Windows in wall", f"{100 * part:.1f} % ({area:.1f} m²)", remark))
    return facts


def _counts(kinds: list[str]) -> str:
    """ "10 × window, 1 × door": the most frequent first."""
    ordered = sorted(set(kinds), key=lambda kind: (-kinds.count(kind), kind))
    return ", ".join(f"{kinds.count(kind)} × {kind}" for kind in ordered)


def window_share(facade: Facade, elements: Elements) -> tuple[float, float, float] | None:
    """Area of the windows over that of the facade's outline, its standard error, and the area m2.

    Doors, gates and passages are no windows, shop fronts are. The error is that of the windows' borders:
    errors of measured ones are taken as independent, those of pooled and inferred ones as the same for all.
    None without an outline.
    """
    wall = float(shapely.make_valid(shapely.Polygon(facade.outline)).area)
    if wall <= 0:
        return None
    windows = [o for o in elements.openings if o.kind not in DOORS]
    area = sum(ring_area(o.ring) for o in windows)
    sigma = np.array([ring_area_sigma(o.ring, o.ring_covariance) for o in windows])
    own = np.array([o.provenance is Provenance.MEASURED for o in windows], np.bool_)
    error = math.hypot(float(np.linalg.norm(sigma[own])), float(sigma[~own].sum()))
    return area / wall, error / wall, area
