"""Measures where a protrusion ends: beams that its front stopped against beams that passed beside it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.openings.boxes import Box
from frontage.openings.protrusions.beams import FacadeBeams
from frontage.openings.protrusions.boxes import within
from frontage.openings.protrusions.pieces import Piece, fit_slanted_line
from frontage.openings.protrusions.resolution import Resolution

_BAND = 0.1  # m to either side of a rough border that is searched
_STEP = 0.001  # m, step of the posterior
_STRAY = 0.02  # share of the beams beyond a border that end on the front's plane all the same
_NEXT = 2.5  # spacings within a border that tell how far apart rows of hits are
_SHY = 0.02  # share of the side that is left out at either end: corners
_HIDDEN = 1.5  # m beyond its last hit that a border is looked for behind what hides it
_THICK = 0.04  # m, thickness of a railing
_SEEN = 0.2  # share of the expected beams that show the wall beside a front
_GUESS = 0.25  # share of a cheek's width: error of one that is inferred from the other
_RIM = 0.06  # m, depth of the rim that shows how far out a border stands
_BEAM = 0.0045  # m: half the footprint of common scanners 10 m away


@dataclass(frozen=True)
class MeasuredBox:
    """The measured box of a protrusion.

    box        x0, z0, x1, z1 m
    sigma      m, standard errors of left, bottom, right, top
    hit        share of the beams within it that the front stopped
    bracketed  share of the borders with hits on one side and passes on the other
    """

    box: Box
    sigma: tuple[float, float, float, float]
    hit: float
    bracketed: float


def measure_box(
    beams: FacadeBeams, few: FacadeBeams, before: Float, piece: Piece, resolution: Resolution
) -> MeasuredBox:
    """Measures the borders of a piece among the points `before` (k, 3) m the wall; `few` beams tell shares.

    A border parts the piece's own points, undersides and cheeks included, from the beams that passed beside
    it: where these crossed the plane, parallel to the wall, that lies as far out as the piece's rim there.
    """
    resolution = resolution.near(piece.box)
    points, cheeks = before[piece.rows], {side: before[rows] for side, rows in piece.cheeks.items()}
    cache: dict[float, tuple[Float, Float]] = {}
    place, sigma, good = list(piece.box), [0.0] * 4, 0
    for side in range(4):
        if side in cheeks:
            place[side], sigma[side] = _foot(cheeks[side], side % 2, resolution)
            good += 1
            continue
        y = _rim_depth(points, piece, side)
        if y not in cache:
            cache[y] = beams.at(y, piece.box, _HIDDEN)
        at, error, bracketed = _border(points, cache[y], piece, side=side, y=y, resolution=resolution)
        place[side], sigma[side] = at, error
        good += bracketed
    for side in (0, 2):
        if side not in cheeks and 2 - side in cheeks:
            edge = before[piece.front_rows, 0]
            wide = abs(place[2 - side] - float(edge.max() if side == 0 else edge.min()))
            place[side], sigma[side] = _mirrored(
                beams.q.T, place, sigma[side], side=side, wide=wide, resolution=resolution
            )
    hit = hit_share(few, piece.box, piece.y, resolution)
    box = (place[0], place[1], place[2], place[3])
    return MeasuredBox(box, (sigma[0], sigma[1], sigma[2], sigma[3]), hit, good / 4)


def hit_share(beams: FacadeBeams, box: Box, y: float, resolution: Resolution) -> float:
    """Returns the share of the beams through a box, as far as a front at y m, that it stopped; 0 for none.

    A front is as thick as a railing: its bars stand behind its rails.
    """
    _, depth = beams.at(y, box, 0.0)
    reached = depth >= y - resolution.half
    return float((depth[reached] <= y + max(resolution.half, _THICK)).mean()) if reached.any() else 0.0


def _foot(cheek: Float, axis: int, resolution: Resolution) -> tuple[float, float]:
    """Returns where a slanting cheek of points (k, 3) m meets the wall, m, and its standard error."""
    y = cheek[:, 1]
    at, _, spread = fit_slanted_line(y, cheek[:, 2 * axis])
    lever = abs(float(y.mean())) / max(float(y.std()), _STEP)
    return at, float(
        np.sqrt((1.0 + lever**2) * spread**2 / len(y) + _STEP**2 + (0.5 * resolution.sigma) ** 2)
    )


def _mirrored(
    q: Float, place: Sequence[float], sigma: float, *, side: int, wide: float, resolution: Resolution
) -> tuple[float, float]:
    """Returns a left or right border m whose cheek was not seen, and its error.

    Bays are symmetric as a rule: the cheek is as `wide` m as the other one, unless points q (n, 3) m show the
    wall there.
    """
    beyond = place[side] - wide if side == 0 else place[side] + wide
    x0, x1 = sorted((place[side], beyond))
    there = (q[:, 0] > x0) & (q[:, 0] < x1) & (q[:, 2] > place[1]) & (q[:, 2] < place[3])
    wall = float((np.abs(q[there, 1]) <= resolution.half).sum())
    if wall > _SEEN * wide * (place[3] - place[1]) / resolution.spacing**2:
        return place[side], sigma
    return beyond, float(np.hypot(sigma, _GUESS * wide))


def _rim_depth(points: Float, piece: Piece, side: int) -> float:
    """Returns the y m of the foremost points along a side; that of the front where these are as far out."""
    axis = 0 if side % 2 == 0 else 2
    edge = piece.box[side]
    rim = points[np.abs(points[:, axis] - edge) <= _RIM, 1]
    if len(rim) < 5:
        return piece.y
    y = float(np.quantile(rim, 0.05))
    return y if y - piece.y > _RIM else piece.y


def _border(
    points: Float,
    crossed: tuple[Float, Float],
    piece: Piece,
    *,
    side: int,
    y: float,
    resolution: Resolution,
) -> tuple[float, float, bool]:
    """Returns the place m of a border, its standard error m, and whether passes beyond it bracket it.

    points   (k, 3) m of the piece
    crossed  (n, 2) m, where beams crossed the plane at y m, and the depths (n,) m of their points
    """
    where, depth = crossed
    axis, band = side % 2, max(_BAND, 3.0 * resolution.spacing)
    inner = min(band, 0.5 * (piece.box[axis + 2] - piece.box[axis]))
    # bands continue along the wall behind the piece
    ahead = points[points[:, 1] <= y + max(resolution.half, -y / 2.0)]
    solid = _outwards(ahead[:, [0, 2]], piece.box, side, inner)
    solid = solid[solid <= band]
    if len(solid) < 3:
        return piece.box[side], band / np.sqrt(3.0), False
    own = within(where, piece.box, 0.0)
    behind = (depth > y + resolution.half) & ~(own & (depth < -resolution.half))
    passed = _outwards(where[behind], piece.box, side, inner)
    mean, spread = posterior(solid, passed[passed <= band], inner, band, resolution.spacing)
    beyond = passed[passed > mean]
    free = float(beyond[0]) if len(beyond) else _HIDDEN
    stopped = _outwards(where[depth < piece.y - resolution.half], piece.box, side, inner)
    stopped = stopped[(stopped > mean) & (stopped < free)]
    if free > mean + 2.0 * resolution.spacing and len(stopped) > len(solid) / 10:
        spread = float(np.hypot(spread, (free - mean) / np.sqrt(3.0)))  # something hides where it ends
    at = piece.box[side] + (-mean if side < 2 else mean)
    return at, spread, free <= mean + 2.0 * resolution.spacing


def _outwards(where: Float, box: Box, side: int, inner: float) -> Float:
    """Returns the sorted distances m of places (n, 2) m beyond a side of a box, from `inner` m within.

    Places at the ends of the side are left out.
    """
    axis = side % 2
    low, high = box[1 - axis], box[3 - axis]
    cut = _SHY * (high - low)
    s = (where[:, axis] - box[side]) * (-1.0 if side < 2 else 1.0)
    along = where[:, 1 - axis]
    return np.sort(s[(along >= low + cut) & (along <= high - cut) & (s >= -inner)])


def posterior(solid: Float, passed: Float, inner: float, band: float, spacing: float) -> tuple[float, float]:
    """Returns the mean and standard error m of a border from the sorted places (n,), (m,) m of hits, passes.

    No surface ends further beyond its last hit than the next row of hits would be.
    """
    e = np.arange(-inner, band, _STEP)
    score = _log_likelihood(e, solid, passed)
    last = float(solid[-1 - int(_STRAY * len(solid))])
    rows = solid[(solid >= last - _NEXT * spacing) & (solid <= last)]
    gap = float(np.diff(rows).max()) if len(rows) > 1 else spacing
    p = np.where(e <= last + max(min(gap, spacing), 2 * _STEP), np.exp(score - score.max()), 0.0)
    p = p / p.sum() if p.sum() > 0 else (np.abs(e - last) <= _STEP) / 2.0
    mean = float(p @ e / p.sum())
    return mean, float(np.sqrt(p @ (e - mean) ** 2 / p.sum() + _STEP**2 + _BEAM**2))


def _log_likelihood(e: Float, solid: Float, passed: Float) -> Float:
    """Returns the log-likelihood (k,) of borders at e (k,) m: hits within, passes beyond.

    It is conditional on where the beams crossed, so that rows of beams parallel to the border do no harm.
    """
    inside = (solid <= 0).sum() + 1.0
    share = min(max(inside / (inside + (passed <= 0).sum() + 1.0), 0.05), 0.98)
    s = np.searchsorted(solid, e, side="right")
    n = np.searchsorted(passed, e, side="right")
    return np.asarray(
        s * np.log(share)
        + n * np.log(1.0 - share)
        + (len(solid) - s) * np.log(_STRAY)
        + (len(passed) - n) * np.log(1.0 - _STRAY)
    )
