"""Pieces that stand out of a wall: connected points before it, cut into flat fronts."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float, Int, distinct
from frontage.openings.boxes import Box
from frontage.openings.protrusions.boxes import cells_of, extent, occupied, within
from frontage.openings.protrusions.checks import is_framed
from frontage.openings.protrusions.mouldings import find_moulding
from frontage.openings.protrusions.resolution import Resolution

_CONTRAST = 2.0  # times the area of the slabs beside it: a front is a surface, foliage fills a volume
# share of the fullest line of cells below which a tail is not part of a front (light, then strict)
_TAIL, _HEAVY = 0.1, 0.5
_FRONTS = 12  # flat fronts of one connected piece, at most
_CHEEK = 1.75  # times its projection that slanting cheeks reach beyond a front: at 30 degrees to the wall
_AT_WALL, _RUN = 0.4, 0.25  # share of the projection: cheeks end so near the wall, and run so far at least
_ALONG = 0.6  # share of a front's side, and of their own run, that these show on
_FEWEST, _REFITS = 10, 3  # points of a cheek; fits of its line
_PANELS = 0.25  # share of the points beside a front that lie on its cheek: windows leave that much wall


@dataclass(frozen=True, eq=False)
class Piece:
    """Something before the wall.

    rows        (k,) rows of its points
    front_rows  (m,) rows of the points on the front itself
    box         m, its rough box
    y           m, depth of its front
    cheeks      rows of slanting surfaces that run back to the wall, by side (left, below, right, above)
    inclined    whether it is a slanting plane without an upright front
    curved      whether it is a moulding
    """

    rows: Int
    front_rows: Int
    box: Box
    y: float
    cheeks: Mapping[int, Int] = field(default_factory=dict)
    inclined: bool = False
    curved: bool = False


def find_pieces(q: Float, resolution: Resolution) -> list[Piece]:
    """Returns the pieces among points (n, 3) m before a wall y = 0, the largest fronts of a part first."""
    found: list[Piece] = []
    for rows in connected(q, resolution.gap, 3):
        (x0, _, z0), (x1, _, z1) = q[rows].min(0), q[rows].max(0)
        if max(x1 - x0, z1 - z0) >= resolution.least[0]:
            found += _cut(q, rows, resolution.near((float(x0), float(z0), float(x1), float(z1))))
    return found


def connected(q: Float, gap: float, least: int) -> Iterator[Int]:
    """Yields the rows of points (n, d) m that are connected: cells of `gap` m touch, corners included."""
    if len(q) == 0:
        return
    key = cells_of(q, gap)
    shape = key.max(0) + 1
    held = np.zeros(shape, np.bool_)
    held[tuple(key.T)] = True
    labels, _ = ndimage.label(held, np.ones((3,) * q.shape[1], np.bool_))
    label = labels[tuple(key.T)]
    order = np.argsort(label, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(label[order])) + 1):
        if len(rows) >= least:
            yield rows


def _cut(q: Float, rows: Int, resolution: Resolution) -> list[Piece]:
    """Returns the flat fronts of a connected part, each with what lies behind it, or the part as a whole.

    The largest front comes first: it takes what its rectangle covers from the front to the wall. What is left
    over beside it as cheeks or roofs widens it.
    """
    free, left = np.ones(len(rows), np.bool_), np.ones(len(rows), np.bool_)
    found: list[Piece] = []
    p = q[rows]
    for _ in range(_FRONTS):
        y = _peak(p[free], resolution)
        if y is None:
            break
        on = np.flatnonzero(free & (np.abs(p[:, 1] - y) <= resolution.half))
        for part in sorted(connected(p[on][:, [0, 2]], resolution.gap, 10), key=len, reverse=True):
            around = extent(p[on[part]], resolution.cell, _TAIL)
            if not _large(around, resolution):
                continue
            near = np.flatnonzero(free & within(p, around, resolution.cell))
            shape = fit_front(p[near], y, resolution)
            if shape is None:
                continue
            at, front, box = shape
            own = near[within(p[near], box, resolution.cell) & (p[near, 1] >= at - resolution.half)]
            free[own] = left[own] = False
            piece, taken = _widened(q, Piece(rows[own], rows[near[front]], box, at), rows, free, resolution)
            found.append(piece)
            free &= ~taken
            left &= ~taken
        free[on] = False
    return (found + _moulded(q, rows[left], resolution)) or _inclined(q, rows, resolution)


def _moulded(q: Float, rows: Int, resolution: Resolution) -> list[Piece]:
    """Returns the mouldings and round bays among what the flat fronts left over of a connected part."""
    found: list[Piece] = []
    for part in connected(q[rows][:, [0, 2]], resolution.gap, 30):
        own = rows[part]
        while (shape := find_moulding(q[own], resolution)) is not None:
            on, front, box, y = shape
            found.append(Piece(own[on], own[front], box, y, curved=True))
            own = own[~on]
    return found


def _peak(p: Float, resolution: Resolution) -> float | None:
    """Returns the depth y m that holds most cells of the facade among points (n, 3) m, or None."""
    if len(p) < 10:
        return None
    width = resolution.half
    low = float(p[:, 1].min()) - width
    level = ((p[:, 1] - low) / (width / 2)).astype(np.int64)
    across = cells_of(p[:, [0, 2]], resolution.cell)
    size = int(level.max()) + 1
    held = distinct((across[:, 0] * (across[:, 1].max() + 1) + across[:, 1]) * size + level) % size
    area = np.convolve(np.bincount(held, minlength=size), [0.5, 1.0, 1.0, 0.5], "same")
    best = int(area.argmax())
    if area[best] * resolution.cell**2 < resolution.least[0] * resolution.least[1]:
        return None
    near = p[np.abs(p[:, 1] - (low + best * width / 2)) <= width, 1]
    return float(np.median(near)) if len(near) else None


def fit_front(p: Float, y: float, resolution: Resolution) -> tuple[float, Bool, Box] | None:
    """Fits the front of points (n, 3) m at about y m; None when it is not a framed surface.

    Returns its own depth y m, which points lie on it, and its box. Of a front with thin parts (brackets below
    a ledge) the full part alone may be the front.
    """
    near = np.abs(p[:, 1] - y) <= 2.0 * resolution.half
    own = _peak(p[near], resolution)
    at = y if own is None else own
    front = near & (np.abs(p[:, 1] - at) <= resolution.half)
    if not front.any():
        return None
    for tail in (_TAIL, _HEAVY):
        box = extent(p[front], resolution.cell, tail)
        if not _large(box, resolution):
            return None
        held = within(p, box, resolution.cell) & (p[:, 1] >= at - resolution.half)
        flat = front & within(p, box, 0.0)
        if is_framed(p[held], p[flat], box, resolution) and _is_surface(p, at, box, resolution):
            return at, flat, box
    return None


def _large(box: Box, resolution: Resolution) -> bool:
    """Returns whether a box is large enough for a front."""
    sides = sorted((box[2] - box[0], box[3] - box[1]))
    return sides[1] >= resolution.least[0] and sides[0] >= resolution.least[1]


def _is_surface(p: Float, y: float, box: Box, resolution: Resolution) -> bool:
    """Returns whether the front at y m stands out from slabs of its thickness before and behind it."""
    inside = p[within(p, box, 0.0)]
    if not len(inside):
        return False
    across = cells_of(inside[:, [0, 2]], resolution.cell)
    flat = across[:, 0] * (across[:, 1].max(initial=0) + 1) + across[:, 1]

    def area(at: float) -> int:
        """Counts the cells that hold points of the slab at the depth `at` m."""
        return len(distinct(flat[np.abs(inside[:, 1] - at) <= resolution.half]))

    beside = [
        np.median([area(y + 2.0 * sign * k * resolution.half) for k in (2, 3, 4, 5)]) for sign in (-1, 1)
    ]
    return area(y) >= _CONTRAST * float(max(beside))


def _widened(q: Float, piece: Piece, rows: Int, free: Bool, resolution: Resolution) -> tuple[Piece, Bool]:
    """Returns the piece with the cheeks and roofs beside it, and which of the rows (n,) these take.

    Cheeks are `free` points along most of a side that run back from its front to the wall.
    """
    p = q[rows]
    near = free & (p[:, 1] >= piece.y - resolution.half) & within(p, piece.box, -_CHEEK * piece.y)
    box, cheeks, taken = list(piece.box), {}, np.zeros(len(rows), np.bool_)
    for side in range(4):
        axis, other = (0, 2) if side % 2 == 0 else (2, 0)
        lo, hi = piece.box[1 - side % 2], piece.box[3 - side % 2]
        beyond = p[:, axis] < box[side] if side < 2 else p[:, axis] > box[side]
        own = near & beyond & (p[:, other] >= lo - resolution.cell) & (p[:, other] <= hi + resolution.cell)
        line = _cheek(p[own, 1], p[own, axis], piece, box[side], resolution)
        if line is None:
            continue
        off = (p[:, axis] - line[0] - line[1] * p[:, 1]) * (-1.0 if side < 2 else 1.0)
        cheek = own & (np.abs(off) <= resolution.half)
        end = float(np.quantile(p[cheek, axis], 0.01 if side < 2 else 0.99))
        long = occupied(p[cheek, other], resolution.gap) * resolution.gap >= _ALONG * (hi - lo)
        # a slanting surface wider than the front itself is a soffit or a roof, not a cheek
        if long and abs(end - box[side]) <= piece.box[side % 2 + 2] - piece.box[side % 2]:
            box[side] = end
            cheeks[side] = rows[cheek]
            taken |= own & (off <= resolution.half)
    own_rows = np.concatenate([piece.rows, rows[taken]])
    return replace(piece, rows=own_rows, box=(box[0], box[1], box[2], box[3]), cheeks=cheeks), taken


def _cheek(
    y: Float, s: Float, piece: Piece, edge: float, resolution: Resolution
) -> tuple[float, float] | None:
    """Returns the line s = at + slope y of a cheek from the front's edge to the wall; None without one.

    Many of the points (k,) at depths y m and places s m across lie on it; those of windows in a cheek lie
    within.
    """
    far = y > (1.0 - _RUN) * piece.y
    if far.sum() < _FEWEST:
        return None
    slopes = np.sort((s[far] - edge) / (y[far] - piece.y))
    wide = 2.0 * (resolution.half + resolution.cell) / -piece.y
    first = float(slopes[int((np.searchsorted(slopes, slopes + wide) - np.arange(len(slopes))).argmax())])
    on = np.abs(s - edge - (first + wide / 2) * (y - piece.y)) <= resolution.half + resolution.cell
    for _ in range(_REFITS):
        if on.sum() < max(_FEWEST, _PANELS * len(y)):
            return None
        at, slope, _ = fit_slanted_line(y[on], s[on])
        on = np.abs(s - at - slope * y) <= resolution.half
    if not on.any():
        return None
    run = float(np.ptp(y[on]))
    reaches = y[on].max() >= _AT_WALL * piece.y and run >= _RUN * -piece.y
    reaches &= occupied(y[on], resolution.gap) * resolution.gap >= _ALONG * run
    return (at, slope) if reaches and abs(at + slope * piece.y - edge) <= resolution.gap else None


def fit_slanted_line(y: Float, s: Float) -> tuple[float, float, float]:
    """Fits the line s = at + slope y to places (k,) m, k > 1; returns at, slope and the spread m.

    The slope is Theil's, over pairs of the near and the far half.
    """
    order = np.argsort(y, kind="stable")
    y, s = y[order], s[order]
    half = max(len(y) // 2, 1)
    slope = float(np.median((s[-half:] - s[:half]) / np.maximum(y[-half:] - y[:half], 1e-3)))
    rest = s - slope * y
    at = float(np.median(rest))
    return at, slope, 1.4826 * float(np.median(np.abs(rest - at)))


def _inclined(q: Float, rows: Int, resolution: Resolution) -> list[Piece]:
    """Returns a part without upright fronts that is one plane across the wall: an awning, a slab."""
    p = q[rows]
    box = extent(p, resolution.cell, _TAIL)
    if box[2] - box[0] < resolution.least[0] or len(rows) < 30:
        return []
    centred = p - p.mean(0)
    values, axes = np.linalg.eigh(centred.T @ centred / len(p))
    flat = np.sqrt(max(values[0], 0.0)) <= resolution.half and values[1] > 25.0 * values[0]
    if not flat or abs(axes[0, 0]) > 0.3:
        return []
    low = (box[0], box[1] - resolution.least[1] / 2, box[2], box[3] + resolution.least[1] / 2)
    front = float(np.quantile(p[:, 1], 0.02))
    ahead = rows[p[:, 1] <= front + resolution.half]
    return [Piece(rows, ahead, low if box[3] - box[1] < resolution.least[1] else box, front, inclined=True)]
