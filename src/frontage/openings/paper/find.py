"""The published method from points to openings and protrusions (Becker & Haala 2008, 3.1 and 3.2)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.geometry.ring import rectangle
from frontage.model.estimate import Estimate, Failed, Provenance
from frontage.model.facade import Facade
from frontage.model.opening import Elements
from frontage.model.scan import Scan
from frontage.openings.boxes import Box
from frontage.openings.options import OpeningOptions
from frontage.openings.paper.availability import AvailabilityMap
from frontage.openings.paper.cells import FACADE_SHARE, Cells, classify, convex_windows
from frontage.openings.paper.edges import (
    SEARCH,
    BorderLine,
    border_lines,
    edge_points,
    partition,
    point_distance,
)
from frontage.openings.paper.nouns import ProtrusionCell, WindowCell, to_elements
from frontage.openings.paper.shapes import shifted_plane, split_windows, with_head

_FEWEST = 100  # points that a plane needs
_ON_PLANE = 3.0  # sigmas of the wall's roughness within which a point lies on the facade
_DEEPEST = 3  # levels of protrusions on protrusions


@dataclass(frozen=True, eq=False)
class Decomposition:
    """One set of facade points cut into cells: what the paper's figures 6 and 7 show.

    xz        (n, 2) m, the points
    distance  m, scan point distance
    edges     (4, n) bool, edge points by border type
    borders   the lines through them
    seen      the availability map
    cells     the cells and their classes
    holes     boxes of the windows
    """

    xz: Float
    distance: float
    edges: Bool
    borders: tuple[BorderLine, ...]
    seen: AvailabilityMap
    cells: Cells
    holes: tuple[Box, ...]


def decompose(xz: Float, outline: Float, distance: float, least: tuple[float, float]) -> Decomposition:
    """Cuts facade points into cells and classes them (sections 3.2.1 and 3.2.2).

    xz        (n, 2) m, the points that count as facade
    outline   (k, 2) m of the facade
    distance  m, scan point distance
    least     width and height m of the smallest window
    """
    edges = edge_points(xz, SEARCH * distance)  # 3.2.1, cell generation
    shortest = max(2 * SEARCH * distance, min(least) / 2)
    borders = border_lines(xz, edges, distance, shortest)
    (x0, z0), (x1, z1) = outline.min(0), outline.max(0)
    xs = partition(borders, True, (float(x0), float(x1)), distance)
    zs = partition(borders, False, (float(z0), float(z1)), distance)
    seen = AvailabilityMap.of(xz, outline, distance)  # 3.2.2, classification
    cells = classify(xs, zs, *seen.share(xs, zs))
    holes = split_windows(convex_windows(cells, least), borders, xz, distance, least)
    return Decomposition(xz, distance, edges, borders, seen, cells, tuple(sorted(holes)))


def find_by_paper(
    facade: Facade, scan: Scan, options: OpeningOptions
) -> tuple[Elements, Decomposition] | Failed:
    """Finds what the facade holds by the published method on its one plane, and the cells that it came from.

    The same steps run twice, with two readings of "facade points": those on or in front of the plane for the
    windows (section 3.2.1), those on the plane alone for the protrusions (3.2.3); then again inside every
    protrusion. The cells are those of the facade's windows. Returns `Failed` F401 when too few points lie on
    the plane.
    """
    q = facade.frame.inverse.apply(scan.xyz[facade.support])
    wall = _Wall(q, facade.outline, _ON_PLANE * facade.roughness, (options.min_width, options.min_height))
    if not wall.is_measured:
        return Failed(
            "F401",
            f"facade {facade.id} has {int(wall.on.sum())} points on its plane; openings need {_FEWEST}",
            "use a denser scan",
        )
    windows = wall.windows()
    holes, fronts = _reconstruct(wall, windows, 0)
    return to_elements(facade, holes, fronts, options), windows


@dataclass(frozen=True, eq=False)
class _Wall:
    """Points q (n, 3) m in front of and behind a plane y = 0 with an outline (k, 2) m.

    tolerance  m, distance from the plane within which a point lies on it
    least      width and height m of the smallest opening
    """

    q: Float
    outline: Float
    tolerance: float
    least: tuple[float, float]

    @cached_property
    def on(self) -> Bool:
        """Which of the points lie on the plane (n,)."""
        return np.asarray(np.abs(self.q[:, 1]) <= self.tolerance)

    @cached_property
    def distance(self) -> float:
        """Scan point distance on the plane, m; NaN where too few points determine it."""
        return point_distance(self.q[self.on][:, [0, 2]])

    @property
    def is_measured(self) -> bool:
        """Whether enough points lie on the plane."""
        return bool(self.on.sum() >= _FEWEST and np.isfinite(self.distance))

    @property
    def behind(self) -> Bool:
        """Which of the points lie behind the plane (n,)."""
        return np.asarray(self.q[:, 1] > self.tolerance)

    def windows(self) -> Decomposition:
        """Cuts the facade into cells by the points on and in front of the plane (section 3.2.1)."""
        return decompose(self.q[~self.behind][:, [0, 2]], self.outline, self.distance, self.least)

    def inside(self, front: ProtrusionCell, points: Float) -> "_Wall":
        """Returns the front of a protrusion as a wall of its own, with the `points` (k, 3) m about it."""
        moved = points - np.array([0.0, front.y, 0.0])
        return _Wall(moved, rectangle(*front.box), self.tolerance, self.least)


def _reconstruct(
    wall: _Wall, windows: Decomposition, level: int
) -> tuple[list[WindowCell], list[ProtrusionCell]]:
    """Returns the windows and protrusions of a wall, and of its protrusions recursively."""
    holes = _with_depth([_hole(box, windows) for box in windows.holes], wall.q[wall.behind], wall.tolerance)
    if level == _DEEPEST:
        return holes, []
    fronts = _fronts(wall)
    for front, own in zip(tuple(fronts), _within(wall.q, [f.box for f in fronts]), strict=True):
        x0, z0, x1, z1 = front.box
        holes = [h for h in holes if not (x0 <= h.centre[0] <= x1 and z0 <= h.centre[1] <= z1)]
        part = wall.inside(front, own)
        if part.is_measured:
            inner, outer = _reconstruct(part, part.windows(), level + 1)
            holes += inner
            fronts += [replace(f, y=f.y + front.y) for f in outer]
    return holes, fronts


def _hole(box: Box, d: Decomposition) -> WindowCell:
    """Makes a window cell with its head and what the map says of it."""
    share, elements = d.seen.box_share(box)
    raised, rise = with_head(box, d.borders, d.seen)
    return WindowCell(raised, rise, share, elements, d.distance)


def _with_depth(holes: list[WindowCell], behind: Float, tolerance: float) -> list[WindowCell]:
    """Returns the windows with the one depth plane of the facade, from the points (n, 3) m in their cells.

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


