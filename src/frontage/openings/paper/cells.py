"""Classifies the cells, applies rules of neighbourhood, and merges windows (paper B, section 3.2.2)."""

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Array, Bool, Float
from frontage.openings.boxes import Box

FACADE_SHARE = 0.70
"""Cells with a larger share of available elements are facade (published)."""

WINDOW_SHARE = 0.10
"""Cells with a smaller share are windows (published)."""

FACADE, WINDOW, UNCERTAIN, OUTSIDE = 0, 1, 2, 3


_MIDDLE = (FACADE_SHARE + WINDOW_SHARE) / 2
_HELD = 0.5  # share of a cell within the outline


@dataclass(frozen=True, eq=False)
class Cells:
    """The facade cut by its partition planes.

    xs     (m + 1,) m
    zs     (n + 1,) m
    share  (n, m) of available elements
    first  (n, m) the class by the share alone
    final  (n, m) the class after the neighbourhood rules
    """

    xs: Float
    zs: Float
    share: Float
    first: Array
    final: Array


def classify(xs: Float, zs: Float, share: Float, within: Float) -> Cells:
    """Classes cells by 70 % and 10 % of available elements, and the rest by their neighbours."""
    first = np.full(share.shape, UNCERTAIN, np.int8)
    first[share > FACADE_SHARE] = FACADE
    first[share < WINDOW_SHARE] = WINDOW
    first[(within < _HELD) | ~np.isfinite(share)] = OUTSIDE
    return Cells(xs, zs, share, first, resolve_uncertain(first, share))


def resolve_uncertain(first: Array, share: Float) -> Array:
    """Returns classes (n, m) with no cell left uncertain, by the neighbours across and up.

    1. Between two window cells: facade, "two small windows are reconstructed instead of one large". 2. Beside
    a window: as the nearest windows of the same column (row) continue, so that "the alignment as
       well as the size of proximate windows is ensured"; without any, the nearer class by its share.
    3. Beside none: a window where windows stand in its row and its column, else facade.
    """
    final = first.copy()
    final[(first == UNCERTAIN) & (_between(first == WINDOW) | _between((first == WINDOW).T).T)] = FACADE
    for i, j in np.argwhere(final == UNCERTAIN):
        across, beside_x = _votes(first, int(i), int(j))
        up, beside_z = _votes(first.T, int(j), int(i))
        nearer = share[i, j] < _MIDDLE
        if beside_x or beside_z:
            votes = across + up
            final[i, j] = WINDOW if votes > 0 or (votes == 0 and nearer) else FACADE
        else:
            crossed = (first[i] == WINDOW).any() and (first[:, j] == WINDOW).any()
            final[i, j] = WINDOW if crossed and nearer else FACADE
    return final


def _between(window: Bool) -> Bool:
    """Returns which cells (n, m) have window cells both to their left and to their right."""
    wide = np.pad(window, ((0, 0), (1, 1)))
    return np.asarray(wide[:, :-2] & wide[:, 2:], np.bool_)


def _votes(first: Array, i: int, j: int) -> tuple[int, bool]:
    """Counts how the windows above and below treat column j: +1 for each that covers it, else -1.

    These are the nearest windows in the columns where cell (i, j) has a window beside it; also returns
    whether it has one.
    """
    total, beside = 0, False
    for k in (j - 1, j + 1):
        if not 0 <= k < first.shape[1] or first[i, k] != WINDOW:
            continue
        beside = True
        column = first[:, k] == WINDOW
        for rows in (range(i - 1, -1, -1), range(i + 1, len(column))):
            other = _next_window(column, rows)
            if other is not None:
                total += {WINDOW: 1, FACADE: -1}.get(int(first[other, j]), 0)
    return total, beside


def _next_window(column: Bool, rows: range) -> int | None:
    """Returns the first window cell along `rows` once the present window has ended, or None."""
    ended = False
    for row in rows:
        if not column[row]:
            ended = True
        elif ended:
            return row
    return None


def convex_windows(cells: Cells, least: tuple[float, float]) -> list[Box]:
    """Merges window cells into rectangles: "the merge of window cells will result in convex window objects".

    A part that is no rectangle is filled where only cells that were uncertain are missing; otherwise it is
    taken apart, the largest rectangle first. Rectangles narrower or lower than `least` (width, height) m are
    facade, for no border of theirs could have been found.
    """
    out: list[Box] = []
    todo = _parts(cells.final == WINDOW)
    for rows, columns, part in todo:  # grows by what is left of parts taken apart
        if (part | (cells.first[rows, columns] == UNCERTAIN)).all():
            part[:] = True
        xs, zs = cells.xs[columns.start : columns.stop + 1], cells.zs[rows.start : rows.stop + 1]
        found = _largest(part, xs, zs, least)
        if found is None:
            continue
        i0, i1, j0, j1 = found
        out.append((float(xs[j0]), float(zs[i0]), float(xs[j1]), float(zs[i1])))
        part[i0:i1, j0:j1] = False
        todo += [
            (
                slice(rows.start + r.start, rows.start + r.stop),
                slice(columns.start + c.start, columns.start + c.stop),
                p,
            )
            for r, c, p in _parts(part)
        ]
    return out


def _parts(mask: Bool) -> list[tuple[slice, slice, Bool]]:
    """Returns the connected parts of a mask (n, m): the rows and columns of each, and its cells there."""
    label, count = ndimage.label(mask)
    places = ndimage.find_objects(label, count)
    return [(place[0], place[1], label[place] == k) for k, place in enumerate(places, 1)]


def _largest(
    part: Bool, xs: Float, zs: Float, least: tuple[float, float]
) -> tuple[int, int, int, int] | None:
    """Returns rows i0:i1, columns j0:j1 of the largest rectangle of set cells (n, m), or None."""
    best, found = 0.0, None
    for i0 in range(len(part)):
        if i0 and not (part[i0] & ~part[i0 - 1]).any():
            continue  # what begins in this row also fits from the row before it
        if (zs[-1] - zs[i0]) * (xs[-1] - xs[0]) <= best:
            break
        runs = np.logical_and.accumulate(part[i0:], axis=0)  # columns set from row i0 down to each row
        step = np.diff(np.pad(runs.astype(np.int8), ((0, 0), (1, 1))), axis=1)
        row, begin = np.nonzero(step == 1)
        end = np.nonzero(step == -1)[1]
        width, height = xs[end] - xs[begin], zs[i0 + row + 1] - zs[i0]
        area = np.where((width >= least[0]) & (height >= least[1]), width * height, 0.0)
        if len(area) and area.max() > best:
            k = int(np.argmax(area))
            best = float(area[k])
            found = (i0, i0 + int(row[k]) + 1, int(begin[k]), int(end[k]))
    return found
