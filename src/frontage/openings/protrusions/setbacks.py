"""Parts of a facade that are set back as a whole: a wall behind the wall, larger than an opening."""

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY, TOLERANCES
from frontage.openings.boxes import Box
from frontage.openings.protrusions.beams import FacadeBeams
from frontage.openings.protrusions.boxes import filled
from frontage.openings.protrusions.checks import is_framed
from frontage.openings.protrusions.measure import MeasuredBox, posterior
from frontage.openings.protrusions.pieces import Piece, connected, fit_front
from frontage.openings.protrusions.resolution import Resolution

_WIDE, _HIGH = 4.5, 3.5  # m, one of which a part set back reaches: gates and shop fronts do not
_SOLID = 0.5  # share of it that shows a wall: frames of a glass front do not
_BARE = 0.1  # share of it that may show the main wall
_BAND = 0.3  # m to either side of a rough border that is searched
_SHY = 0.15  # share of a side that is left out at either end


def find_setbacks(
    facade: Facade, beams: FacadeBeams, resolution: Resolution
) -> list[tuple[Piece, MeasuredBox]]:
    """Returns the parts set back, from the depth layers of the facade, with their measured borders."""
    q = beams.q.T
    wall = q[np.abs(q[:, 1]) <= resolution.half]
    found: list[tuple[Piece, MeasuredBox]] = []
    for layer in facade.layers:
        if layer.y < max(MASONRY.step_out, TOLERANCES.front_sigmas * facade.roughness):
            continue
        rows = np.flatnonzero(np.abs(q[:, 1] - layer.y) <= 2.0 * resolution.half)
        for part in connected(q[rows][:, [0, 2]], resolution.gap, 100):
            piece = _part(q, rows[part], wall, layer.y, resolution)
            if piece is not None and not any(_overlap(piece.box, other.box) for other, _ in found):
                found.append((piece, _outline(beams, wall, piece, resolution)))
    return found


def _part(q: Float, rows: Int, wall: Float, y: float, resolution: Resolution) -> Piece | None:
    """Returns the wall among the points `rows` (k,) of q (n, 3) m at about y m; None where there is none.

    The main wall's points must be missing there.
    """
    p = q[rows]
    wide, _, high = np.ptp(p, axis=0)
    found = fit_front(p, y, resolution) if _is_large(wide, high) else None
    if found is None:
        return None
    at, front, box = found
    cell = 2.0 * resolution.near(box).spacing
    large = _is_large(box[2] - box[0], box[3] - box[1])
    if (
        not large
        or filled(p[front], box, cell) < _SOLID
        or not is_framed(p[front], p[front], box, resolution)
    ):
        return None
    inside = wall[
        (wall[:, 0] > box[0]) & (wall[:, 0] < box[2]) & (wall[:, 2] > box[1]) & (wall[:, 2] < box[3])
    ]
    if filled(inside, box, cell) > _BARE:
        return None
    return Piece(rows[front], rows[front], box, at)


def _is_large(wide: float, high: float) -> bool:
    """Returns whether a part of that width and height m is larger than gates and shop fronts are."""
    return (wide >= _WIDE or high >= _HIGH) and wide >= MASONRY.room_width and high >= MASONRY.room_height


def _outline(beams: FacadeBeams, wall: Float, piece: Piece, resolution: Resolution) -> MeasuredBox:
    """Measures the borders between the main wall's points and the beams that went on to the part."""
    where, depth = beams.at(0.0, piece.box, _BAND)
    through = where[depth > piece.y - resolution.half]
    place, sigma, good = list(piece.box), [_BAND / np.sqrt(3.0)] * 4, 0
    spacing = resolution.near(piece.box).spacing
    for side in range(4):
        solid = _inwards(wall[:, [0, 2]], piece.box, side)
        if len(solid) < 3:
            continue
        mean, sigma[side] = posterior(solid, _inwards(through, piece.box, side), _BAND, _BAND, spacing)
        place[side] += mean if side < 2 else -mean
        good += 1
    box = (place[0], place[1], place[2], place[3])
    return MeasuredBox(box, (sigma[0], sigma[1], sigma[2], sigma[3]), 1.0, good / 4)


def _inwards(where: Float, box: Box, side: int) -> Float:
    """Returns the sorted distances m of places (n, 2) m from a side of a box into it, without its ends."""
    axis = side % 2
    low, high = box[1 - axis], box[3 - axis]
    cut = _SHY * (high - low)
    s = (where[:, axis] - box[side]) * (1.0 if side < 2 else -1.0)
    along = where[:, 1 - axis]
    return np.sort(s[(along > low + cut) & (along < high - cut) & (np.abs(s) <= _BAND)])


def _overlap(a: Box, b: Box) -> bool:
    """Returns whether two boxes overlap."""
    return min(a[2], b[2]) > max(a[0], b[0]) and min(a[3], b[3]) > max(a[1], b[1])
