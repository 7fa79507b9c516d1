"""How good borders and depths are: charts of their standard errors."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.ring import box_sigmas
from frontage.model import Elements, Provenance

_EDGES_MM = (0, 1, 1.5, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100, np.inf)
_SHOWN = (Provenance.MEASURED, Provenance.POOLED, Provenance.INFERRED)
_WIDTH, _HEIGHT = 420.0, 150.0  # px of a chart


@dataclass(frozen=True)
class Bar:
    """A part of a column of a chart, px, and the class of its colour."""

    x: float
    y: float
    width: float
    height: float
    css: str
    title: str


@dataclass(frozen=True)
class Chart:
    """A distribution of standard errors: bars from below, ticks (px, label), size, title and words."""

    title: str
    bars: tuple[Bar, ...]
    ticks: tuple[tuple[float, str], ...]
    median: float | None
    width: float
    height: float
    words: str


def quality_charts(found: Sequence[Elements]) -> tuple[Chart, ...]:
    """Return the charts of the borders and of the depths of all openings; none without openings."""
    openings = [o for elements in found for o in elements.openings]
    if not openings:
        return ()
    borders = [(s, o.provenance) for o in openings for s in box_sigmas(o.ring, o.ring_covariance)]
    depths = [(float(o.depth.sigma[0]), o.depth.provenance) for o in openings if o.depth is not None]
    return _chart("Borders", borders, 0), _chart("Depths", depths, len(openings) - len(depths))


def _chart(title: str, values: Sequence[tuple[float, Provenance]], lost: int) -> Chart:
    """Draw the standard errors (m); infinite ones, and `lost` values without any, are only told."""
    known = [(1000 * s, p) for s, p in values if np.isfinite(s)]
    sigmas = np.array([s for s, _ in known])
    counts = {p: np.histogram(sigmas[[q is p for _, q in known]], _EDGES_MM)[0] for p in _SHOWN}
    step, most = _WIDTH / (len(_EDGES_MM) - 1), max(int(sum(counts.values()).max()), 1)  # type: ignore[union-attr]
    bars, low = [], np.zeros(len(_EDGES_MM) - 1)
    for p in _SHOWN:
        for k, n in enumerate(counts[p].tolist()):
            if n:
                height = _HEIGHT * n / most
                title_ = f"{n} {p}, {_EDGES_MM[k]:g} to {_EDGES_MM[k + 1]:g} mm"
                bars.append(Bar(k * step, _HEIGHT - low[k] - height, step - 1.5, height, str(p), title_))
                low[k] += height
    ticks = tuple((k * step, f"{v:g}") for k, v in enumerate(_EDGES_MM[:-1]) if k)
    median = _place(float(np.median(sigmas))) * step if len(sigmas) else None
    words = _words(sigmas, len(values) - len(known) + lost)
    return Chart(title, tuple(bars), ticks, median, _WIDTH, _HEIGHT, words)


def _place(mm: float) -> float:
    """Return where a value lies on the axis, in columns."""
    k = int(np.searchsorted(_EDGES_MM, mm, "right")) - 1
    low, high = _EDGES_MM[k], _EDGES_MM[k + 1]
    return k + (mm - low) / (high - low) if np.isfinite(high) else k + 0.5


def _words(sigmas: Float, lost: int) -> str:
    missing = f"; {lost:,} without a value or error" if lost else ""
    if not len(sigmas):
        return f"none is known{missing}"
    half, most = np.quantile(sigmas, (0.5, 0.9))
    known = f"half are known to {half:.1f} mm (line), nine of ten to {most:.1f} mm"
    return f"{len(sigmas):,} values: {known}{missing}"
