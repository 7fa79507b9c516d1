"""Which side of a front is the street."""

import numpy as np

from frontage.buildings.ground import Ground
from frontage.buildings.voxels import Level
from frontage.buildings.walls import Front
from frontage.geometry.arrays import Bool, Float, Int
from frontage.model import Scan
from frontage.model.masonry import MASONRY

_STREET = 6.0  # m, how far before a front its pavement is looked for
_SAMPLE = 20_000


def face_street(
    front: Front, scan: Scan, level: Level, wall: Bool, s_d: tuple[Float, Float], ground: Ground | None
) -> Front:
    """The front with `out` to the street, `along` to the right as seen from there and s counted accordingly.

    Told by the rays where points know theirs, else by measured ground, else by opacity: nothing is
    seen *behind*
    a closed piece of wall, so the side with more cells over occupied wall is the street.
    `s_d` are the coordinates (m,) of all cells in the front's frame, NaN for cells that are not near it.
    """
    side = _by_rays(front, scan) or _by_ground(front, ground) or _by_opacity(level, wall, *s_d) or 1.0
    out = front.out * side
    along = np.array([-out[1], out[0]])
    flip = float(along @ front.along)
    lo, hi = sorted((flip * front.lo, flip * front.hi))
    return Front(front.origin, along, out, lo, hi, front.members, front.block)


def _by_rays(front: Front, scan: Scan) -> float:
    """+1 or -1 by the sensors that measured points of this wall; 0 = no rays."""
    if not scan.has_origins:
        return 0.0
    pick = np.arange(0, len(scan), max(1, len(scan) // _SAMPLE * 2))
    s, d = front.coordinates(scan.xyz[pick, :2])
    on = pick[(s > front.lo) & (s < front.hi) & (np.abs(d) < 0.5)]
    eye = scan.sensor_of(on)[:, :2]
    away = front.coordinates(eye[np.isfinite(eye[:, 0])])[1]
    away = away[np.abs(away) > 0.5]
    return float(np.sign(np.sign(away).sum()))


def _by_ground(front: Front, ground: Ground | None) -> float:
    """+1 or -1 by the side with clearly more measured ground beside the wall; 0 = cannot tell."""
    if ground is None:
        return 0.0
    row, col = np.nonzero(ground.measured)
    xy = ground.corner + (np.column_stack([col, row]) + 0.5) * ground.cell
    s, d = front.coordinates(xy)
    beside = (s > front.lo) & (s < front.hi) & (np.abs(d) > 0.5) & (np.abs(d) < _STREET)
    plus, minus = int((beside & (d > 0)).sum()), int((beside & (d < 0)).sum())
    return float(np.sign(plus - minus)) if max(plus, minus) > 1.5 * min(plus, minus) + 4 else 0.0


def _by_opacity(level: Level, wall: Bool, s: Float, d: Float) -> float:
    """+1 or -1 by which side's cells project onto closed wall more often; 0 = cannot tell."""
    near = np.isfinite(d)
    if not near.any():
        return 0.0
    shape = (int(np.nanmax(s - np.nanmin(s)) / level.size) + 2, int(level.ijk[:, 2].max()) + 1)
    column = np.zeros(len(s), np.int64)
    column[near] = ((s[near] - np.nanmin(s)) / level.size).astype(np.int64)
    closed = np.zeros(shape, bool)
    skin = near & wall & (np.abs(np.where(near, d, np.inf)) < MASONRY.relief)
    closed[column[skin], level.ijk[skin, 2]] = True
    share = []
    for side in (1.0, -1.0):
        beyond = near & (side * np.where(near, d, 0) > 0.5)
        hits = closed[column[beyond], level.ijk[beyond, 2]]
        share.append(hits.mean() if len(hits) >= 20 else np.nan)
    return float(np.sign(share[0] - share[1])) if np.isfinite(share).all() else 0.0


def order(fronts: list[Front], place: Float) -> Int:
    """Rank (b,) of buildings at `place` (b, 2) m: along the longest front from left to right, then
    across the street."""
    if not fronts:
        return np.lexsort((place[:, 1], place[:, 0]))
    first = max(fronts, key=lambda f: (f.hi - f.lo, -f.origin[0], -f.origin[1]))
    s, d = first.coordinates(place)
    return np.lexsort((np.round(s, 3), d > 3.0))
