"""Places the bars of a chosen layout: positions, widths and depth with standard errors and provenance."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.crossbars.adjust import Adjusted, Known, Shown, adjust
from frontage.crossbars.chosen import Chosen
from frontage.crossbars.division import Line, joined
from frontage.crossbars.extent import whole_bars, within_frame
from frontage.crossbars.observe import Observation, Sight
from frontage.crossbars.readings import Readings, read_edges
from frontage.geometry.arrays import Float
from frontage.model import AXES, Bar, Estimate, Provenance

_FLOOR_M = 0.0015  # of a bar's position: bars are not ideal prisms
_FRONT_M = (0.012, 0.01)  # by which sashes and bars stand behind the front of a frame, and its spread
# Least standard error of the scan's depth: it sees frames, glass and blinds as one surface.
_SCANNED_M = 0.015
_FLAT_M = 0.004  # by which the front faces of the bars of one window lie off one plane, in the mean
_RAIL_M = 0.05  # about the height at which sashes meet
_USUAL_M = (0.15, 0.25)  # depth of frames behind walls, and its spread


def placed_bars(chosen: Chosen) -> tuple[tuple[Bar, ...], Estimate[float] | None]:
    """Returns the bars of a window in their places, and the depth m of their plane behind the wall."""
    seen = chosen.seen
    lines = sorted(joined(chosen.layout.lines), key=lambda one: (one.axis, one.position))
    if not seen.sight.views:
        return _scanned(chosen, within_frame(seen, lines)), seen.sight.depth
    known = _known_depth(seen)
    if not lines:
        return (), Estimate(known.depth, np.array([[known.sigma**2]]), float(len(seen.sight.views)))
    found = _adjusted(chosen, lines, known)
    bars = tuple(
        _bar(line, _provenance(one, chosen.pooled), np.hypot(sigma, _FLOOR_M), np.hypot(width, 2 * _FLOOR_M))
        for one, line, sigma, width in zip(
            lines, within_frame(seen, found.lines), found.sigma, found.sigma_width, strict=True
        )
    )
    return bars, replace(found.depth, covariance=found.depth.covariance + _FLAT_M**2)


def _adjusted(chosen: Chosen, lines: Sequence[Line], known: Known) -> Adjusted:
    """Returns bars in their places."""
    seen, sight = chosen.seen, chosen.seen.sight
    upper, lower = seen.planes
    rail = _rail(chosen, lines)
    whole = whole_bars(seen, lines)
    every = [line if k == rail else wide for k, (line, wide) in enumerate(zip(lines, whole, strict=True))]
    meeting = -np.inf if chosen.meeting is None else chosen.meeting
    depths = [lower if _middle(line) < meeting else upper for line in every]
    readings = read_edges(sight.grid, sight.mask, sight.views, every, depths)
    if rail is not None:
        depths[rail] = lower
        below = read_edges(sight.grid, sight.mask, sight.views, every, depths)
        readings = _with_lower_edge(readings, below, rail)
    tilt, gsd = (np.array([getattr(v, name) for v in sight.views]) for name in ("tilt", "gsd"))
    return adjust(every, readings, Shown(tilt, gsd, pose_sigmas(sight)), upper, known)


def _rail(chosen: Chosen, lines: Sequence[Line]) -> int | None:
    """Returns the number of the meeting rail, whose lower edge is that of the lower sash, if there is one."""
    if chosen.meeting is None:
        return None
    away = [
        abs(line.position - line.width / 2 - chosen.meeting) if line.axis == 1 else np.inf for line in lines
    ]
    k = int(np.argmin(away)) if away else 0
    return k if away and away[k] < _RAIL_M else None


def _with_lower_edge(front: Readings, behind: Readings, rail: int) -> Readings:
    """Returns readings with the lower edge of the meeting rail taken from those on the plane behind."""
    lower = (behind.bar == rail) & (behind.side < 0)
    return front.some((front.bar != rail) | (front.side > 0)).and_more(behind.some(lower))


def _middle(line: Line) -> float:
    """Returns the height z m of the middle of a bar."""
    return line.position if line.axis == 1 else (line.extent[0] + line.extent[1]) / 2


def _known_depth(seen: Observation) -> Known:
    """Returns the depth of the bars as far as it is known before their edges are read.

    What views tell is the depth of all edges, of the frame and of what it holds. A scan measures its front.
    """
    found = seen.sight.depth
    if found is None:
        return Known(*_USUAL_M)
    swept = len(seen.sight.views) > 1
    sigma = float(found.sigma[0]) if swept else max(float(found.sigma[0]), _SCANNED_M)
    return Known(float(found.value) + (0.0 if swept else _FRONT_M[0]), float(np.hypot(sigma, _FRONT_M[1])))


def _scanned(chosen: Chosen, lines: Sequence[Line]) -> tuple[Bar, ...]:
    """Returns bars that only the scan shows."""
    spread = chosen.seen.sight.window.spacing
    sigma, width = float(np.hypot(0.5 * spread, _FLOOR_M)), float(np.hypot(spread, _FLOOR_M))
    return tuple(_bar(line, _provenance(line, chosen.pooled), sigma, width) for line in lines)


def _bar(line: Line, provenance: Provenance, sigma: float, sigma_width: float) -> Bar:
    return Bar(
        AXES[line.axis],
        line.position,
        line.extent,
        line.width,
        float(sigma),
        float(sigma_width),
        provenance,
    )


def _provenance(line: Line, pooled: Sequence[Line]) -> Provenance:
    """Tells whether only similar windows decide a bar, or a piece of it."""
    pieces = (
        one.axis == line.axis
        and abs(one.position - line.position) <= max(one.width, line.width)
        and line.extent[0] - 1e-6 <= one.extent[0] <= one.extent[1] <= line.extent[1] + 1e-6
        for one in pooled
    )
    return Provenance.POOLED if any(pieces) else Provenance.MEASURED


def pose_sigmas(sight: Sight) -> Float:
    """Returns the standard errors (v, 2) m, across x and z, by which poses displace the views on the wall.

    A ray d from a camera that is moved by v and turned by w meets the wall displaced by g . (v + w x d)
    along an axis e, with g = e - n (e . d) / (n . d) and n the wall's normal.
    """
    window = sight.window
    known = {v.photo.id: v.photo for v in window.views}
    x, z = window.ring.mean(0)
    middle = window.frame.apply(np.array([[x, window.wall_y, z]]))[0]
    found = np.zeros((len(sight.views), 2))
    normal = window.frame.R[:, 1]
    for k, view in enumerate(sight.views):
        pose = known[view.name].local_from_camera
        if pose is None or pose.covariance.shape != (6, 6):
            continue
        ray = middle - pose.value.t
        for axis, along in enumerate((window.frame.R[:, 0], window.frame.R[:, 2])):
            g = along - normal * float(along @ ray) / float(normal @ ray)
            J = np.concatenate([g, np.cross(ray, g)])
            found[k, axis] = np.sqrt(max(float(J @ pose.covariance @ J), 0.0))
    return found
