"""The better estimator of window bars: evidence of rectified views, and an exact search over layouts."""

from collections.abc import Sequence

import numpy as np
import shapely

from frontage.crossbars.appearance import eroded, frame_likeness
from frontage.crossbars.border import frame_sides
from frontage.crossbars.depth import frame_depth
from frontage.crossbars.found import WindowEvidence
from frontage.crossbars.layout import Layout, best_layout, joined
from frontage.crossbars.lines import bar_widths, bars_of_views
from frontage.crossbars.options import CrossbarOptions
from frontage.crossbars.profiles import likeness_profiles, view_profiles
from frontage.crossbars.rectify import Grid, PlaneView, WallView, on_wall, outline_mask, window_grid
from frontage.crossbars.window import Window
from frontage.geometry.arrays import Array, Float
from frontage.model import AXES, Bar, Glazing

_PICTURES = 4


def bars_by_evidence(windows: Sequence[Window], options: CrossbarOptions) -> list[WindowEvidence]:
    """Returns the glazing of every window, and what it was chosen from."""
    return [_judge(window, options) for window in windows]


def _judge(window: Window, options: CrossbarOptions) -> WindowEvidence:
    grid = window_grid(window)
    ring = outline_mask(grid, window.ring)
    views = [v for view in window.views if (v := on_wall(window, view, grid, ring)) is not None]
    depth = frame_depth(grid, views, window.opening.depth)
    if not views or depth is None:
        return WindowEvidence(
            window.opening.id, grid.extent, (), None, Glazing(False, note="nothing shows it")
        )
    weights = _weights(views)
    planes = [PlaneView.of(grid, view, depth.value, ring) for view in views]
    profiles = [[view_profiles(grid, view, axis) for view in planes] for axis in (0, 1)]
    arched = window.opening.shape != "rectangle"
    box, width = frame_sides(grid, profiles, weights, window.ring, arched)
    likeness = _likeness(grid, planes, window.ring, box, ring)
    widths = bar_widths(grid.px, min(min(v.gsd) for v in views))
    bars = [
        bars_of_views(
            grid, profiles[a], [likeness_profiles(grid, like, a) for like in likeness], weights, widths
        )
        for a in (0, 1)
    ]
    layout = best_layout(box, bars, options.min_pane)
    glazing = Glazing(True, _bars(layout), width, depth, 0.5, tuple(v.name for v in views), "")
    return WindowEvidence(window.opening.id, grid.extent, _pictures(grid, views, depth.value), None, glazing)


def _likeness(
    grid: Grid, views: Sequence[PlaneView], outline: Float, box: tuple[float, ...], ring: Array
) -> list[Array]:
    """Returns how much every pixel of every view looks like the frame."""
    low, high = outline.min(0), outline.max(0)
    inset = (box[0] - low[0] + high[0] - box[2]) / 2
    inner = np.asarray(shapely.Polygon(outline).buffer(-inset, join_style="mitre").exterior.coords)[:-1]
    panes = outline_mask(grid, inner) > 0.5
    frame = eroded((ring > 0.99) & ~panes)
    return [frame_likeness(v.image, v.inside > 0.9, frame, panes) for v in views]


def _weights(views: Sequence[WallView]) -> Float:
    """Returns the weights (v,) of views by their resolution against the finest."""
    gsd = np.array([np.hypot(*v.gsd) for v in views])
    return np.asarray(np.minimum(1.0, gsd.min() / gsd))


def _bars(layout: Layout) -> tuple[Bar, ...]:
    lines = sorted(joined(layout.lines), key=lambda line: (line.axis, line.position))
    return tuple(Bar(AXES[line.axis], line.position, line.extent, line.width, 0.003, 0.004) for line in lines)


def _pictures(grid: Grid, views: Sequence[WallView], depth: float) -> tuple[tuple[str, Array], ...]:
    shown = views[:_PICTURES]
    return tuple(
        (v.name, np.clip(np.rint(v.at(grid, depth, v.image)[::-1]), 0, 255).astype(np.uint8)) for v in shown
    )
