"""Edge points of window borders, and the lines through them (paper B, section 3.2.1, third paragraph)."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Bool, Float, Int

SIDES = ("left", "right", "bottom", "top")
"""The four border types of a window; at its left border, wall points have no neighbour to their right."""

SEARCH = 2.0
"""Search radius over the point distance: "a little higher", so that a raster's diagonal (1.4) is reached."""

_SAMPLE = 20_000  # points whose neighbours tell the point distance
_NEAR = 16  # neighbours that are looked at: all four sides of a point are among them
_STRIP = 60_000  # points whose pairs are held in memory at once


@dataclass(frozen=True)
class BorderLine:
    """A straight run of edge points of one side.

    side      "left" and "right" run upright at x, "bottom" and "top" level at z
    position  m, of the line
    extent    m, from where to where it runs
    count     of its edge points
    """

    side: str
    position: float
    extent: tuple[float, float]
    count: int

    @property
    def upright(self) -> bool:
        """Whether the line is vertical."""
        return self.side in ("left", "right")


def point_distance(xz: Float) -> float:
    """Returns the scan point distance on the facade, m: the median distance to the next point on one side.

    Sides are the four quadrants about the axes, so that a raster gives its pitch; lines of points that lie
    close along the line and far across it count by both. NaN below 16 points.
    """
    if len(xz) < _NEAR:
        return float("nan")
    some = xz[:: len(xz) // _SAMPLE + 1]
    distance, near = cKDTree(xz).query(some, k=_NEAR)
    side = _quadrant(xz[near] - some[:, None])
    nearest = np.stack([np.where((side == k) & (distance > 0), distance, np.inf).min(1) for k in range(4)])
    known = nearest[np.isfinite(nearest)]
    return float(np.median(known)) if len(known) else float("nan")


def edge_points(xz: Float, radius: float) -> Bool:
    """Returns which points (4, n) have no neighbour within `radius` m on the window's side (`SIDES`).

    "The edge points of a left window border are detected if no neighbour measurements to their right side can
    be found in a pre-defined search radius at the facade plane." A neighbour is to the right when its
    direction is within 45 degrees of it: the four border types share the circle.
    """
    order = np.argsort(xz[:, 0], kind="stable")
    x = xz[order, 0]
    has = np.zeros((4, len(xz)), np.bool_)  # a neighbour to the right, left, above, below
    for start in range(0, len(xz), _STRIP):
        low = np.searchsorted(x, x[start] - radius)
        high = np.searchsorted(x, x[min(start + _STRIP, len(x)) - 1] + radius, side="right")
        rows = order[low:high]
        pairs = cKDTree(xz[rows]).query_pairs(radius, output_type="ndarray")
        a, b = rows[pairs[:, 0]], rows[pairs[:, 1]]
        side = _quadrant(xz[b] - xz[a])
        for k, opposite in enumerate((1, 0, 3, 2)):
            has[k, a[side == k]] = True
            has[opposite, b[side == k]] = True
    return ~has


def _quadrant(step: Float) -> Int:
    """Returns 0 right, 1 left, 2 above, 3 below for steps (..., 2) m."""
    dx, dz = step[..., 0], step[..., 1]
    return np.where(np.abs(dx) >= np.abs(dz), np.where(dx > 0, 0, 1), np.where(dz > 0, 2, 3))


def border_lines(xz: Float, edges: Bool, distance: float, shortest: float) -> tuple[BorderLine, ...]:
    """Returns the horizontal and vertical lines "estimated from non-isolated edge points".

    edges     (4, n), of `edge_points`
    distance  m, scan point distance: the edge points of one border scatter over it across the border
    shortest  m, a line is at least so long
    """
    out: list[BorderLine] = []
    for side, mask in zip(SIDES, edges, strict=True):
        along, across = (1, 0) if side in ("left", "right") else (0, 1)
        for chain in _chains(xz[mask][:, [along, across]], distance, shortest):
            out += _straight(chain, side, distance, shortest)
    return tuple(out)


def _chains(points: Float, distance: float, shortest: float) -> list[Float]:
    """Links edge points (n, 2) m (along, across) to the next along the border; drops isolated ones."""
    if len(points) < 2:
        return []
    scaled = points / np.array([SEARCH * distance, distance])
    a, b = cKDTree(scaled).query_pairs(1.0, p=np.inf, output_type="ndarray").T
    n = len(points)
    _, label = connected_components(coo_array((np.ones(len(a), np.int8), (a, b)), (n, n)), directed=False)
    order = np.argsort(label, kind="stable")
    chains = np.split(points[order], np.flatnonzero(np.diff(label[order])) + 1)
    return [c for c in chains if len(c) > 2 and np.ptp(c[:, 0]) >= shortest]


def _straight(chain: Float, side: str, distance: float, shortest: float) -> list[BorderLine]:
    """Returns the straight runs of a chain (n, 2) m: the bands with the most points, one after the other."""
    width = SEARCH * distance
    chain = chain[np.argsort(chain[:, 1], kind="stable")]
    across = chain[:, 1]
    end = np.searchsorted(across, across + width, side="right")
    count = end - np.arange(len(across))
    found: list[BorderLine] = []
    while count.max() > 2:
        k = int(np.argmax(count))
        run = _longest_run(chain[k : end[k]], 2 * width)
        length = float(np.ptp(run[:, 0]))
        if length < shortest:
            break
        if len(run) >= length / width:
            extent = (float(run[:, 0].min()), float(run[:, 0].max()))
            found.append(BorderLine(side, float(np.median(run[:, 1])), extent, len(run)))
        count[(across >= across[k] - width) & (across <= across[k] + width)] = 0  # bands that overlap it
    return found


def _longest_run(points: Float, gap: float) -> Float:
    """Returns the longest piece of points (n, 2) m without a gap along them of more than `gap` m."""
    points = points[np.argsort(points[:, 0], kind="stable")]
    pieces = np.split(points, np.flatnonzero(np.diff(points[:, 0]) > gap) + 1)
    return max(pieces, key=lambda p: float(np.ptp(p[:, 0])))


def partition(
    borders: tuple[BorderLine, ...], upright: bool, ends: tuple[float, float], distance: float
) -> Float:
    """Returns the positions (k,) m of the partition planes across x (`upright`) or z, ends included.

    "Each boundary line defines a partition plane, which is perpendicular to the building facade." Lines
    closer than the point distance cannot be told apart: they make one plane, at their weighted mean.
    """
    lines = [(b.position, b.count) for b in borders if b.upright == upright]
    at, count = np.array(lines, np.float64).reshape(-1, 2).T
    planes: list[float] = []
    free = np.ones(len(at), np.bool_)
    for k in np.argsort(-count, kind="stable"):
        if not free[k]:
            continue
        near = free & (np.abs(at - at[k]) <= distance)
        free &= ~near
        planes.append(float(np.average(at[near], weights=count[near])))
    inner = np.array([p for p in planes if ends[0] + distance < p < ends[1] - distance])
    return np.concatenate([[ends[0]], np.sort(inner), [ends[1]]])
