"""What is made of the window cells: an extra facade cell, curved heads, depth (paper B, 3.2.2 and 3.2.3)."""

from collections.abc import Iterable, Sequence

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.openings.boxes import Box
from frontage.openings.paper.availability import ELEMENT, AvailabilityMap
from frontage.openings.paper.cells import FACADE_SHARE, WINDOW_SHARE
from frontage.openings.paper.edges import SEARCH, BorderLine

_RISES = 12  # heights of the arch that are tried
_FEWEST_CORNER = 4  # elements above the arch that can tell it from a rectangle
_FEWEST_DEPTH = 10  # points that make a depth plane


def split_windows(
    windows: Iterable[Box],
    borders: Sequence[BorderLine],
    xz: Float,
    distance: float,
    least: tuple[float, float],
) -> list[Box]:
    """Separates windows at lines inside them "by an additional facade cell", where facade points are there.

    Section 3.2.2, last paragraph, and figure 8: only one line was detected between two close windows. The
    cell covers the facade points (xz (n, 2) m) within a search radius of the line; it is kept when more than
    70 % of its length has some. What remains on either side must be a window of at least `least` m.
    """
    done: list[Box] = []
    todo = list(windows)
    lines = sorted(borders, key=lambda b: -b.count)
    place = np.array([(b.position, *b.extent, b.upright) for b in lines]).reshape(-1, 4)
    xz = xz[np.argsort(xz[:, 0], kind="stable")]
    while todo:
        box = todo.pop()
        inner = [lines[k] for k in np.flatnonzero(_crossing(place, box, least))]
        halves = _split(box, inner, xz, distance, least) if inner else None
        if halves is None:
            done.append(box)
        else:
            todo += halves
    return done


def _crossing(place: Float, box: Box, least: tuple[float, float]) -> Bool:
    """Returns which lines (n, 4) (position, extent, upright) run inside a window with room on either side."""
    low, high = np.array(box[:2]), np.array(box[2:])
    across = np.where(place[:, 3] == 1, 0, 1)
    room = np.array(least)[across]
    inside = (place[:, 0] > low[across] + room) & (place[:, 0] < high[across] - room)
    along = 1 - across
    return np.asarray(inside & (place[:, 1] < high[along]) & (place[:, 2] > low[along]), np.bool_)


def _split(
    box: Box, inner: Sequence[BorderLine], xz: Float, distance: float, least: tuple[float, float]
) -> list[Box] | None:
    """Returns the two windows of a separated one, or None; xz (n, 2) m is sorted by x."""
    first, last = np.searchsorted(xz[:, 0], (box[0], box[2]))
    own = xz[first:last]
    own = own[(own[:, 1] >= box[1]) & (own[:, 1] <= box[3])]
    radius = SEARCH * distance
    for border in inner:
        a, b = (0, 1) if border.upright else (1, 0)  # across the line, along it
        near = own[np.abs(own[:, a] - border.position) <= radius]
        if not len(near) or _filled(near[:, b], box[b], box[b + 2], distance) <= FACADE_SHARE:
            continue
        low, high = float(near[:, a].min()), float(near[:, a].max())
        if low - box[a] < least[a] or box[a + 2] - high < least[a]:
            continue
        one, other = list(box), list(box)
        one[a + 2], other[a] = low, high
        return [(*one,), (*other,)]  # type: ignore[list-item]
    return None


def _filled(along: Float, low: float, high: float, distance: float) -> float:
    """Returns the share of the grid elements from `low` to `high` m that hold a point."""
    number = max(int((high - low) / (ELEMENT * distance)), 1)
    return (
        len(np.unique(np.clip(((along - low) / (high - low) * number).astype(int), 0, number - 1))) / number
    )


