"""Openings and protrusions by cell decomposition as published (Becker & Haala 2008, sections 3.1 and 3.2)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.geometry.ring import rectangle
from frontage.model.estimate import Estimate, Failed, Provenance
from frontage.model.facade import Facade
from frontage.model.opening import Elements
from frontage.model.scan import Scan
from frontage.openings.options import OpeningOptions
from frontage.openings.paper.availability import AvailabilityMap
from frontage.openings.paper.cells import FACADE_SHARE, Box, Cells, classify, convex_windows
from frontage.openings.paper.edges import (
    SEARCH,
    Border,
    border_lines,
    edge_points,
    partition,
    point_distance,
)
from frontage.openings.paper.nouns import Front, Hole, to_elements
from frontage.openings.paper.shapes import shifted_plane, split_windows, with_head

_FEWEST = 100  # points on the plane
_ON_PLANE = 3.0  # sigmas of the wall's roughness within which a point lies on the facade
_DEEPEST = 3  # protrusions on protrusions


@dataclass(frozen=True, eq=False)
class Decomposition:
    """One set of facade points (n, 2) m cut into cells: what the report draws, like the paper's figures 6, 7.

    edges (4, n) bool by border type; borders: their lines; seen: the availability map; holes: window boxes
    """

    xz: Float
    distance: float
    edges: Bool
    borders: tuple[Border, ...]
    seen: AvailabilityMap
    cells: Cells
    holes: tuple[Box, ...]


def decompose(xz: Float, outline: Float, distance: float, least: tuple[float, float]) -> Decomposition:
    """Edge points, lines, partition planes, cells, their classes, and convex window cells.

    xz        (n, 2) m, the points that count as facade
    outline   (k, 2) m of the facade
    distance  m, scan point distance; least (width, height) m of a window
    """
    edges = edge_points(xz, SEARCH * distance)
    shortest = max(2 * SEARCH * distance, min(least) / 2)
    borders = border_lines(xz, edges, distance, shortest)
    (x0, z0), (x1, z1) = outline.min(0), outline.max(0)
    xs = partition(borders, True, (float(x0), float(x1)), distance)
    zs = partition(borders, False, (float(z0), float(z1)), distance)
    seen = AvailabilityMap.of(xz, outline, distance)
    cells = classify(xs, zs, *seen.share(xs, zs))
    holes = split_windows(convex_windows(cells, least), borders, xz, distance, least)
    return Decomposition(xz, distance, edges, borders, seen, cells, tuple(sorted(holes)))


def facade_cells(facade: Facade, scan: Scan, options: OpeningOptions) -> Decomposition | None:
    """The decomposition that the facade's windows come from (not those of its protrusions), to look at.

    None where too few points lie on the plane.
    """
    q = facade.frame.inverse.apply(scan.xyz[facade.support])
    tolerance = _ON_PLANE * facade.roughness
    distance = point_distance(q[np.abs(q[:, 1]) <= tolerance][:, [0, 2]])
    if not np.isfinite(distance):
        return None
    least = (options.min_width, options.min_height)
    return decompose(q[q[:, 1] <= tolerance][:, [0, 2]], facade.outline, distance, least)


def find_by_paper(facade: Facade, scan: Scan, options: OpeningOptions) -> Elements | Failed:
    """What the facade holds, by the published method on its one plane.

    The same steps run twice, with two readings of "facade points": those on or in front of the plane for the
    windows (section 3.2.1), those on the plane alone for the protrusions (3.2.3); then again inside every
    protrusion. Returns `Failed` (F401) when too few points lie on the plane.
    """
    q = facade.frame.inverse.apply(scan.xyz[facade.support])
    tolerance = _ON_PLANE * facade.roughness
    on = q[np.abs(q[:, 1]) <= tolerance][:, [0, 2]]
    distance = point_distance(on)
    if len(on) < _FEWEST or not np.isfinite(distance):
        return Failed(
            "F401",
            f"facade {facade.id} has {len(on)} points on its plane; openings need {_FEWEST}",
            "use a denser scan",
        )
    holes, fronts = _reconstruct(q, facade.outline, tolerance, options, 0)
    return to_elements(facade, holes, fronts, options)


def _reconstruct(
    q: Float, outline: Float, tolerance: float, options: OpeningOptions, level: int
) -> tuple[list[Hole], list[Front]]:
    """Windows and protrusions of points (n, 3) m before and behind a plane y = 0 with `outline` (k, 2) m."""
    least = (options.min_width, options.min_height)
    behind = q[:, 1] > tolerance
    on = np.abs(q[:, 1]) <= tolerance
    distance = point_distance(q[on][:, [0, 2]])
    if on.sum() < _FEWEST or not np.isfinite(distance):
        return [], []
    windows = decompose(q[~behind][:, [0, 2]], outline, distance, least)
    holes = _with_depth([_hole(box, windows) for box in windows.holes], q[behind], tolerance)
    if level == _DEEPEST:
        return holes, []
    fronts = _fronts(q, on, outline, tolerance, distance, least)
    for front, own in zip(tuple(fronts), _within(q, [f.box for f in fronts]), strict=True):
        x0, z0, x1, z1 = front.box
        holes = [h for h in holes if not (x0 <= h.centre[0] <= x1 and z0 <= h.centre[1] <= z1)]
        moved = own - np.array([0.0, front.y, 0.0])
        inner, outer = _reconstruct(moved, rectangle(*front.box), tolerance, options, level + 1)
        holes += inner
        fronts += [replace(f, y=f.y + front.y) for f in outer]
    return holes, fronts


def _hole(box: Box, d: Decomposition) -> Hole:
    """A window cell with its head, and what the map says of it."""
    share, elements = d.seen.box_share(box)
    raised, rise = with_head(box, d.borders, d.seen)
    return Hole(raised, rise, share, elements, d.distance)


def _with_depth(holes: list[Hole], behind: Float, tolerance: float) -> list[Hole]:
    """The windows with the one depth plane of the facade, from the points (n, 3) behind it in window cells.

    Its sigma holds the scatter of the windows' own depths about it: the paper gives all windows one plane.
    """
    inside = [q[:, 1] for q in _within(behind, [h.box for h in holes])]
    plane = shifted_plane(np.concatenate([np.empty(0), *inside]), tolerance)
    if plane is None:
        return holes
    own = [y[np.abs(y - plane) <= tolerance] for y in inside]
    medians = np.array([np.median(y) for y in own if len(y)])
    sigma = float(np.hypot(np.sqrt(np.mean((medians - plane) ** 2)), tolerance / _ON_PLANE))
    depth = Estimate(plane, np.array([[sigma**2]]), float(sum(map(len, own)) - 1), Provenance.POOLED)
    return [replace(h, depth=depth) for h in holes]


def _fronts(
    q: Float, on: Bool, outline: Float, tolerance: float, distance: float, least: tuple[float, float]
) -> list[Front]:
    """Protrusions: no-data areas "within the set of points that belong to the facade", points before them.

    Section 3.2.3: points in front of the plane are non-facade points; a cell is a protrusion when they fill
    more than 70 % of it; its extent along the normal is that of a plane fitted to them.
    """
    before = q[q[:, 1] < -tolerance]
    if len(before) < _FEWEST:
        return []
    found = decompose(q[on][:, [0, 2]], outline, distance, least)
    seen = AvailabilityMap.of(before[:, [0, 2]], outline, distance)
    fronts: list[Front] = []
    for box, points in zip(found.holes, _within(before, found.holes), strict=True):
        share, _ = seen.box_share(box)
        y = points[:, 1]
        plane = shifted_plane(y, tolerance) if share > FACADE_SHARE else None
        if plane is not None:
            held = y[np.abs(y - plane) <= tolerance]
            fronts.append(
                Front(box, plane, float(held.std() / np.sqrt(len(held))), len(held), share, distance)
            )
    return fronts


def _within(q: Float, boxes: Sequence[Box]) -> list[Float]:
    """The points (k, 3) of (n, 3) that lie before, on or behind each rectangle."""
    q = q[np.argsort(q[:, 0], kind="stable")]
    ends = np.array([(b[0], b[2]) for b in boxes]).reshape(-1, 2)
    first, last = np.searchsorted(q[:, 0], ends[:, 0]), np.searchsorted(q[:, 0], ends[:, 1], side="right")
    strips = (q[a:b] for a, b in zip(first, last, strict=True))
    return [s[(s[:, 2] >= b[1]) & (s[:, 2] <= b[3])] for s, b in zip(strips, boxes, strict=True)]
