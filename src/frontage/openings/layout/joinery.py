"""Joinery behind a wall: the planes that hold it, and how wide its posts and frames are.

Widths are measured at the points' own places on the plane: a bar that is seen at an angle also hides what is
behind it, as wide as the bar is deep.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Array, Bool, Float, distinct, rising
from frontage.openings.boxes import Box
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.evidence import BARS, Evidence, equal_share

_DEEPEST = 0.5  # m: reveals are less deep
_BIN = 0.01  # m, bin of depths
_AREA = 0.1  # m2 that a plane of joinery holds at least
# share of the expected beams from which a place is likelier joinery (or wall) than a pane, of Poisson hits
FULL = equal_share(BARS, 0.97)
SHADED = 0.2  # share of a wall's beams that joinery returns at least: something hides it from some stations
COLUMNS = 5  # columns of cells, or mean distances of points, over which the columns of a scan even out
_RAIL = 0.03  # m, least width of a frame
_PANE = (0.03, 0.27)  # m beside a post, between which its panes are looked at
_LINTEL = (0.03, 0.1)  # m below the lintel, between which frames are the first that beams meet
_BEFORE = 0.2  # share of the beams there that may end before the plane of the frames


@dataclass(frozen=True, eq=False)
class JoineryPlane:
    """The points at one depth behind the wall.

    own     (2, n) m, x and z of the points themselves, sorted by x
    edges   (2, l) m, x and z of the points on the wall, sorted by x
    before  (2, k) m, x and z of the points between the wall and them, sorted by x
    beyond  (2, m) m, x and z where the beams of the points behind them crossed that depth, sorted by x
    depth   m behind the wall
    y       m, depth in the facade frame
    """

    own: Float
    edges: Float
    before: Float
    beyond: Float
    depth: float
    y: float

    @property
    def stopped(self) -> tuple[Float, Float, Float]:
        """The points that end beams here or before: edges and sides of blades between windows, and frames."""
        return self.edges, self.before, self.own


def joinery_planes(beams: Beams, evidence: Evidence) -> Iterator[JoineryPlane]:
    """Yields the depths behind the wall that hold area, the fullest first."""
    own, depth, level = _behind(beams)
    edges = beams.solid[rising(beams.solid[:, 0])].T
    at = evidence.raster.flat(*own)
    kept = np.flatnonzero(at >= 0)
    kept = kept[rising(own[0, kept])]
    own, depth, level, at = own[:, kept], depth[kept], level[kept], at[kept]
    bins = int(_DEEPEST / _BIN) + 3
    held = np.bincount(distinct(at * bins + (depth / _BIN).astype(np.int64)) % bins, minlength=bins)
    area = np.convolve(held, [1, 1, 1], "same") * evidence.raster.cell**2
    peaks = np.flatnonzero((area == ndimage.maximum_filter1d(area, 5)) & (area > 3.0 * _AREA))
    for k in sorted(peaks.tolist(), key=lambda k: -area[k]):
        middle = (k + 0.5) * _BIN
        on = np.abs(depth - middle) <= beams.least
        if on.any():
            d = float(np.median(depth[on]))
            before = own[:, depth < middle - beams.least]
            yield JoineryPlane(
                own[:, on], edges, before, _beyond(beams, d), d, d + float(np.median(level[on]))
            )


def _behind(beams: Beams) -> tuple[Float, Float, Float]:
    """Returns the places (2, n) m of the points right behind the wall, their depths, and the wall's, m."""
    if not beams.rays:
        near = np.flatnonzero(beams.open_depth < _DEEPEST)
        own = beams.open[near].T
        return own, beams.open_depth[near], beams.depth_at(*own)
    lines = beams.lines
    depth = lines.y - lines.level
    near = np.flatnonzero((depth > beams.least) & (depth < _DEEPEST))
    depth = depth[near]
    return lines.take(near).shifted(depth), depth, lines.level[near]


def _beyond(beams: Beams, depth: float) -> Float:
    """Returns where (2, n) m the beams that ended further behind the wall crossed a depth m, sorted by x."""
    lines = beams.lines
    far = np.flatnonzero(lines.y - lines.level > depth + beams.least)
    place = lines.take(far).shifted(np.full(len(far), depth)) if beams.rays else np.empty((2, 0))
    return place[:, rising(place[0])]


