"""Where exactly the border of an opening lies: a posterior from the beams on both sides of it.

A border is the edge of a solid that reaches from its front (the wall, a sill or a surround before it) into
the wall. Beams that slant away from the opening end on the reveal behind it, which is *in sight*; the
others pass the edge of the front, which *hides* what lies behind. Which plane tells the two sides apart
depends on that.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage
from scipy.special import logsumexp, ndtr

from frontage.geometry.arrays import Float
from frontage.openings.sight import Sight

_STEP = 0.0005  # m, raster of the posterior
_STRAY = 0.01  # share of the beams that say the wrong thing
_SHY = 0.15  # share of the opening's side that is left out at either end: arches, corners, sills
_FLOOR = 0.001  # m: reveals are not straighter
_FITTING = 0.3  # m: sills, surrounds and shutters stand so far out
_STRIP = 0.03  # m, least width of the face beside a border that tells its depth
FEW = 6  # points that tell a depth
_ROUGHLY = 10_000  # beams that tell where to look more closely
_SPLAY = 0.1  # m per m, one sigma of how much reveals slant
_OUTLIER = 0.05  # share of reveals that are none
WIDTHS = (0.001, 0.002, 0.003, 0.0045, 0.007)
"""m, blur of edges that are tried: one sigma of a beam's footprint."""

Place = tuple[float, float, float, float]


@dataclass(frozen=True)
class Face:
    """Depth y m of the solid face that ends at a border, its sigma, and the points that tell it."""

    y: float
    sigma: float
    points: int


@dataclass(frozen=True, eq=False)
class Border:
    """Place of a border along its axis, m, one sigma, and the nats it gains over no border at all.

    face    of the solid at the border; `hidden` = share of the beams that pass its edge
    scores  log-evidence (k,) for every blur of `WIDTHS`, where it was asked for
    """

    at: float
    sigma: float
    gain: float
    face: Face
    hidden: float
    scores: Float


@dataclass(frozen=True)
class Look:
    """What the borders of a facade share: the blur of edges m, and the faces left, right, bottom, top."""

    blur: float = 0.002
    faces: tuple[Face | None, ...] = (None, None, None, None)
    told: bool = False  # whether the other blurs are asked for, too


@dataclass(frozen=True, eq=False)
class _Strip:
    """Beams around a border, u (n,) m towards the opening from where the border is looked for."""

    solid: Float
    opened: Float
    stopped: Float
    reveal: tuple[float, float] | None
    face: Face
    hidden: float
    rays: bool


def find_borders(
    near: Sight, rough: Place, cell: float, rise: float, frame: float | None, spacing: float, look: Look
) -> tuple[Place, list[Border]]:
    """Box x0, z0, x1, z1 and its borders left, right, bottom, top; three rounds, for each needs the others.

    rise, frame  m, of the head (0 = straight) above the end of the sides; depth of the frame, if it is known
    """
    x0, z0, x1, z1 = rough
    borders: list[Border] = []
    quick, few = replace(look, told=False), near.thinned(_ROUGHLY)
    rounds = (max(0.12, 2.0 * cell), max(0.06, 1.5 * cell), max(0.04, 1.5 * spacing))
    for number, band in enumerate(rounds, 1):
        now, part = (look, near) if number == len(rounds) else (quick, few)
        wide, high = (x1 - x0) / 2, (z1 - z0) / 2
        side = (z0, max(z1 - rise, z0 + 0.2 * (z1 - z0)))
        sides = ((0, 1, x0, wide, side), (0, -1, x1, wide, side), (1, 1, z0, high, (x0, x1)))
        borders = [
            locate(part, axis, sign, at, min(band, inner), inner, across, frame, spacing, now)
            for axis, sign, at, inner, across in (*sides, (1, -1, z1, high, (x0, x1)))
        ]
        x0, x1, z0 = (b.at for b in borders[:3])
        z1 = borders[3].at if rise == 0.0 else z1
    return (x0, z0, x1, z1), borders


