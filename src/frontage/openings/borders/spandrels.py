"""Finds recessed spandrels: walls below windows that stand back from the face, as in deep frames of concrete.

Frame and spandrel are told apart by their depths: the window is set into the spandrel as windows are set into
walls. Panels in the lower parts of doors and shop fronts lie in the plane of their frames.
"""

from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.masonry import MASONRY
from frontage.openings.borders.depth import AROUND, density_beside, find_depth
from frontage.openings.borders.outline import Outline
from frontage.openings.wall.crossings import CrossingBeams
from frontage.openings.wall.evidence import BEAMS_TO_DECIDE, WALL

ROW = 0.1
"""m, height of the rows that the masonry of a spandrel fills."""

_BORDER = 0.1  # share of the width at each side that is left out: reveals and frames
_LOWEST = MASONRY.room_height / 5.0  # m, half a metre: rails of doors and frames are lower
_HIGHEST = 0.6  # share of the height that a spandrel has at most
_FEWEST = 3  # rows that show it
_ON = 0.8  # share of the points of a row that lie on the spandrel
_BIN = 0.01  # m, bin of depths


def with_spandrel(outline: Outline, beams: CrossingBeams) -> Outline:
    """Returns the outline with its foot where its spandrel ends; the outline itself where there is none.

    `beams` are those of the wall around it, or more.
    """
    x0, z0, x1, z1 = outline.place
    if outline.depth is None or _HIGHEST * (z1 - z0) < _LOWEST:
        return outline
    wide = beams.around(outline.place, AROUND)
    near = wide if outline.wall is None else wide.behind(outline.wall)
    x, z = near.points
    inset = _BORDER * (x1 - x0)
    some = (x > x0 + inset) & (x < x1 - inset) & (z > z0) & (z < z1) & (near.depth > MASONRY.panel)
    z, depth = z[some] - z0, near.depth[some]
    due = density_beside(near, outline.place) * (x1 - x0 - 2.0 * inset) * ROW
    top = spandrel_top(z, depth, z1 - z0, near.wall, due)
    if top is None:
        return outline
    at, panel = top
    above = outline.with_border(2, z0 + at, ROW / np.sqrt(12.0))
    frame = find_depth(wide, above.place, above.rise, 2.0 * max(b.sigma for b in outline.borders[:2]))
    if frame is None or frame.value < panel + MASONRY.panel:
        return outline
    return replace(above, depth=frame)


def spandrel_top(z: Float, depth: Float, height: float, off: float, due: float) -> tuple[float, float] | None:
    """Returns where a spandrel ends, m above the foot of the opening, and its depth m; None without one.

    The ledge below hides its foot from the street.

    z, depth  (n,) m, of the points behind the panels of the wall
    height    m, of the opening
    off       m by which points of a wall may lie off it
    due       points of a row that the wall beside returns
    """
    rows, off = int(height / ROW), max(off, _BIN)
    if rows < _FEWEST or due <= 0.0:
        return None
    row = np.minimum((z / ROW).astype(np.int64), rows - 1)
    every = np.bincount(row, minlength=rows)
    full = np.flatnonzero(every > WALL * due)
    if not len(full):
        return None
    first = int(full[0])
    lowest = depth[(row >= first) & (row < first + _FEWEST)]
    held = np.bincount((lowest / _BIN).astype(np.int64))
    panel = float(np.median(lowest[np.abs(lowest - (held.argmax() + 0.5) * _BIN) < off]))
    on = np.abs(depth - panel) < off
    shown = np.bincount(row[on], minlength=rows)
    is_wall = (shown > WALL * due) & (shown > _ON * every)
    end = first + int(np.argmin(np.append(is_wall[first:], False)))
    at = float(z[on & (row <= end)].max(initial=0.0))
    is_seen = end - first >= _FEWEST and shown[first:end].sum() >= BEAMS_TO_DECIDE
    return (at, panel) if is_seen and _LOWEST <= at <= _HIGHEST * height else None
