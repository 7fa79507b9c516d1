"""Bands of windows without masonry between them: finds the posts of joinery that part them."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float, Int, distinct, rising
from frontage.model.masonry import MASONRY
from frontage.openings.boxes import Box
from frontage.openings.layout.posts import Post
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.evidence import Evidence
from frontage.openings.wall.raster import opened

_DEEPEST = 0.5  # m: reveals are less deep
_BIN = 0.01  # m, bin of depths
_AREA = 0.1  # m2 that a plane of joinery holds at least
# share of the expected beams from which a place is likelier joinery (or wall) than a pane, of Poisson hits
_FULL = float((0.97 - 0.12) / np.log(0.97 / 0.12))
_SHADED = 0.2  # share of a wall's beams that joinery returns at least: something hides it from some stations
_TALL = 0.3  # m: as windows are at least; lower pieces are rails and panels
_WIDE = 0.6  # m: leaves of doors are wider than posts
_FRAMES = 1.7  # widths of the frame above: windows side by side have one each, casements that meet less
_COLUMNS = 5  # columns of cells, or mean distances of points, over which the columns of a scan even out
_RAIL = 0.03  # m, least width of a frame
_PANE = (0.03, 0.27)  # m beside a post, between which its panes are looked at
_LINTEL = (0.03, 0.1)  # m below the lintel, between which frames are the first that beams meet
_BEFORE = 0.2  # share of the beams there that may end before the plane of the frames
# m: the windows of a band are at least as wide; leaves of one window that meet at a post are narrower
_WINDOW = 0.9
_GAP = 0.15  # m between a post and the wall above and below it
_STEEP = 2.0  # m that sills hide per m of depth
_HIDDEN = 0.5  # share of the expected beams that come at most where something before the wall hides a sill


@dataclass(frozen=True, eq=False)
class _Plane:
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


def find_posts(beams: Beams, evidence: Evidence, ground: float) -> tuple[Post, ...]:
    """Finds the posts that part windows; `ground` is the height z m of the ground, where no sill is needed.

    A window has posts of its own where casements meet: they are narrower than two frames side by side, or its
    leaves are narrower than windows. Widths are measured at the points' own places on the plane of the
    frames, for seen aslant a bar seems as wide as it is deep.
    """
    solid, due = _evened(evidence.solid), _evened(evidence.expected)
    shaded, pier = _SHADED * due, max(int(MASONRY.half_brick / evidence.raster.cell), 1)
    wall = opened(solid > _FULL * np.maximum(due, 1e-9), (1, pier))
    edges = beams.solid[rising(beams.solid[:, 0])].T
    free = (evidence.expected > 0.0) & ~wall
    found: list[Post] = []
    beside: list[list[float]] = []
    for plane in _planes(beams, evidence, edges):
        ended = solid + _evened(evidence.raster.count(*np.hstack(plane.stopped[1:])))
        passed = _evened(evidence.raster.count(*plane.beyond))
        full = (ended > _FULL * (ended + passed)) & (ended > shaded) & free
        uprights = list(_uprights(full, evidence.raster.cell))
        for part in uprights:
            post = _post(plane, part, wall, evidence, ground)
            if post is not None and not any(_meet(post, other) for other in found):
                found.append(post)
                beside.append([] if beams.rays else _like(post, plane, uprights, evidence))
    rooms = [_room(p, found, like, wall, evidence) for p, like in zip(found, beside, strict=True)]
    return tuple(p for p, room in zip(found, rooms, strict=True) if room >= _WINDOW)


def _evened(values: Float) -> Float:
    """Averages values (h, w) over half a brick: columns of points from several stations heap up."""
    return np.asarray(cv2.blur(values, (_COLUMNS, 3), borderType=cv2.BORDER_CONSTANT))


def _planes(beams: Beams, evidence: Evidence, edges: Float) -> Iterator[_Plane]:
    """Yields the depths behind the wall that hold area, the fullest first."""
    own, depth, level = _behind(beams)
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
            yield _Plane(own[:, on], edges, before, _beyond(beams, d), d, d + float(np.median(level[on])))


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


def _uprights(full: Bool, cell: float) -> Iterator[tuple[slice, slice]]:
    """Yields the rows and columns of tall and narrow pieces of the cells (h, w) that a plane fills."""
    tall = opened(full, (max(int(_TALL / cell), 2), 1))
    for rows, columns in ndimage.find_objects(ndimage.label(tall)[0]):
        if MASONRY.half_brick - cell <= (columns.stop - columns.start) * cell <= _WIDE:
            yield rows, columns


def _like(post: Post, plane: _Plane, uprights: list[tuple[slice, slice]], evidence: Evidence) -> list[float]:
    """Returns the middles x m of the uprights beside a post that are wider than one of its two frames.

    Of equal mullions some seem as wide as two frames and some do not, but all of them part leaves. Where
    lines of sight are known, the beams that pass tell their widths, and this is not asked.
    """
    found = []
    for rows, columns in uprights:
        x0, z0, x1, z1 = piece = evidence.raster.box(rows.start, columns.start, rows.stop, columns.stop)
        beside = x0 > post.x1 or x1 < post.x0
        if beside and min(z1, post.z1) - max(z0, post.z0) > (post.z1 - post.z0) / 2.0:
            across = _across(plane, piece, evidence)
            if across is not None and across[1] - across[0] > (post.x1 - post.x0) / _FRAMES:
                found.append((x0 + x1) / 2.0)
    return found


def _post(
    plane: _Plane, part: tuple[slice, slice], wall: Bool, evidence: Evidence, ground: float
) -> Post | None:
    """Returns the post in a part of the cells, None if it is not one.

    A post runs from a sill to a lintel and is as wide as two frames.
    """
    (rows, columns), cell, z = part, evidence.raster.cell, evidence.raster.corner[1]
    middle = (columns.start + columns.stop) // 2
    below = slice(max(rows.start - int((_GAP + _STEEP * plane.depth) / cell) - 1, 0), rows.start)
    above = wall[rows.stop : rows.stop + int(_GAP / cell) + 2, middle]
    sill = wall[below, middle][::-1]
    veiled = evidence.expected[below, middle].sum() < _HIDDEN * evidence.expected_free[below, middle].sum()
    low = z + rows.start * cell < ground + MASONRY.threshold
    if not above.any() or not (sill.any() or low or veiled):
        return None
    piece = evidence.raster.box(rows.start, columns.start, rows.stop, columns.stop)
    lintel = piece[3] + int(above.argmax()) * cell
    across = _across(plane, piece, evidence)
    if across is None or across[1] - across[0] < MASONRY.half_brick:
        return None
    frames = [_frame(plane, s, piece, lintel, evidence) for s in _sides(*across)]
    if None in frames or across[1] - across[0] < _FRAMES * max(f or 0.0 for f in frames):
        return None
    foot = int(sill.argmax()) if sill.any() else 0  # nothing lies below the raster
    return Post(across[0], piece[1] - foot * cell, across[1], lintel, plane.y)


def _across(plane: _Plane, piece: Box, evidence: Evidence) -> tuple[float, float] | None:
    """Returns the left and right border m of a piece, from the columns that points fill, or None."""
    x0, z0, x1, z1 = piece
    slack, shy, due = 2.0 * evidence.raster.cell, 0.1 * (z1 - z0), _due(evidence, piece)
    if due <= 0.0:
        return None
    around, step = (x0 - slack, z0 + shy, x1 + slack, z1 - shy), 1.0 / np.sqrt(due)
    x = np.concatenate([_within(some, around)[0] for some in plane.stopped])
    column, other = (
        ((v - x0 + slack) / step).astype(np.int64) for v in (x, _within(plane.beyond, around)[0])
    )
    number = int((x1 - x0 + 2.0 * slack) / step) + 1
    held, passed = _run(column, number), _run(other, number)
    enough = _SHADED * due * step * (z1 - z0 - 2.0 * shy)
    labels, _ = ndimage.label((held > _FULL * (held + passed)) & (held > enough))
    own = labels[min(int(((x1 - x0) / 2 + slack) / step), len(labels) - 1)] if len(labels) else 0
    if own == 0:
        return None
    return _span(x[labels[column] == own])


def _run(bins: Int, number: int) -> Float:
    """Counts the points (number,) of each bin, as the mean over the bins around it."""
    count = np.bincount(bins, minlength=number).astype(np.float64)
    return np.asarray(ndimage.uniform_filter1d(count, _COLUMNS, mode="constant"))


def _sides(x0: float, x1: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Returns where the panes to the left and right of a post are looked at, m."""
    return (x0 - _PANE[1], x0 - _PANE[0]), (x1 + _PANE[0], x1 + _PANE[1])