def locate(
    near: Sight,
    axis: int,
    sign: int,
    at: float,
    band: float,
    inner: float,
    across: tuple[float, float],
    frame: float | None,
    spacing: float,
    look: Look,
) -> Border:
    """The border near `at` m along `axis` (0 = x, 1 = z) whose opening lies to the side `sign`.

    band     m to either side that is searched; inner m: depth of the opening that may be looked into
    across   m, extent of the side
    """
    reach = band + min(band, inner)
    strip = _strip(near, axis, sign, at, reach, across, frame, spacing, look)
    asked = WIDTHS if look.told else ()
    none = np.zeros(len(asked))
    if len(strip.solid) < 3:
        return Border(at, band / np.sqrt(3.0), 0.0, strip.face, strip.hidden, none)
    half = round(band / _STEP)
    e: Float = np.arange(-half, half + 1, dtype=np.float64) * _STEP
    fixed = _absences(strip, reach, spacing, e) + _reveal(strip.reveal, e)
    strays = _strays(strip.solid, -band / 2), _strays(-strip.opened, -band / 2)
    scores = {w: fixed + side_scores(strip.solid, strip.opened, e, w, strays) for w in {*asked, look.blur}}
    score = scores[look.blur]
    p = np.exp(score - score.max())
    p /= p.sum()
    mean = float(p @ e)
    slack = strip.hidden * strip.face.sigma
    sigma = float(np.sqrt(p @ (e - mean) ** 2 + _FLOOR**2 + slack**2))
    gain = float(score.max() - max(score[0], score[-1]))
    told = np.array([logsumexp(scores[w]) for w in asked])
    return Border(at + sign * mean, sigma, gain, strip.face, strip.hidden, told)


def _strip(
    near: Sight,
    axis: int,
    sign: int,
    at: float,
    reach: float,
    across: tuple[float, float],
    frame: float | None,
    spacing: float,
    look: Look,
) -> _Strip:
    """The beams around a border, each where it crosses the plane that decides on which side it is.

    A beam that the reveal would stop is solid if it ended before a plane 3 sigma within the wall, and counts
    where it crosses that plane: the face's noise does not matter. A beam past the front's edge counts where
    it passes the edge, and is solid if most of its light came from the front (half-way to the frame).
    """
    cut = _SHY * (across[1] - across[0])
    low, high = across[0] + cut, across[1] - cut
    slope = sign * near.slope[:, axis]
    seen = slope < 0
    own = near.at(near.depth)
    beside = (own[:, 1 - axis] > low) & (own[:, 1 - axis] < high)
    u_own = sign * (own[:, axis] - at)
    face = _face(u_own[beside], near.depth[beside], near.wall, reach, spacing)
    shared = look.faces[{(0, 1): 0, (0, -1): 1, (1, 1): 2, (1, -1): 3}[axis, sign]]
    if face.points < FEW and shared is not None:
        face = shared
    begin = max(face.y, 0.0) + near.wall
    back = max(frame - face.y, 2.0 * near.wall) if frame is not None else 2.0 * near.wall
    limit = np.where(seen, begin, face.y + back / 2)
    at_plane = near.at(np.where(seen, begin, face.y))
    u = sign * (at_plane[:, axis] - at)
    some = (at_plane[:, 1 - axis] > low) & (at_plane[:, 1 - axis] < high) & (np.abs(u) < reach)
    stopped, solid = near.depth < -_FITTING, near.depth <= limit
    reveal = None
    if frame is not None:
        on = seen & beside & (near.depth > begin) & (near.depth < frame - near.wall) & (np.abs(u_own) < reach)
        reveal = _reveal_line(u_own[on], near.depth[on] - max(face.y, 0.0), near.wall / 3.0, slope[on])
    hidden = some & ~seen & ~stopped
    slack = float(np.abs(slope[hidden]).mean() * hidden.sum() / max(some.sum(), 1)) if hidden.any() else 0.0
    return _Strip(
        u[some & solid & ~stopped],
        u[some & ~solid],
        u[some & stopped],
        reveal,
        face,
        slack,
        bool(near.slope.any()),
    )


def _face(u: Float, depth: Float, wall: float, reach: float, spacing: float) -> Face:
    """The face that ends at a border: the foremost of the surfaces within a strip beside it."""
    solid = (depth <= wall) & (depth > -_FITTING) & (np.abs(u) < reach)
    u, depth = u[solid], depth[solid]
    if len(u) < FEW:
        return Face(0.0, wall, len(u))
    edge = float(np.quantile(u, 0.97))
    strip = depth[u > edge - max(_STRIP, 1.2 * spacing)]
    if len(strip) < FEW:
        return Face(0.0, wall, len(strip))
    front = depth_of = strip[np.abs(strip - np.quantile(strip, 0.2)) < wall]
    return Face(float(depth_of.mean()), float(front.std() / np.sqrt(len(front))), len(front))


def _reveal_line(u: Float, depth: Float, noise: float, slope: Float) -> tuple[float, float] | None:
    """Where a reveal begins, m, and its sigma, from its own points; it may slant a little."""
    if len(u) < 4:
        return None
    keep = np.abs(u - np.median(u)) < 0.02 + _SPLAY * depth
    u, depth, slope = u[keep], depth[keep], slope[keep]
    if len(u) < 4:
        return None
    sigma = float(np.hypot(noise * np.median(np.abs(slope)), _FLOOR))
    design = np.column_stack([np.ones(len(u)), depth])
    normal = design.T @ design / sigma**2 + np.diag([0.0, 1.0 / _SPLAY**2])
    inverse = np.linalg.inv(normal)
    start = inverse @ (design.T @ u / sigma**2)
    spread = float(np.sqrt(np.mean((u - design @ start) ** 2))) / sigma
    return float(start[0]), float(np.sqrt(inverse[0, 0]) * max(spread, 1.0) + _FLOOR)


