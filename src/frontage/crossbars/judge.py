"""From the chosen layout to the glazing: standard errors, confidence, and whether the photos resolve it at
all."""

from collections.abc import Sequence

import numpy as np

from frontage.crossbars.division import Layout, Line, joined
from frontage.crossbars.layout import COST
from frontage.crossbars.observe import Observation
from frontage.geometry.arrays import Float
from frontage.model import AXES, Bar, Glazing, Provenance

THIN_BAR_M = 0.025  # width of usual glazing bars
THICK_BAR_M = 0.05  # width of usual mullions
_RESOLVED_PX = 2.5  # px of the finest photo that a bar needs, so that it has two edges
_NATS = 3.0  # that make a decision as sure as one nat of independent evidence: strips and views share errors
_EDGE_PX = 0.3  # standard error of an edge in one view, px of the photo
_FLOOR_M = 0.0015  # of a bar's position: bars are not ideal prisms
_FEWEST_HITS = 10.0  # points of the scan that a thin bar over the window must get
_CERTAIN = 0.99  # probability that nothing shows in a window because nothing is there
_SURE = 0.5  # confidence below which a layout is not decided


def glazing(seen: Observation, layout: Layout, pooled: Sequence[Line] = (), note: str = "") -> Glazing:
    """Returns the glazing of a window.

    pooled  the lines of the layout that only similar windows decide
    note    what else to say about it
    """
    depth, sources = seen.sight.depth, tuple(v.name for v in seen.sight.views)
    sources += ("scan",) if seen.hits is not None else ()
    blurred = _unresolved(seen)
    confidence = probability(layout)
    notes = [blurred] if blurred else [n for n in (*_remarks(seen), note) if n]
    if not blurred and confidence < _SURE and not pooled:
        blurred = "the evidence does not decide between layouts"
        notes.insert(0, blurred)
    if blurred:
        return Glazing(False, (), seen.frame, depth, 1.0 - confidence, sources, "; ".join(notes))
    chosen = set(pooled)
    bars = [
        _bar(seen, line, Provenance.POOLED if line in chosen else Provenance.MEASURED)
        for line in sorted(joined(layout.lines), key=lambda one: (one.axis, one.position))
    ]
    return Glazing(True, tuple(bars), seen.frame, depth, confidence, sources, "; ".join(notes))


def probability(layout: Layout) -> float:
    """Returns the probability of a layout against those with one bar less or one more."""
    bars = [line.evidence - COST for line in joined(layout.lines)]
    gains = np.array([*bars, *(-r for r in layout.rivals)])
    return float(np.prod(1.0 / (1.0 + np.exp(-gains / _NATS)))) if len(gains) else _CERTAIN


def _unresolved(seen: Observation) -> str:
    """Returns why bars cannot be seen at all, in words; "" where they can."""
    views = seen.sight.views
    if views:
        gsd = min(max(v.gsd) for v in views)
        if _RESOLVED_PX * gsd <= THICK_BAR_M:
            return ""
        what = f"pixels of {gsd * 1000:.0f} mm do not resolve bars of {THICK_BAR_M * 1000:.0f} mm"
    else:
        what = "no photo shows it"
    if seen.hits is None:
        return what
    hits = _expected_hits(seen)
    if hits >= _FEWEST_HITS and seen.hits.contrast > 1.0:
        return ""
    scan = (
        f"the scan has {hits:.0f} points on a thin bar"
        if seen.hits.contrast > 1.0
        else ("the scan does not tell panes from bars")
    )
    return f"{what}; {scan}"


def _expected_hits(seen: Observation) -> float:
    """Returns how many scan points a thin bar over the shorter side of the window gets."""
    x0, z0, x1, z1 = seen.box
    return float(seen.hits.dense * THIN_BAR_M * min(x1 - x0, z1 - z0)) if seen.hits is not None else 0.0


def _remarks(seen: Observation) -> list[str]:
    """Returns what to be careful about."""
    views = seen.sight.views
    if not views:
        return []
    remarks = []
    gsd = min(max(v.gsd) for v in views)
    if _RESOLVED_PX * gsd > THIN_BAR_M:
        thin = _RESOLVED_PX * gsd * 1000
        remarks.append(f"bars thinner than {thin:.0f} mm would not show in pixels of {gsd * 1000:.0f} mm")
    if len(views) == 1:
        remarks.append("only one photo shows it, the depth of its frame is not checked")
    return remarks


def _bar(seen: Observation, line: Line, provenance: Provenance) -> Bar:
    sigma, sigma_width = _sigmas(seen, line.axis)
    return Bar(AXES[line.axis], line.position, line.extent, line.width, sigma, sigma_width, provenance)


def _sigmas(seen: Observation, axis: int) -> tuple[float, float]:
    """Returns the standard errors m of the position of a bar and of its width."""
    depth = seen.sight.depth
    sigma_depth = float(depth.sigma[0]) if depth is not None else 0.0
    views, weights = seen.sight.views, seen.weights
    if not views:
        spread = seen.sight.window.spacing
        return float(np.hypot(0.5 * spread, _FLOOR_M)), float(np.hypot(spread, _FLOOR_M))
    share = weights / weights.sum()
    gsd = np.array([v.gsd[axis] for v in views])
    edges = float(np.sqrt((share**2 * (_EDGE_PX * gsd) ** 2).sum()))
    tilt = abs(float(share @ np.array([v.tilt[axis] for v in views])))
    pose = float(np.sqrt((share**2 * _pose_sigmas(seen, axis) ** 2).sum()))
    position = float(np.sqrt(edges**2 + (tilt * sigma_depth) ** 2 + pose**2 + _FLOOR_M**2))
    return position, float(np.sqrt(2 * edges**2 + seen.sight.grid.px**2 / 6 + (2 * _FLOOR_M) ** 2))


def _pose_sigmas(seen: Observation, axis: int) -> Float:
    """Returns the standard errors (v,) m on the wall that the poses of the photos cause along an axis."""
    window = seen.sight.window
    direction = window.frame.R[:, 0 if axis == 0 else 2]
    known = {v.photo.id: v.photo for v in window.views}
    found = []
    for view in seen.sight.views:
        pose = known[view.name].local_from_camera
        if pose is None or pose.covariance.shape != (6, 6):
            found.append(0.0)
            continue
        moved = float(direction @ pose.covariance[:3, :3] @ direction)
        turned = float(np.trace(pose.covariance[3:, 3:])) / 3 * view.distance**2
        found.append(float(np.sqrt(max(moved + turned, 0.0))))
    return np.array(found)