def with_head(box: Box, borders: Sequence[BorderLine], seen: AvailabilityMap) -> tuple[Box, float]:
    """Returns the window with its curved head: box m, and rise m of the arch (0 = straight).

    Section 3.2.3: "also curved primitives can be integrated". The crown is the window's upper border, or a
    top line above it up to half the width away: the cells between hold corners of the wall, and may have been
    classed as facade.
    """
    x0, z0, x1, z1 = box
    near = [b for b in borders if b.side == "top" and z1 < b.position <= z1 + (x1 - x0) / 2]
    # one line per element of the map, which cannot tell more of them apart
    crowns = {int(b.position / seen.cell): b.position for b in near if x0 < sum(b.extent) / 2 < x1}.values()
    for crown in [*sorted(crowns, reverse=True), z1]:
        raised = (x0, z0, x1, crown)
        if (rise := _rise(raised, seen)) > 0 and crown - rise <= z1:
            return raised, rise
    return box, 0.0


def _rise(box: Box, seen: AvailabilityMap) -> float:
    """Returns the rise m of the arch through the springing points with its crown at the top, 0 = none.

    Of several it is the one that explains the map best; it stands when the map classes the solid above it as
    facade (> 70 %) and the one below as window (< 10 %).
    """
    x0, z0, x1, z1 = box
    half = (x1 - x0) / 2
    if half <= seen.cell or z1 - z0 <= half:
        return 0.0
    xz, there = seen.centres((x0, z1 - half, x1, z1))
    best, found = int(there.sum()), 0.0
    for rise in np.linspace(half / _RISES, half, _RISES):
        above, below = _about_arch(xz, box, float(rise), seen.cell)
        if above.sum() < _FEWEST_CORNER or not below.any():
            continue
        cost = int((~there[above]).sum() + there[below].sum())
        if cost < best and there[above].mean() > FACADE_SHARE and there[below].mean() < WINDOW_SHARE:
            best, found = cost, float(rise)
    return found


def _about_arch(xz: Float, box: Box, rise: float, cell: float) -> tuple[Bool, Bool]:
    """Returns which element centres (n, 2) m lie above the arch and which below; crossed ones are neither."""
    x0, _, x1, z1 = box
    radius = ((x1 - x0) ** 2 / 4 + rise**2) / (2 * rise)
    out = np.hypot(xz[:, 0] - (x0 + x1) / 2, xz[:, 1] - (z1 - radius)) - radius
    clear = cell / np.sqrt(2)
    upper = xz[:, 1] > z1 - rise
    above = upper & (out > clear)
    return np.asarray(above, np.bool_), np.asarray(~above & ~(upper & (out > -clear)), np.bool_)


def outline(box: Box, rise: float, chord: float) -> Float:
    """Returns the ring (k, 2) m, counter-clockwise, of a window with an arch of `rise` m.

    Its chord errors are at most `chord` m.
    """
    x0, z0, x1, z1 = box
    base = np.array([[x0, z0], [x1, z0]])
    if rise <= 0:
        return np.vstack([base, [[x1, z1], [x0, z1]]])
    half = (x1 - x0) / 2
    radius = (half**2 + rise**2) / (2 * rise)
    angle = np.arctan2(half, radius - rise)
    step = 2 * np.arccos(max(1 - chord / radius, 0.0))
    at = np.linspace(angle, -angle, max(int(np.ceil(2 * angle / step)), 2) + 1)
    arch = np.column_stack([(x0 + x1) / 2 + radius * np.sin(at), z1 - radius + radius * np.cos(at)])
    return np.vstack([base, arch])


def shifted_plane(y: Float, tolerance: float) -> float | None:
    """Returns the depth m of the plane parallel to the facade with the most points (n,) m on it.

    Section 3.2.1: points at the crossbars "are detected by searching a plane parallel to the facade, which is
    shifted in its normal direction"; the plane is the median of its points. None below 10 points.
    """
    ordered = np.sort(y)
    count = np.searchsorted(ordered, ordered + 2 * tolerance, side="right") - np.arange(len(ordered))
    if not len(count) or count.max() < _FEWEST_DEPTH:
        return None
    k = int(np.argmax(count))
    return float(np.median(ordered[k : k + count[k]]))
