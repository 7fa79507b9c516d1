"""The 3-D edges of a window from all photos that see it (paper B, section 3.3.1)."""

from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from frontage.crossbars.paper.matching import match
from frontage.crossbars.paper.plane import FramePlane, centre, frame_plane, pose_sigma
from frontage.crossbars.paper.seen import Sight, seen_edges
from frontage.crossbars.paper.triangulate import NO_EDGES, Edges3D, confirmed, plausible, triangulate
from frontage.crossbars.window import Window, WindowView
from frontage.geometry.arrays import Bool, Float
from frontage.model.estimate import Estimate
from frontage.model.glazing import FRAME_THICKNESS_M

_LEAST_VISIBLE = 0.5  # share of the window that a photo has to show
_EDGE_SIGMA_PX = 0.3  # of an edge in one photo, for choosing pairs
DEPTH_SIGMA_M = FRAME_THICKNESS_M / 12**0.5
"""Standard error of the depth of edges that lie anywhere in the thickness of a frame."""

Pair = tuple[Sight, Sight]
"""Two photos of a window."""

_SIDEWAYS = 0.17  # least cosine of the angle to the wall's normal: 80 degrees


@dataclass(frozen=True, eq=False)
class WindowEdges:
    """The 3-D edges of a window.

    upright  vertical edges in the facade frame
    level    horizontal edges
    plane    of the frame
    sources  names of the photos that took part
    gsd      m per px on the frame's plane of the second finest of them; inf without a pair
    reason   why there are no edges; "" where there are some
    """

    upright: Edges3D = field(repr=False, default=NO_EDGES)
    level: Edges3D = field(repr=False, default=NO_EDGES)
    plane: FramePlane | None = None
    sources: tuple[str, ...] = ()
    gsd: float = np.inf
    reason: str = ""

    def depth(self, wall_y: float) -> Estimate[float] | None:
        """Returns the depth of the frame behind the wall by the edges whose depth the photos determine."""
        if self.plane is None:
            return None
        told = self.upright.sigma[:, 1], self.level.sigma[:, 1]
        good = [s < self.plane.sigma / 2 for s in told]
        behind = np.concatenate([self.upright.behind[good[0]], self.level.behind[good[1]]])
        if len(behind) < 2:
            return None
        middle = float(np.median(behind))
        spread = 1.4826 * float(np.median(np.abs(behind - middle)))
        # Pairs share photos: the edges count as one per photo.
        count = min(len(behind), len(self.sources))
        own = float(np.median(np.concatenate([s[g] for s, g in zip(told, good, strict=True)])))
        sigma = float(np.hypot(spread, own) / np.sqrt(count))
        return Estimate(self.plane.y + middle - wall_y, np.array([[sigma**2]]), float(count - 1))


def derive_edges(window: Window, least: float) -> WindowEdges:
    """Returns the 3-D edges of a window from all pairs of photos with a sensible baseline.

    The vertical edges, whose depth photos taken along a street determine, first tell the plane of the frame
    better than the scan.

    least  m, width of the least pane: photos whose pose is worse than a quarter of it are not used
    """
    plane = frame_plane(window)
    views = [v for v in window.views if _is_usable(v, window, plane, least)]
    if len(views) < 2:
        return WindowEdges(reason=_too_few(window, len(views)))
    pairs = list(combinations([Sight.of(v, window, plane) for v in views], 2))
    told = _baselines(pairs, window, plane) <= DEPTH_SIGMA_M
    pairs, told = [p for p, t in zip(pairs, told, strict=True) if t.any()], told[told.any(1)]
    if not pairs:
        return WindowEdges(reason="the photos that show it stand too close together")
    if told[:, 0].any():
        plane = _plane_by_edges(_edges(window, plane, pairs, told, 0, least), plane)
    upright, level = (_edges(window, plane, pairs, told, axis, least) for axis in (0, 1))
    used = {s.view.photo.id: s.view for pair in pairs for s in pair}
    gsd = sorted(v.gsd / v.cosine for v in used.values())[1]
    reason = "" if len(upright) + len(level) else "no edge of it was found in two photos"
    return WindowEdges(upright, level, plane, tuple(sorted(used)), gsd, reason)


def _too_few(window: Window, usable: int) -> str:
    """Says why a window's photos, of which `usable` can be used, give no edges in space."""
    if not window.views:
        return "no photo shows it"
    if len(window.views) == 1:
        return "only one photo shows it; edges in space need two"
    return f"of the {len(window.views)} photos that show it {usable} can be used; edges in space need two"


def _is_usable(view: WindowView, window: Window, plane: FramePlane, least: float) -> bool:
    """Whether a photo shows enough of a window, not too obliquely, from a pose that is known well enough."""
    if view.visible < _LEAST_VISIBLE or view.cosine < _SIDEWAYS:
        return False
    return bool((pose_sigma(view, window, plane) <= least / 4).all())


def _baselines(pairs: list[Pair], window: Window, plane: FramePlane) -> Float:
    """Returns how well pairs of photos see the depth of edges across x and across z: (n, 2) m, one sigma."""
    middle = window.ring.mean(0)
    out = np.empty((len(pairs), 2))
    for row, (a, b) in zip(out, pairs, strict=True):
        c, d = centre(a.view, window), centre(b.view, window)
        parallax = (middle - d[[0, 2]]) / (plane.y - d[1]) - (middle - c[[0, 2]]) / (plane.y - c[1])
        error = _EDGE_SIGMA_PX * np.hypot(a.view.gsd / a.view.cosine, b.view.gsd / b.view.cosine)
        row[:] = error / np.maximum(np.abs(parallax), 1e-9)
    return out


def _edges(
    window: Window, plane: FramePlane, pairs: list[Pair], told: Bool, axis: int, least: float
) -> Edges3D:
    """Returns the vertical (`axis` 0) or horizontal (1) 3-D edges of all pairs of photos.

    Pairs that see the depth of these edges (`told`) are used where there are any. Where there are none, as
    for transoms in photos taken at one height and distance, all pairs are, and the frame's plane stands in.
    Where several pairs are used, an edge counts that two of them found.
    """
    sights = {id(s): s for pair in pairs for s in pair}
    step = max(s.view.gsd for s in sights.values())
    seen = {k: seen_edges(s, plane.y, axis, step, least / 2) for k, s in sights.items()}
    use = told[:, axis] if told[:, axis].any() else np.ones(len(pairs), np.bool_)
    parts = [NO_EDGES]
    for k in np.flatnonzero(use):
        a, b = (seen[id(s)] for s in pairs[k])
        edges = triangulate(a, b, match(a, b, plane), plane, int(k))
        parts.append(edges.kept(plausible(edges, window.ring, axis)))
    found = Edges3D.joined(parts)
    return found.kept(confirmed(found)) if use.sum() > 1 else found


def _plane_by_edges(upright: Edges3D, plane: FramePlane) -> FramePlane:
    """Returns the plane of the longest vertical edges; the given one where their depth is not told."""
    good = upright.kept(upright.sigma[:, 1] < DEPTH_SIGMA_M)
    if len(good) < 2:
        return plane
    near = np.abs(good.behind[:, None] - good.behind) <= DEPTH_SIGMA_M
    best = near[np.argmax(near @ np.diff(good.along)[:, 0])]
    behind = good.behind[best]
    scatter = float(np.hypot(behind.std(), np.median(good.sigma[best, 1])))
    return FramePlane(plane.y + float(np.mean(behind)), scatter)