def _frame(
    plane: _Plane, side: tuple[float, float], piece: Box, lintel: float, evidence: Evidence
) -> float | None:
    """Returns the width m of the frame above the pane beside a post; None without a pane or frame."""
    (x0, x1), (_, z0, _, z1) = side, piece
    pane = (x0, z0 + 0.2 * (z1 - z0), x1, z1 - 0.2 * (z1 - z0))
    due, wide = _due(evidence, pane), x1 - x0
    most = _FULL * due * wide * (pane[3] - pane[1])
    solid = _mean(evidence.solid, evidence, pane) / evidence.raster.cell**2
    if due <= 0.0 or solid > _FULL * due or _within(plane.own, pane).shape[1] > most:
        return None
    first = _within(plane.before, (x0, lintel - _LINTEL[1], x1, lintel - _LINTEL[0]))
    if first.shape[1] > _BEFORE * due * wide * (_LINTEL[1] - _LINTEL[0]):
        return None
    step = 1.0 / np.sqrt(due)
    down = z1 + step - _within(plane.own, (x0, z0, x1, z1 + step))[1]
    row = (down / step).astype(np.int64)
    labels, number = ndimage.label(_run(row, int(row.max(initial=0)) + 1) > _FULL * due * step * wide)
    low, high = _span(down[labels[row] == 1]) if number else (0.0, 0.0)
    return high - low if high - low >= _RAIL else None


