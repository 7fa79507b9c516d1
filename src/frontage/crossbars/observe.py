"""What one window shows: its views on the plane of the frame, the frame, and the evidence of every
possible bar."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import shapely

from frontage.crossbars.appearance import eroded, frame_likeness
from frontage.crossbars.border import frame_sides, scanned_sides, usual_sides
from frontage.crossbars.candidates import Box
from frontage.crossbars.depth import StraightEdges, edges_of, frame_depth
from frontage.crossbars.leaded import leaded
from frontage.crossbars.lines import Bars, bar_widths, bars_of_views, no_views, with_scan
from frontage.crossbars.profiles import Profiles, likeness_profiles, view_profiles
from frontage.crossbars.rectify import Grid, PlaneView, WallView, on_wall, outline_mask, window_grid
from frontage.crossbars.sashes import bar_depths
from frontage.crossbars.scanbars import ScanHits, scan_depth, scan_hits
from frontage.crossbars.window import Window
from frontage.geometry.arrays import Array, Float
from frontage.model import Estimate

# A scan of this spacing places bars as well as photos do. A sparser one counts less beside photos.
_DENSE_M = 0.01
_OBLIQUE = 0.35  # cosine of the angle to the normal at which the sides of bars hide their fronts
_FRONTAL = 0.75


@dataclass(frozen=True, eq=False)
class Sight:
    """A window seen through its outline on the wall: raster, mask of the outline, views with their straight
    edges, and the frame's depth."""

    window: Window
    grid: Grid
    mask: Array = field(repr=False)
    views: tuple[WallView, ...] = field(repr=False)
    edges: tuple[StraightEdges, ...] = field(repr=False)
    depth: Estimate[float] | None

    @property
    def gsd(self) -> float:
        """The size m of a px of the finest photo, in its coarser direction; there must be a view."""
        return min(max(view.gsd) for view in self.views)


@dataclass(frozen=True, eq=False)
class Observation:
    """The evidence of a window.

    sight    the views that it comes from, at the final depth of the frame
    box      x0, z0, x1, z1 m inside the frame
    frame    width of the frame, None where nothing shows it
    bars     evidence of upright bars and of transoms
    behind   the same on the plane of a lower sash that may run behind; None where nothing speaks for one
    rail     evidence of transoms that reach from that plane, below, to the other one
    planes   depths m behind the wall that `bars` and `behind` were looked for at
    like     (s, n) nats across each axis, how much strips look like the frame in the mean of the views
    leaded   what small leaded panes the views show, see `leaded.leaded`; "" without any
    weights  (v,) of the views
    hits     what the scan says; None without points at the frame
    """

    sight: Sight
    box: Box
    frame: Estimate[float] | None
    bars: tuple[Bars, ...]
    behind: tuple[Bars, ...] | None
    rail: Bars | None
    planes: tuple[float, float]
    like: tuple[Array, ...]
    leaded: str
    weights: Float
    hits: ScanHits | None


def look(window: Window) -> Sight:
    """Returns a window with its views on the wall and the depth of its frame."""
    grid = window_grid(window)
    mask = outline_mask(grid, window.ring)
    views = tuple(v for view in window.views if (v := on_wall(window, view, grid, mask)) is not None)
    prior = window.opening.depth if window.opening.depth is not None else scan_depth(window)
    edges = tuple(edges_of(grid, views))
    return Sight(window, grid, mask, views, edges, frame_depth(grid, edges, prior))


def observe(sight: Sight) -> Observation:
    """Returns the evidence of a window whose frame's depth is known. Raises ValueError where it is not."""
    if sight.depth is None:
        raise ValueError("the depth of the frame is not known")
    window, grid = sight.window, sight.grid
    hits = scan_hits(grid, window)
    arched = window.opening.shape != "rectangle"
    if not sight.views:
        box, width = usual_sides(window.ring), None
        if hits is not None:
            exposed = np.array(hits.exposed)
            box, width = scanned_sides(window.ring, exposed, hits.points, hits.dense, arched)
            hits = _within_arch(hits, sight, box, width) if arched else hits
        widths = bar_widths(grid.px, grid.px)
        bars = _with_hits(grid, [no_views(grid, axis, widths) for axis in (0, 1)], hits)
        at = sight.depth.value
        return Observation(sight, box, width, bars, None, None, (at, at), (), "", np.empty(0), hits)
    weights = _weights(sight.views)
    profiles = _profiles(grid, _planes(sight, sight.depth.value))
    box, width = frame_sides(grid, profiles, weights, window.ring, arched)
    hits = _within_arch(hits, sight, box, width) if arched and hits is not None else hits
    upper, lower = bar_depths(grid, sight.edges, sight.depth, box)
    trust = min(1.0, (_DENSE_M / window.spacing) ** 2)
    planes = _planes(sight, upper)
    front = _Plane.of(sight, planes, box)
    bars = _with_hits(grid, [front.bars(grid, axis, weights) for axis in (0, 1)], hits, trust)
    like = tuple(np.tensordot(weights / weights.sum(), np.stack(one), 1) for one in front.like)
    behind = rail = None
    if lower != upper:
        back = _Plane.of(sight, _planes(sight, lower), box)
        behind = _with_hits(grid, [back.bars(grid, axis, weights) for axis in (0, 1)], hits, trust)
        rail = _with_hits(grid, [back.bars(grid, 1, weights, front)], hits, trust)[0]
    mesh = leaded(grid, planes, box)
    return Observation(sight, box, width, bars, behind, rail, (upper, lower), like, mesh, weights, hits)


