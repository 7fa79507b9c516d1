"""Tie points and the scan: ties are added where it agrees with them, and left out where it contradicts.

Photos of different blocks, which were placed in the scan one by one, are tied to one another by what both
show. And of the tie points of a block, those are left out that join different things.
"""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.sparse import csr_array

from frontage.geometry.arrays import Bool, Float, Int
from frontage.model import Photo
from frontage.orientation.network import TiePoints
from frontage.orientation.nouns import CommonPoints
from frontage.orientation.placed import Placed, Scene
from frontage.orientation.significance import CRITICAL_DISTANCE
from frontage.orientation.views import FEWEST, Views

_ADJUSTED_PX = 3.0  # how well rays meet after the first adjustment
_LEAST_ANGLE = np.radians(1.0)  # at which two rays must meet
_SHARES = np.array([0.5, 0.25])  # of the points of a pair that tell how far off all of them are
_FEWEST_AGREEING = 3  # photos of a point that some others contradict


def tied_to_neighbours(scene: Scene, placed: Placed, views: Views) -> Placed:
    """Adds tie points to pairs that have none yet, where adjusted poses and the scan agree with them.

    Where windows repeat, the rays of different windows may meet as well, but before or behind the wall.

    views  of the placed photos
    """
    place = {number: k for k, number in enumerate(placed.numbers.tolist())}
    tied = _tied(placed)
    parts, count = [placed.ties], len(placed.ties.xyz)
    for pair in scene.common:
        if pair.first not in place or pair.second not in place:
            continue
        i, j = place[pair.first], place[pair.second]
        if tied[i, j]:
            continue
        xyz, good = _intersected(placed.photos[i], placed.photos[j], pair.pixels)
        if good.sum() >= FEWEST:
            good &= views.off(pair.first, pair.second, pair.pixels) < CRITICAL_DISTANCE
        if good.sum() >= FEWEST:
            parts.append(_ties(i, j, xyz, pair, good, count))
            count += int(good.sum())
    return replace(placed, ties=TiePoints.joined(parts))


def without_contradicted(placed: Placed, views: Views) -> Placed:
    """Leaves out of the tie points what the scan contradicts.

    A false match of two photos that lies on its epipolar line leaves hardly a residual, and a third photo
    from the place of one of them agrees with it. A few such points turn a photo in which they lie far from
    others. Only the scan tells: their rays meet before or behind it. Where nothing was scanned, nothing is
    contradicted. Of a point that more photos show, those stay that agree with one another, if there are at
    least three and more than the others.

    views  of the placed photos
    """
    ties, rows = placed.ties, len(placed.ties.photo)
    pairs = [_asked(placed, views, i, j) for i, j in combinations(range(len(placed.photos)), 2)]
    none = np.empty((0, 2), np.int64)
    agreeing = np.concatenate([none, *(p.rows[p.off < CRITICAL_DISTANCE] for p in pairs)])
    contrary = np.concatenate([none, *(p.rows[p.off >= CRITICAL_DISTANCE] for p in pairs)])
    keep = np.ones(rows, np.bool_)
    while (left := contrary[keep[contrary].all(1)]).size:
        against, for_it = np.bincount(left.ravel(), minlength=rows), _count(agreeing, keep)
        some = np.flatnonzero(against)
        some = some[np.lexsort([for_it[some], -against[some], ties.point[some]])]
        keep[some[np.diff(ties.point[some], prepend=-1) > 0]] = False  # the worst one of every point
    keep &= _outnumbers(ties, keep, _count(agreeing, keep) > 0)
    return replace(placed, ties=ties.take(keep))


@dataclass(frozen=True, eq=False)
class _Asked:
    """What the scan tells of the tie points of two photos.

    rows  (m, 2), numbers of the measurements in either photo
    off   (m,) standard errors, how far the scan contradicts them; NaN where it tells nothing
    """

    rows: Int
    off: Float