def _span(places: Float) -> tuple[float, float]:
    """Returns the ends of what places (n,) m fill evenly, without a few strays; (0, 0) of none."""
    if not len(places):
        return 0.0, 0.0
    low, high = _quantile(places := np.sort(places), 0.05), _quantile(places, 0.95)
    return low - (high - low) / 18.0, high + (high - low) / 18.0


def _quantile(rising: Float, share: float) -> float:
    """Returns a quantile of rising values (n,), as numpy does, whose own takes longer than all else here."""
    at = share * (len(rising) - 1)
    k = int(at)
    low, high = float(rising[k]), float(rising[min(k + 1, len(rising) - 1)])
    t = at - k
    return low + (high - low) * t if t < 0.5 else high - (high - low) * (1.0 - t)


def _within(own: Float, box: Box) -> Float:
    """Returns those of the places (2, n) m, sorted by x, that lie in a box."""
    a, b = np.searchsorted(own[0], [box[0], box[2]])
    some = own[:, a:b]
    return some[:, (some[1] >= box[1]) & (some[1] < box[3])]


def _due(evidence: Evidence, box: Box) -> float:
    """Returns the beams per m2 that a wall in a box would return."""
    return _mean(evidence.expected, evidence, box) / evidence.raster.cell**2


def _mean(values: Float, evidence: Evidence, box: Box) -> float:
    """Returns the mean of the cells (h, w) that a box touches."""
    cell, (x, z) = evidence.raster.cell, evidence.raster.corner
    c0, r0, c1, r1 = (int((v - o) // cell) for v, o in zip(box, (x, z, x, z), strict=True))
    part = values[max(r0, 0) : max(r1 + 1, 0), max(c0, 0) : max(c1 + 1, 0)]
    return float(part.mean()) if part.size else 0.0


def _room(post: Post, posts: list[Post], like: list[float], wall: Bool, evidence: Evidence) -> float:
    """Returns the width m of the narrower window beside a post.

    It reaches as far as the next post, the next upright at one of the x m `like` it, or the wall.
    """
    cell, (x, z) = evidence.raster.cell, evidence.raster.corner
    rows = wall[max(int((post.z0 - z) / cell), 0) : int((post.z1 - z) / cell) + 1]
    jambs = x + (np.flatnonzero(rows.mean(0) > _FULL) + 0.5) * cell
    others = [p.middle for p in posts if p is not post and min(p.z1, post.z1) > max(p.z0, post.z0)]
    ends = np.concatenate([jambs, others, like, [x, x + wall.shape[1] * cell]])
    return float(np.abs(ends - post.middle).min())


def _meet(a: Post, b: Post) -> bool:
    """Returns whether two posts overlap."""
    return min(a.x1, b.x1) > max(a.x0, b.x0) and min(a.z1, b.z1) > max(a.z0, b.z0)
