"""Compares found window bars with true ones, window by window, and sums up."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from _common import bootstrap, figure, rate_interval
from frontage.evaluation.bars import joined, match_bars
from frontage.model import AXES, Bar, Glazing
from frontage.model.built import TrueBar

NEAR_M = 0.02  # a bar found is the true one up to this distance
_COVERED = 0.7  # share of a bar's length that the other side must have, too
HEADER = (
    "windows", "exact layout", "decided", "exact where decided", "precision", "recall", "position rmse mm",
    "width rmse mm", "depth rmse mm", "NEES position", "NEES depth", "confidence - exact",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class TrueLayout:
    """The true bars of a window; depth (m) of its frame where known; only bars in `within` are judged.

    glazing   "bars", "radial", "leaded" as in `BuiltOpening`
    within    x0, z0, x1, z1 m; None = the whole window
    complete  whether all bars are known; otherwise only recall is judged
    light     x0, z0, x1, z1 m within the frame: bars found that run on to the border of the opening end there
    """

    bars: tuple[TrueBar, ...]
    glazing: str = "bars"
    depth: float | None = None
    within: tuple[float, float, float, float] | None = None
    complete: bool = True
    light: tuple[float, float, float, float] | None = None


@dataclass(frozen=True, eq=False)
class Judged:
    """How one window came out; the case is what windows are not independent within (a house).

    exact      None where there is no layout to be right about (leaded, not completely known)
    hits, found, seen, true   numbers of right bars found, of all found, of true bars found, of all true ones
    errors     (m, 2) position errors and their sigmas of the bars that are right; widths (k,) their errors
    depth      error and sigma, or None
    """

    case: str
    window: str
    exact: bool | None
    resolved: bool
    confidence: float
    hits: int
    found: int
    seen: int
    true: int
    errors: np.ndarray = field(repr=False)
    widths: np.ndarray = field(repr=False)
    depth: tuple[float, float] | None = None
    note: str = ""


def judge(case: str, window: str, truth: TrueLayout, glazing: Glazing | None) -> Judged:
    """Compare the glazing found with the truth; None counts as not decided."""
    glazing = glazing or Glazing(False)
    bars = [_cut(_cut(b, truth.light), truth.within) for b in glazing.bars if _inside(b, truth.within)]
    true = [_cut(_cut(b, truth.light), truth.within) for b in truth.bars]
    hits, seen = _covered(bars, true), _covered(true, bars)
    errors, widths = _errors(bars, true)
    exact: bool | None = None
    if truth.complete and truth.glazing != "leaded":
        exact = glazing.resolved and _same(bars, true)
    depth = None
    if truth.depth is not None and glazing.depth is not None:
        depth = (float(glazing.depth.value) - truth.depth, float(glazing.depth.sigma[0]))
    found = len(bars) if truth.complete and truth.glazing != "leaded" else 0
    return Judged(
        case, window, exact, glazing.resolved, glazing.confidence, sum(hits) if found else 0, found,
        sum(seen), len(truth.bars), errors, widths, depth, glazing.note,
    )  # fmt: skip


def _same(found: Sequence[Bar], true: Sequence[TrueBar]) -> bool:
    rows = [
        [joined([(b.position, *b.extent) for b in bars if b.axis == axis]) for axis in AXES]
        for bars in (true, found)
    ]
    return all(match_bars(t, f)[2] for t, f in zip(*rows, strict=True))


def _cut(bar: Bar, light: tuple[float, float, float, float] | None) -> Bar:
    """The part of a bar that lies within the frame, or within the part of a window that is judged."""
    if light is None:
        return bar
    x0, z0, x1, z1 = light
    low, high = (z0, z1) if bar.axis == "vertical" else (x0, x1)
    a, b = (min(max(end, low), high) for end in bar.extent)
    return replace(bar, extent=(a, b)) if b > a else bar


def _inside(bar: Bar, within: tuple[float, float, float, float] | None) -> bool:
    if within is None:
        return True
    x0, z0, x1, z1 = within
    low, high = (x0, x1) if bar.axis == "vertical" else (z0, z1)
    a, b = (z0, z1) if bar.axis == "vertical" else (x0, x1)
    shared = min(bar.extent[1], b) - max(bar.extent[0], a)
    return low - NEAR_M <= bar.position <= high + NEAR_M and shared > 0


def _covered(bars: Sequence[Bar | TrueBar], others: Sequence[Bar | TrueBar]) -> list[bool]:
    """Whether pieces of the others cover most of each bar, at most 2 cm beside it."""
    out = []
    for bar in bars:
        near = [o for o in others if o.axis == bar.axis and abs(o.position - bar.position) <= NEAR_M]
        shared = sum(
            max(0.0, min(o.extent[1], bar.extent[1]) - max(o.extent[0], bar.extent[0])) for o in near
        )
        out.append(shared >= _COVERED * (bar.extent[1] - bar.extent[0]))
    return out


def _errors(found: Sequence[Bar], true: Sequence[TrueBar]) -> tuple[np.ndarray, np.ndarray]:
    """Position errors with sigmas (m, 2) and width errors (m,) of bars found near a true one they overlap."""
    rows, widths = [], []
    for bar in found:
        near = [
            (abs(t.position - bar.position), k)
            for k, t in enumerate(true)
            if t.axis == bar.axis and min(t.extent[1], bar.extent[1]) - max(t.extent[0], bar.extent[0]) > 0.05
        ]
        if near and min(near)[0] <= NEAR_M:
            own = true[min(near)[1]]
            rows.append((bar.position - own.position, bar.sigma))
            widths.append(bar.width - own.width)
    return np.array(rows).reshape(-1, 2), np.array(widths)


def summary(judged: Sequence[Judged]) -> list[str]:
    """The cells of `HEADER` for some windows."""
    asked = [j for j in judged if j.exact is not None]
    decided = [j for j in asked if j.resolved]
    errors = np.concatenate([np.empty((0, 2)), *(j.errors for j in judged)])
    widths = np.concatenate([np.empty(0), *(j.widths for j in judged)])
    depths = np.array([j.depth for j in judged if j.depth is not None]).reshape(-1, 2)
    return [
        str(len(asked)),
        _share(sum(bool(j.exact) for j in asked), len(asked)),
        _share(len(decided), len(asked)),
        _share(sum(bool(j.exact) for j in decided), len(decided)),
        _share(sum(j.hits for j in judged), sum(j.found for j in judged)),
        _share(sum(j.seen for j in judged), sum(j.true for j in judged)),
        _rms(1000 * errors[:, 0]),
        _rms(1000 * widths),
        _rms(1000 * depths[:, 0]),
        _nees(errors),
        _nees(depths),
        _calibration(decided),
    ]


def _share(hits: int, total: int) -> str:
    return figure(tuple(100 * v for v in rate_interval(hits, total)), "%") if total else "-"


def _rms(values: np.ndarray) -> str:
    return figure(bootstrap(values, lambda v: float(np.sqrt((v**2).mean())))) if len(values) > 2 else "-"


def _nees(rows: np.ndarray) -> str:
    """Mean squared error over variance: 1 where sigmas are right."""
    known = rows[np.isfinite(rows).all(1) & (rows[:, 1] > 0)]
    if len(known) < 3:
        return "-"
    return figure(bootstrap((known[:, 0] / known[:, 1]) ** 2, np.mean))


def _calibration(decided: Sequence[Judged]) -> str:
    """Mean confidence less the share that is right, in percent: 0 where the confidences are right."""
    gap = np.array([j.confidence - float(bool(j.exact)) for j in decided])
    return figure(bootstrap(100 * gap, np.mean), "%") if len(gap) > 2 else "-"


def reliability(judged: Sequence[Judged]) -> list[list[str]]:
    """Rows of confidence classes: windows, mean confidence, share that is right."""
    decided = [j for j in judged if j.exact is not None and j.resolved]
    rows = []
    for low, high in ((0.0, 0.5), (0.5, 0.8), (0.8, 0.95), (0.95, 0.99), (0.99, 1.01)):
        own = [j for j in decided if low <= j.confidence < high]
        if own:
            mean = f"{np.mean([j.confidence for j in own]):.3f}"
            rows.append([f"{low:g} - {min(high, 1):g}", str(len(own)), mean,
                         _share(sum(bool(j.exact) for j in own), len(own))])  # fmt: skip
    return rows