def _planes(sight: Sight, depth: float) -> list[PlaneView]:
    return [PlaneView.of(sight.grid, view, depth, sight.mask) for view in sight.views]


def _profiles(grid: Grid, planes: Sequence[PlaneView]) -> list[list[Profiles]]:
    return [[view_profiles(grid, view, axis) for view in planes] for axis in (0, 1)]


@dataclass(frozen=True, eq=False)
class _Plane:
    """What the views show on a plane: profiles and likeness with the frame, (s, n) of every view, by axis."""

    widths: Array
    profiles: list[list[Profiles]]
    like: list[list[Array]]

    @staticmethod
    def of(sight: Sight, planes: Sequence[PlaneView], box: Box) -> "_Plane":
        """Returns what the views on one plane show."""
        grid = sight.grid
        likeness = _likeness(planes, sight.window.ring, box, grid, sight.mask)
        widths = bar_widths(grid.px, min(min(v.gsd) for v in sight.views))
        like = [[likeness_profiles(grid, one, axis) for one in likeness] for axis in (0, 1)]
        return _Plane(widths, _profiles(grid, planes), like)

    def bars(self, grid: Grid, axis: int, weights: Float, upper: "_Plane | None" = None) -> Bars:
        """Returns the evidence of bars, on request of those whose higher edges lie on another plane."""
        above = upper.profiles[axis] if upper is not None else None
        return bars_of_views(grid, self.profiles[axis], self.like[axis], weights, self.widths, above)


def _with_hits(
    grid: Grid, bars: Sequence[Bars], hits: ScanHits | None, trust: float = 1.0
) -> tuple[Bars, ...]:
    """Returns the evidence across both axes with that of the scan, which counts for `trust`, 0..1."""
    if hits is not None:
        bars = [
            with_scan(one, trust * hits.evidence(grid, one.axis, one.widths), hits.known(grid, one.axis))
            for one in bars
        ]
    return tuple(bars)


def _within_arch(hits: ScanHits, sight: Sight, box: Box, width: Estimate[float] | None) -> ScanHits:
    """Returns what the scan says inside a frame that follows its outline: the frame itself tells no bars."""
    ring = sight.window.ring
    panes = _panes(sight.grid, ring, _inset(ring, box) if width is None else width.value)
    return hits if panes is None else replace(hits, inside=panes > 0.5)


def _inset(outline: Float, box: Box) -> float:
    """Returns how far m the upright sides of a frame reach in from the outline, in the mean."""
    return float(box[0] - outline[:, 0].min() + outline[:, 0].max() - box[2]) / 2


def _panes(grid: Grid, outline: Float, inset: float) -> Array | None:
    """Returns how much of every pixel (h, w) lies inside a frame that is equally wide on all sides.

    None where such a frame would leave nothing.
    """
    inner = shapely.Polygon(outline).buffer(-inset, join_style="mitre")
    if inner.is_empty or inner.geom_type != "Polygon":
        return None
    return outline_mask(grid, np.asarray(inner.exterior.coords)[:-1])


def _likeness(views: Sequence[PlaneView], outline: Float, box: Box, grid: Grid, ring: Array) -> list[Array]:
    """Returns how much every pixel (h, w) of every view looks like the frame."""
    inner = _panes(grid, outline, _inset(outline, box))
    if inner is None:
        return [np.zeros(grid.shape, np.float32) for _ in views]
    panes = inner > 0.5
    frame = eroded((ring > 0.99) & ~panes)
    return [frame_likeness(v.image, v.inside > 0.9, frame, panes) for v in views]


def _weights(views: Sequence[WallView]) -> Float:
    """Returns the weights (v,) of views: by their resolution, and less where they are slanted."""
    gsd = np.array([max(v.gsd) for v in views])
    cosine = np.array([1.0 / np.sqrt(1.0 + float(v.tilt @ v.tilt)) for v in views])
    frontal = np.clip((cosine - _OBLIQUE) / (_FRONTAL - _OBLIQUE), 0.15, 1.0)
    return np.asarray(np.minimum(1.0, gsd.min() / gsd) * frontal)
