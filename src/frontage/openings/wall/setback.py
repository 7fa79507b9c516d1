"""Parts of a wall that are set back by less than fittings are thick: its foot, and a storey at its top.

Where sensor positions are unknown, panes and curtains pass for such a wall. What tells them apart is that
openings have jambs: a wall that is set back goes on where nothing of the nearer wall stands beside it.
"""

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Array, Bool, Float
from frontage.model.masonry import MASONRY
from frontage.openings.wall.raster import FITTING, TILE

_SHOWN = 0.25  # share of a tile's points that show a wall
_LAYER = 0.25  # share of a part's points that lie on its wall, among windows
_LEAST_M2 = 0.5  # m2 of a part that must show its wall where the depth of the nearer one was taken
_WALLED = 0.2  # share of a part's rows that may have the nearer wall on one side


def is_set_back_foot(wall: Float, slack: float) -> Bool:
    """Returns the tiles (h, w) of a ground floor behind the plane, no deeper than fittings are thick.

    It is wider than any opening, and there is a storey above it. Higher up, panes and curtains may be as full
    as a wall where no line of sight tells them apart.
    """
    labels, _ = ndimage.label((wall > slack) & (wall <= FITTING + slack))
    wide, below = int(MASONRY.largest_opening / TILE), len(wall) - int(MASONRY.room_height / TILE)
    found = np.zeros(wall.shape, np.bool_)
    for number, (rows, columns) in enumerate(ndimage.find_objects(labels), 1):
        if rows.start == 0 and rows.stop <= below and columns.stop - columns.start > wide:
            found |= labels == number
    return found


def with_set_back_tops(wall: Float, own: Array, y: Float, slack: float) -> Float:
    """Returns the depth (h, w) y m of the wall, with dormers and storeys above it that are set back.

    The surroundings that determine a depth reach across the step, so that the nearer wall below counts for
    the lowest metre of what stands behind it, and all that is between its windows would be open. Such a part
    lies above all that its columns show of the nearer wall, which stands on neither side of it, and one layer
    of its points is its wall.

    own (h, w, bins) area that tiles show at depths y (bins,) m; slack m within which depths are the same
    """
    shown = np.where(np.abs(y) <= slack, own, 0.0).sum(2)
    total = own.sum(2)
    nearer = (shown > _SHOWN * total) & (total > 0)
    goes_on = np.maximum.accumulate(nearer[::-1])[::-1]  # the nearer wall shows here or higher up
    seen = np.maximum.accumulate((total > 0)[::-1])[::-1]
    labels, _ = ndimage.label(seen & ~goes_on)
    held = np.where(np.abs(y - wall[..., None]) <= slack, own, 0.0).sum(2)
    missed = held <= _SHOWN * total  # tiles that do not show the wall that they were taken for
    out = wall.copy()
    for number, count in enumerate(np.bincount(labels.ravel())[1:], 1):
        part = labels == number
        if count * TILE**2 < _LEAST_M2 or _is_walled(part, goes_on):
            continue
        depth = _layer(own[part], y, slack)
        if depth is None:
            continue
        lost = part & missed & (wall < depth - slack)
        told = np.where(np.abs(y - depth) <= slack, own, 0.0).sum(2) > total / 2.0
        if (lost & told).sum() * TILE**2 >= _LEAST_M2:
            out[lost] = depth
    return out


def _is_walled(part: Bool, goes_on: Bool) -> bool:
    """Returns whether the nearer wall stands to the left or to the right of many rows of a part (h, w)."""
    edge = np.pad(goes_on, ((0, 0), (1, 1)))
    rows = part.any(1)
    walled = [np.any(part & beside, axis=1)[rows].mean() for beside in (edge[:, :-2], edge[:, 2:])]
    return bool(max(walled) > _WALLED)


def _layer(own: Array, y: Float, slack: float) -> float | None:
    """Returns the depth m of the wall among a part's tiles (k, bins), or None if no layer is one.

    Of layers that hold about as much, the wall is the foremost: panes lie behind it.
    """
    area = own.sum(0)
    held = np.array([area[np.abs(y - depth) <= slack / 2.0].sum() for depth in y])
    held[(y <= slack) | (y > FITTING + slack)] = 0.0
    peak = (held >= np.r_[0.0, held[:-1]]) & (held > np.r_[held[1:], 0.0])
    full = peak & (held > held.max() / 2.0) & (held > _LAYER * area.sum())
    return float(y[full][0]) if full.any() else None