def _asked(placed: Placed, views: Views, i: int, j: int) -> _Asked:
    """Asks the scan about the tie points of two photos, seen from either of them.

    Errors of the poses, and of the scan over larger parts of a wall, put all points off.
    """
    rows = _shared(placed.ties, i, j)
    if not len(rows):
        return _Asked(rows, np.empty(0))
    pixels = placed.ties.pixels[rows]
    first, second = int(placed.numbers[i]), int(placed.numbers[j])
    off = np.fmin(views.off(first, second, pixels), views.off(second, first, pixels[:, ::-1]))
    return _Asked(rows, off / _enlarged(off[np.isfinite(off)]))


def _enlarged(off: Float) -> float:
    """By how much all points of a pair are farther off than expected, from distances (m,) in standard errors.

    Half of the points tell it, or the nearest quarter, if that is much nearer: then most of them are false.
    """
    if not len(off):
        return 1.0
    expected = np.sqrt(-2.0 * np.log1p(-_SHARES))  # two dimensions: Rayleigh
    return max(1.0, float((np.quantile(off, _SHARES) / expected).min()))


def _count(pairs: Int, keep: Bool) -> Int:
    """In how many of pairs (k, 2) of rows each row (m,) occurs together with another one that is kept."""
    return np.bincount(pairs[keep[pairs].all(1)].ravel(), minlength=len(keep))


def _outnumbers(ties: TiePoints, keep: Bool, agrees: Bool) -> Bool:
    """Whether rows (m,) are of a point of which nothing is left out, or enough of it agrees."""
    n = len(ties.xyz)
    out = np.bincount(ties.point[~keep], minlength=n)
    rest = np.bincount(ties.point[keep & agrees], minlength=n)
    whole, enough = (out == 0)[ties.point], ((rest >= _FEWEST_AGREEING) & (rest > out))[ties.point]
    return np.asarray(whole | (enough & agrees))


def _shared(ties: TiePoints, first: int, second: int) -> Int:
    """The rows (m, 2) of the measurements of points that two photos both show."""
    a, b = (np.flatnonzero(ties.photo == k) for k in (first, second))
    _, at, there = np.intersect1d(ties.point[a], ties.point[b], return_indices=True)
    return np.column_stack([a[at], b[there]])


def _tied(placed: Placed) -> Bool:
    """Which photos (p, p) share tie points."""
    ties, shape = placed.ties, (len(placed.photos), len(placed.ties.xyz))
    sees = csr_array((np.ones(len(ties.photo)), (ties.photo, ties.point)), shape=shape)
    return np.asarray((sees @ sees.T).toarray() > 0)


def _ties(i: int, j: int, xyz: Float, pair: CommonPoints, good: Bool, first: int) -> TiePoints:
    n = int(good.sum())
    photo: Int = np.repeat([i, j], n)
    point: Int = np.tile(np.arange(first, first + n), 2)
    sizes = None if pair.sizes is None else pair.sizes[good].T.ravel()
    return TiePoints(xyz[good], photo, point, np.concatenate([pair.pixels[good, k] for k in (0, 1)]), sizes)


def _intersected(a: Photo, b: Photo, pixels: Float) -> tuple[Float, Bool]:
    """The points (m, 3) m nearest to both rays of pixels (m, 2, 2), and which agree with both photos."""
    (p, u), (q, v) = a.ray(pixels[:, 0]), b.ray(pixels[:, 1])
    cosine = (u * v).sum(1)
    with np.errstate(divide="ignore", invalid="ignore"):
        square = 1.0 - cosine**2
        w = q - p
        s = ((w * u).sum(-1) - cosine * (w * v).sum(-1)) / square
        t = (cosine * (w * u).sum(-1) - (w * v).sum(-1)) / square
        xyz = 0.5 * (p + u * s[:, None] + q + v * t[:, None])
        off = [np.linalg.norm(photo.project(xyz) - pixels[:, k], axis=1) for k, photo in enumerate((a, b))]
        good = (np.maximum(*off) < _ADJUSTED_PX) & (square > np.sin(_LEAST_ANGLE) ** 2) & (s > 0) & (t > 0)
    return xyz, np.asarray(good)