def _fronts(wall: _Wall) -> list[ProtrusionCell]:
    """Returns the protrusions: no-data areas "within the set of points that belong to the facade".

    Section 3.2.3: points in front of the plane are non-facade points; a cell is a protrusion when they fill
    more than 70 % of it; its extent along the normal is that of a plane fitted to them.
    """
    before = wall.q[wall.q[:, 1] < -wall.tolerance]
    if len(before) < _FEWEST:
        return []
    found = decompose(wall.q[wall.on][:, [0, 2]], wall.outline, wall.distance, wall.least)
    seen = AvailabilityMap.of(before[:, [0, 2]], wall.outline, wall.distance)
    fronts: list[ProtrusionCell] = []
    for box, points in zip(found.holes, _within(before, found.holes), strict=True):
        share, _ = seen.box_share(box)
        y = points[:, 1]
        plane = shifted_plane(y, wall.tolerance) if share > FACADE_SHARE else None
        if plane is not None:
            held = y[np.abs(y - plane) <= wall.tolerance]
            sigma = float(held.std() / np.sqrt(len(held)))
            fronts.append(ProtrusionCell(box, plane, sigma, len(held), share, wall.distance))
    return fronts


def _within(q: Float, boxes: Sequence[Box]) -> list[Float]:
    """Returns the points (k, 3) m of (n, 3) that lie before, on or behind each rectangle."""
    q = q[np.argsort(q[:, 0], kind="stable")]
    ends = np.array([(b[0], b[2]) for b in boxes]).reshape(-1, 2)
    first, last = np.searchsorted(q[:, 0], ends[:, 0]), np.searchsorted(q[:, 0], ends[:, 1], side="right")
    strips = (q[a:b] for a, b in zip(first, last, strict=True))
    return [s[(s[:, 2] >= b[1]) & (s[:, 2] <= b[3])] for s, b in zip(strips, boxes, strict=True)]
