"""Parts of a wall that stand back by up to 30 cm: its ground floor, or dormers and storeys at its top.

Without sensor positions, panes and curtains look like such a wall. Openings have jambs; beside a part that
stands back, there is nothing of the nearer wall.
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
    """Returns the depth (h, w) y m of the wall, with dormers and storeys above it that stand back.

    The depth of a tile is taken from its surroundings. These reach across the step, so that the lowest metre
    of such a part gets the depth of the nearer wall below it, and its piers count as open. A part stands back
    if it lies above everything that its columns show of the nearer wall, if the nearer wall stands on neither
    side of it, and if one layer of its points is a wall.

    own (h, w, bins) area that tiles show at depths y (bins,) m; slack m within which depths are the same
    """
    total = own.sum(2)
    nearer = (shown_at(0.0, own, y, slack).sum(2) > _SHOWN * total) & (total > 0)
    goes_on = np.maximum.accumulate(nearer[::-1])[::-1]  # the nearer wall shows here or higher up
    seen = np.maximum.accumulate((total > 0)[::-1])[::-1]
    labels, _ = ndimage.label(seen & ~goes_on)
    area = np.bincount(labels.ravel())[1:] * TILE**2
    out = wall.copy()
    for number in 1 + np.flatnonzero(area >= _LEAST_M2):
        part = labels == number
        if not _is_walled(part, goes_on):
            out[part] = _part_depth(wall[part], own[part], y, slack)
    return out


def _part_depth(wall: Float, own: Array, y: Float, slack: float) -> Float:
    """Returns the depth (k,) m of the tiles of a part; those that do not show the wall get that of the part.

    Nothing changes where no layer is a wall, or too few tiles show it.
    """
    depth = _layer(own, y, slack)
    if depth is None:
        return wall
    total = own.sum(1)
    missed = (shown_at(wall, own, y, slack).sum(1) <= _SHOWN * total) & (wall < depth - slack)
    told = shown_at(depth, own, y, slack).sum(1) > total / 2.0
    enough = (missed & told).sum() * TILE**2 >= _LEAST_M2
    return np.where(missed, depth, wall) if enough else wall


def shown_at(depth: Float | float, own: Array, y: Float, slack: float) -> Array:
    """Returns the area that tiles (..., bins) show at a depth m, or each at its own (...,); elsewhere 0."""
    return np.where(np.abs(y - np.asarray(depth)[..., None]) <= slack, own, 0.0)


def _is_walled(part: Bool, goes_on: Bool) -> bool:
    """Returns whether many rows of a part (h, w) have the nearer wall to their left, or to their right."""
    edge = np.pad(goes_on, ((0, 0), (1, 1)))
    rows = part.any(1)
    walled = [np.any(part & beside, axis=1)[rows].mean() for beside in (edge[:, :-2], edge[:, 2:])]
    return bool(max(walled) > _WALLED)


def _layer(own: Array, y: Float, slack: float) -> float | None:
    """Returns the depth m of the wall of a part's tiles (k, bins), or None where no layer holds enough.

    Of layers that hold about as much, the foremost is the wall: panes lie behind it.
    """
    area = own.sum(0)
    held = np.array([area[np.abs(y - depth) <= slack / 2.0].sum() for depth in y])
    held[(y <= slack) | (y > FITTING + slack)] = 0.0
    peak = (held >= np.r_[0.0, held[:-1]]) & (held > np.r_[held[1:], 0.0])
    full = peak & (held > held.max() / 2.0) & (held > _LAYER * area.sum())
    return float(y[full][0]) if full.any() else None