def post_borders(plane: JoineryPlane, piece: Box, evidence: Evidence) -> tuple[float, float] | None:
    """Returns the left and right border m of a piece, from the columns that points fill, or None.

    A blade before the plane may hide the frame on one side (`_with_hidden`).
    """
    x0, z0, x1, z1 = piece
    slack, shy, due = (
        max(2.0 * evidence.raster.cell, _PANE[1] / 2.0),
        0.1 * (z1 - z0),
        due_in(evidence, piece),
    )
    if due <= 0.0:
        return None
    step = 1.0 / np.sqrt(due)
    number = 2 * int(np.ceil((x1 - x0 + 2.0 * slack) / (2.0 * step))) + 1  # odd: one bin is the middle one
    half, middle = number * step / 2.0, (x0 + x1) / 2.0
    around = (middle - half, z0 + shy, middle + half, z1 - shy)
    own, before, passed = (
        np.bincount(((x - around[0]) / step).astype(np.int64), minlength=number)[:number].astype(np.float64)
        for x in (
            points_within(plane.own, around)[0],
            np.concatenate([points_within(some, around)[0] for some in (plane.edges, plane.before)]),
            points_within(plane.beyond, around)[0],
        )
    )
    held, full = own + before, due * step * (z1 - z0 - 2.0 * shy)
    ended, gone = _run(held), _run(passed)
    labels, _ = ndimage.label((ended > FULL * (ended + gone)) & (ended > SHADED * full))
    label = labels[number // 2]
    if label == 0:
        return None
    low, high = _filled(held, passed, labels == label)
    low, high = _with_hidden(low, high, before >= full, held + passed > 0.0)
    return around[0] + low * step, around[0] + high * step


def _with_hidden(low: float, high: float, blade: Bool, seen: Bool) -> tuple[float, float]:
    """Returns the left and right border of a post, in bins, with the frame that a blade hides.

    A post consists of two frames of equal width, with the blade between them. `blade` (n,) are the bins that
    hold it, and `seen` (n,) those that any beam reached. The hidden frame is taken to be as wide as the other
    one, but ends where the first bin is seen.
    """
    first, last = round(low), round(high)
    at = np.flatnonzero(blade[max(first - 1, 0) : last + 1])
    if not len(at):
        return low, high
    middle = max(first - 1, 0) + float(at.mean()) + 0.5
    left, right = middle - low, high - middle
    beyond = seen[: max(first - 1, 0)][::-1], seen[last + 1 :]
    # the bin beside the post, and those beyond it that no beam reached
    unseen_left, unseen_right = (1 + int(np.append(side, True).argmax()) for side in beyond)
    return low - np.clip(right - left, 0.0, unseen_left), high + np.clip(left - right, 0.0, unseen_right)


def _filled(held: Array, passed: Array, run: Bool) -> tuple[float, float]:
    """Returns where the bins (n,) of a `run`, with points `held` and `passed`, begin and end.

    The run is smoothed and therefore longer than the box that fills it, which is as long as the sum of the
    shares that are held. They count from the share of the bins beyond the run on, which panes return as well.
    """
    come = held + passed
    share = held / np.maximum(come, max(float(np.median(come[run])), 1.0))
    k = np.flatnonzero(run)
    beyond = share[~run]
    pane = float(np.median(beyond)) if len(beyond) else 0.0
    filled = np.clip((share - pane) / max(1.0 - pane, 1e-9), 0.0, 1.0)
    low, high = int(k[0]), int(k[-1]) + 1
    middle, half = (low + high) / 2.0, (high - low) // 2
    shared = float(filled[low + half : high - half].sum()) / 2.0  # of a bin in the middle
    left, right = float(filled[low : low + half].sum()), float(filled[high - half : high].sum())
    return middle - left - shared, middle + right + shared


def _run(count: Float) -> Float:
    """Returns the mean of the counts (n,) over the bins around each."""
    return np.asarray(ndimage.uniform_filter1d(count, COLUMNS, mode="constant"))


def beside(x0: float, x1: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Returns where the panes to the left and right of a post are looked at, m."""
    return (x0 - _PANE[1], x0 - _PANE[0]), (x1 + _PANE[0], x1 + _PANE[1])


def is_wall_beside(side: tuple[float, float], piece: Box, evidence: Evidence) -> bool:
    """Returns whether a side of a piece shows wall, or nothing is expected there, and so no pane."""
    pane = _pane(side, piece)
    due = _mean(evidence.expected, evidence, pane)
    return due <= 0.0 or _mean(evidence.solid, evidence, pane) > FULL * due


def _pane(side: tuple[float, float], piece: Box) -> Box:
    """Returns the pane on a side of a piece, without what is near its upper and lower ends."""
    (x0, x1), (_, z0, _, z1) = side, piece
    return x0, z0 + 0.2 * (z1 - z0), x1, z1 - 0.2 * (z1 - z0)


def frame_above(
    plane: JoineryPlane, side: tuple[float, float], piece: Box, lintel: float, evidence: Evidence
) -> float | None:
    """Returns the width m of the frame above the pane beside a post; None without a pane or frame."""
    (x0, x1), (_, z0, _, z1) = side, piece
    pane = _pane(side, piece)
    due, wide = due_in(evidence, pane), x1 - x0
    if points_within(plane.own, pane).shape[1] > FULL * due * wide * (pane[3] - pane[1]):
        return None
    first = points_within(plane.before, (x0, lintel - _LINTEL[1], x1, lintel - _LINTEL[0]))
    if first.shape[1] > _BEFORE * due * wide * (_LINTEL[1] - _LINTEL[0]):
        return None
    return _thickness(plane, (x0, z0, x1, z1), due, down=True)


def frame_below(
    plane: JoineryPlane, side: tuple[float, float], piece: Box, evidence: Evidence
) -> float | None:
    """Returns the width m of the frame below the pane beside a post; None without a frame."""
    (x0, x1), (_, z0, _, z1) = side, piece
    return _thickness(plane, (x0, z0, x1, z1), due_in(evidence, (x0, z0, x1, z1)), down=False)


def _thickness(plane: JoineryPlane, strip: Box, due: float, *, down: bool) -> float | None:
    """Returns the height m of the frame at the upper or lower end of a strip; None without one.

    A wall returns `due` beams per m2 there.
    """
    if due <= 0.0:
        return None
    x0, z0, x1, z1 = strip
    step = 1.0 / np.sqrt(due)
    around = (x0, z0 - (0.0 if down else step), x1, z1 + (step if down else 0.0))
    number = int((around[3] - around[1]) / step) + 1
    own, passed = (
        np.bincount(((around[3] - z if down else z - around[1]) / step).astype(np.int64), minlength=number)
        for z in (points_within(plane.own, around)[1], points_within(plane.beyond, around)[1])
    )
    full = due * step * (x1 - x0)
    labels, found = ndimage.label(_run(own.astype(np.float64)) > FULL * full)
    if not found:
        return None
    low, high = _filled(own, passed, labels == 1)
    return (high - low) * step if (high - low) * step >= _RAIL else None


def points_within(own: Float, box: Box) -> Float:
    """Returns the places (k, m) m within a box. Rows 0 and 1 of `own` (k, n) are x (rising) and z."""
    a, b = np.searchsorted(own[0], [box[0], box[2]])
    some = own[:, a:b]
    return some[:, (some[1] >= box[1]) & (some[1] < box[3])]


def due_in(evidence: Evidence, box: Box) -> float:
    """Returns the beams per m2 that a wall in a box would return."""
    return _mean(evidence.expected, evidence, box) / evidence.raster.cell**2


def _mean(values: Float, evidence: Evidence, box: Box) -> float:
    """Returns the mean of the cells (h, w) that a box touches, with more than a rounding error."""
    ends = (np.array(box).reshape(2, 2) - evidence.raster.corner) / evidence.raster.cell
    (c0, r0), (c1, r1) = np.floor(ends[0] + 1e-6).astype(int), np.ceil(ends[1] - 1e-6).astype(int)
    part = values[max(r0, 0) : max(r1, 0), max(c0, 0) : max(c1, 0)]
    return float(part.mean()) if part.size else 0.0