def _reveal(line: tuple[float, float] | None, e: Float) -> Float:
    """Log-likelihood (k,) of borders at e m by the reveal's own points."""
    if line is None:
        return np.zeros(len(e))
    fit = np.exp(-0.5 * ((e - line[0]) / line[1]) ** 2) / (line[1] * np.sqrt(2 * np.pi))
    return np.asarray(np.log((1 - _OUTLIER) * fit + _OUTLIER / np.ptp(e)))


def side_scores(
    solid: Float, opened: Float, e: Float, blur: float, strays: tuple[float, float] = (_STRAY, _STRAY)
) -> Float:
    """Log-likelihood (k,) of borders at e m, equally spaced by the step of the posterior, and rising.

    solid, opened  (n,), (m,) m, beams on the wall (below the border) and through the opening (above it)

    Every beam is on its own side, blurred (one sigma `blur` m), but for `strays`, the shares of solid and
    opened ones that are not: sum log(s + (1 - s) Phi(.)).
    """
    step = float(e[1] - e[0])
    n = int(6.0 * blur / step) + 1
    lag = (np.arange(-n, n) + 0.5) * step  # of a bin's centre behind a border
    low = min(float(e[0]), *(float(u.min()) for u in (solid, opened) if len(u)))
    high = max(float(e[-1]), *(float(u.max()) for u in (solid, opened) if len(u)))
    ahead = int((float(e[0]) - low) / step) + n + 1
    bins = ahead + len(e) + int(max(high - float(e[-1]), 0.0) / step) + n + 1
    total = np.zeros(len(e))
    for u, side, stray in ((solid, -1.0, strays[0]), (opened, 1.0, strays[1])):
        bin_ = np.floor((u - float(e[0])) / step).astype(np.int64) + ahead
        count = np.bincount(bin_, minlength=bins).astype(np.float64)
        near = np.log(stray + (1 - stray) * ndtr(side * lag / blur))
        near -= np.log(stray) * (side * lag < 0)  # far from the border all is certain: counted below
        below = np.concatenate([[0.0], np.cumsum(count)])[ahead : ahead + len(e)]
        wrong = below if side > 0 else len(u) - below
        local = np.convolve(count, near[::-1])[ahead + n - 1 : ahead + n - 1 + len(e)]
        total += local + np.log(stray) * wrong
    return total


def _strays(u: Float, low: float) -> float:
    """Share of points (n,) on the wrong side of their border, 1 to 90 %: rooms behind a wall, bars on it.

    Their own side is below `low` m; the wrong one as far on the other side.
    """
    own, wrong = int((u < low).sum()), int((u > -low).sum())
    return float(np.clip(wrong / max(own, 1), _STRAY, 0.9))


def _absences(strip: _Strip, reach: float, spacing: float, e: Float) -> Float:
    """Log-likelihood (k,) of borders at e m by the beams that did not come, where nothing hides the wall.

    Rasters are regular: what counts is not how many points a side has but how wide the gaps between them are.
    """
    fine = np.arange(-reach, reach + 0.001, 0.002)
    count = [np.histogram(u, fine)[0].astype(np.float64) for u in (strip.solid, strip.opened, strip.stopped)]
    wide = spacing / 0.002
    total = ndimage.gaussian_filter1d(count[0] + count[1] + count[2], wide)
    free = 1.0 - ndimage.gaussian_filter1d(count[2], wide) / np.maximum(total, 1e-9)
    length = np.concatenate([[0.0], np.cumsum(np.clip(free, 0.0, 1.0)) * 0.002])
    before = np.interp(e, fine, length)
    solid = strip.solid[strip.solid < 0.0]
    opened = strip.opened[strip.opened > 0.0]
    # points of unknown sensors leave the edge's own shadow empty behind it
    rates = 1.0 / _gap(solid, reach), 1.0 / _gap(opened, reach) if strip.rays else 0.0
    return np.asarray(-(rates[0] * before + rates[1] * (length[-1] - before)))


def _gap(u: Float, reach: float) -> float:
    """Half the width m of the gap that a random place lies in; of single points their mean distance."""
    if len(u) < 2:
        return reach
    gap = np.diff(np.sort(u))
    return max(float((gap**2).sum() / gap.sum()) / 2.0, _STEP) if gap.sum() > 0 else reach
