"""From the chosen layout to the glazing: standard errors, confidence, and whether the photos resolve it at
all."""

import numpy as np

from frontage.crossbars.candidates import COST
from frontage.crossbars.chosen import Chosen
from frontage.crossbars.layout import NESTED
from frontage.crossbars.observe import Observation
from frontage.crossbars.place import placed_bars
from frontage.model import Glazing

THIN_BAR_M = 0.025  # width of usual glazing bars
THICK_BAR_M = 0.05  # width of usual mullions
_RESOLVED_PX = 2.5  # px of the finest photo that a bar needs, so that it has two edges
_NATS = 10.5  # that make a decision as sure as one nat of independent evidence
_DESCRIBED = 0.97  # probability that a division is one of those that are looked for, before it is seen
_SCANNED_LEAST, _SCANNED_NATS = 8.0, 13.5  # nats of a scan alone: margin that is as good as none, and scale
_LEAST_EXPOSED = 0.5  # share of a window that must be exposed to the scanner
_LEAST_CONTRAST = 1.0  # nats
_SURE = 0.5  # confidence below which a layout is not decided


def glazing(chosen: Chosen, margin: float) -> Glazing:
    """Returns the glazing of a window; `margin` nats separate its layout from the next, see `rivals`."""
    seen = chosen.seen
    sources = tuple(v.name for v in seen.sight.views) + (("scan",) if seen.hits is not None else ())
    blurred = _unresolved(chosen)
    confidence = 0.0 if blurred else probability(margin, not seen.sight.views)
    notes = [blurred] if blurred else _remarks(seen)
    if not blurred and confidence < _SURE:
        blurred = "the evidence does not decide between layouts"
        notes.insert(0, blurred)
    if blurred:
        return Glazing(False, (), seen.frame, seen.sight.depth, confidence, sources, "; ".join(notes))
    bars, depth = placed_bars(chosen)
    return Glazing(True, bars, seen.frame, depth, confidence, sources, "; ".join(notes))


def probability(margin: float, scanned: bool = False) -> float:
    """Returns the probability of a layout that is by some nats better than the next different one.

    The next one is taken for the only rival. Strips and views have errors in common, so that a nat of theirs
    counts for less than one; and whatever the margin, some windows are not divided in a way that is looked
    for. Points of a scan alone have fewer errors in common, but curtains and hidden parts of a window divide
    it, too. All figures were fitted to simulated houses (docs/results/crossbars.md).

    scanned  whether the scan alone shows the window
    """
    if scanned:
        return float(_DESCRIBED / (1.0 + np.exp((_SCANNED_LEAST - margin) / _SCANNED_NATS)))
    return float(_DESCRIBED / (1.0 + np.exp(-margin / _NATS)))


def _unresolved(chosen: Chosen) -> str:
    """Returns why bars cannot be seen at all, in words; "" where they can."""
    seen = chosen.seen
    views = seen.sight.views
    if views:
        gsd = seen.sight.gsd
        if _RESOLVED_PX * gsd <= THICK_BAR_M:
            return ""
        what = f"pixels of {gsd * 1000:.0f} mm do not resolve bars of {THICK_BAR_M * 1000:.0f} mm"
    else:
        what = "no photo shows it"
    if seen.hits is None:
        return what
    exposed = seen.hits.exposed_share(seen.sight.window.ring)
    if exposed < _LEAST_EXPOSED:
        return f"{what}; the scanner sees {exposed:.0%} of its frame"
    if seen.hits.contrast <= _LEAST_CONTRAST:
        return f"{what}; the scan does not tell panes from bars"
    if _thinnest(seen, chosen.members) <= THICK_BAR_M:
        return ""
    return f"{what}; the scan is too sparse for bars of {THICK_BAR_M * 1000:.0f} mm"


def _thinnest(seen: Observation, windows: int = 1) -> float:
    """Returns the width m of the thinnest bar over the window that the scan tells from a pane.

    The points on several windows that share their layout add up.
    """
    x0, z0, x1, z1 = seen.box
    if seen.hits is None:
        return np.inf
    dense = seen.hits.dense * windows
    nats = seen.hits.contrast - 1.0 + np.exp(-seen.hits.contrast)  # of every point on it
    enough = (COST + NESTED) / nats / dense / min(x1 - x0, z1 - z0)
    return float(max(enough, dense**-0.5))  # thinner ones may pass between the points


def _remarks(seen: Observation) -> list[str]:
    """Returns what to be careful about."""
    views = seen.sight.views
    if not views:
        thin = _thinnest(seen)  # the windows of a floor have the same rows of points
        return [f"the scan may miss bars thinner than {thin * 1000:.0f} mm"] if thin > THIN_BAR_M else []
    remarks = []
    gsd = seen.sight.gsd
    if _RESOLVED_PX * gsd > THIN_BAR_M:
        thin = _RESOLVED_PX * gsd * 1000
        remarks.append(f"bars thinner than {thin:.0f} mm would not show in pixels of {gsd * 1000:.0f} mm")
    if len(views) == 1:
        remarks.append("only one photo shows it, the depth of its frame is not checked")
    return remarks
