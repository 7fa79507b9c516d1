"""Photos that share points with a placed photo, but are in no block with it.

Two photos with hardly any other between them are oriented relative to one another, but their scale is not
known, so that incremental mapping cannot join them to a block. The scan knows it: where the rays of the
placed photo meet the scan are the points that the other photo is resected from. And photos of different
blocks, which were placed in the scan one by one, are tied to one another by what both show.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.sparse import csr_array

from frontage.geometry.arrays import Bool, Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Photo, Provenance
from frontage.orientation.alone import best_place, elsewhere
from frontage.orientation.network import TiePoints
from frontage.orientation.placed import Placed, Scene, agrees_with_prior, merged
from frontage.orientation.reflectance.render import Rendering, render, rendering_factor
from frontage.orientation.resection import resect
from frontage.orientation.result import Unoriented
from frontage.orientation.ties.reasons import is_copy

_FEWEST = 20  # points that agree
_LEAST_SHARE = 0.3  # of the points of a resection that agree
_PLACED_M = 0.03  # how well a placed photo is known before the adjustment,
_ADJUSTED_PX = 3.0  # and after its first one
_LEAST_ANGLE = np.radians(1.0)  # at which two rays must meet


def placed_by_neighbours(
    scene: Scene, placed: Sequence[Placed], unoriented: Sequence[Unoriented]
) -> tuple[list[Placed], list[Unoriented]]:
    """Resects photos without a place from what they share with placed ones, as long as there are any."""
    parts, known = list(placed), _Known(scene)
    for part in parts:
        known.add(part)
    number_of = {photo.id: k for k, photo in enumerate(scene.given)}
    waiting = {number_of[one.photo] for one in unoriented if not is_copy(one.reason)}
    tried: dict[int, int] = {}
    while new := _resected(scene, known, waiting, tried):
        parts.append(new)
        known.add(new)
        waiting -= set(new.numbers.tolist())
    return parts, [one for one in unoriented if number_of[one.photo] in waiting or is_copy(one.reason)]


def placed_again(
    scene: Scene, placed: Placed, refused: Sequence[Unoriented]
) -> tuple[Placed, list[Unoriented]]:
    """Looks for refused photos once more, now that the poses of their neighbours are adjusted.

    Cameras of rigs are not looked for: the other cameras of their exposures have told where they are.
    """
    carried = {name for rig in scene.rigs for exposure in rig.exposures for name in exposure.photos}
    free = [one for one in refused if one.photo not in carried]
    parts, still = placed_by_neighbours(scene, [placed], free)
    return merged(parts), [one for one in refused if one.photo in carried or one in still]


class _Known:
    """The placed photos by number, each with the scan drawn as it sees it, when that is asked for."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._photos: dict[int, Photo] = {}
        self._drawn: dict[int, Rendering] = {}
        self._seen: dict[tuple[int, int], _Seen] = {}

    def add(self, part: Placed) -> None:
        self._photos.update(zip(part.numbers.tolist(), part.photos, strict=True))

    def points(self, number: int) -> list["_Seen"]:
        """What each of the placed neighbours of a photo tells of it, where that is enough."""
        found = []
        for common in self._scene.common:
            for own, other in ((0, 1), (1, 0)):
                numbers = common.first, common.second
                if numbers[own] == number and numbers[other] in self._photos:
                    found.append(self._told(number, numbers[other], common.pixels[:, (own, other)]))
        return [seen for seen in found if len(seen.pixels) >= _FEWEST]

    def off(self, first: int, second: int, pixels: Float) -> Float:
        """How far (m,) m from pixels (m, 2, 2) the second photo should see the scan that the first one sees.

        NaN where the first one sees nothing of the scan.
        """
        xyz = self._drawing(first).behind(pixels[:, 0])
        photo = self._photos[second]
        off = np.linalg.norm(photo.project(xyz) - pixels[:, 1], axis=1)
        away = np.linalg.norm(xyz - photo.pose.t, axis=1)
        return np.asarray(off * away / photo.camera.params[0])

    def _told(self, number: int, neighbour: int, pixels: Float) -> "_Seen":
        """What one neighbour tells of a photo, from pixels (m, 2, 2) in the photo and in the neighbour."""
        if (number, neighbour) not in self._seen:
            drawing = self._drawing(neighbour)
            xyz = drawing.behind(pixels[:, 1])
            there = np.isfinite(xyz).all(1)
            away = np.linalg.norm(xyz[there] - drawing.photo.pose.t, axis=1)
            self._seen[number, neighbour] = _Seen(pixels[there, 0], xyz[there], away)
        return self._seen[number, neighbour]

    def _drawing(self, number: int) -> Rendering:
        if number not in self._drawn:
            photo, surface = self._photos[number], self._scene.surface
            self._drawn[number] = render(photo, surface, rendering_factor(photo, surface))
        return self._drawn[number]


@dataclass(frozen=True, eq=False)
class _Seen:
    """Pixels (n, 2) of a photo, the points (n, 3) m of the scan that a neighbour sees there, and how far
    (n,) m they are from it."""

    pixels: Float
    xyz: Float
    away: Float

    @staticmethod
    def joined(parts: Sequence["_Seen"]) -> "_Seen":
        return _Seen(*(np.concatenate([getattr(p, f) for p in parts]) for f in ("pixels", "xyz", "away")))


def _resected(scene: Scene, known: _Known, waiting: set[int], tried: dict[int, int]) -> Placed | None:
    """The first of the photos that can be resected, those with most points first.

    `tried` holds the number of neighbours with which a photo could not be resected: it waits for another one.
    """
    points = {number: seen for number in sorted(waiting) if (seen := known.points(number))}
    for number in sorted(points, key=lambda n: -sum(len(seen.pixels) for seen in points[n])):
        if tried.get(number) == len(points[number]):
            continue
        tried[number] = len(points[number])
        found = _placed(scene, scene.given[number], points[number])
        if found is not None:
            return Placed(np.array([number]), (found,), TiePoints.none())
    return None


def _placed(scene: Scene, photo: Photo, seen: Sequence[_Seen]) -> Photo | None:
    """The photo with its pose; where its neighbours tell different places, control points decide."""
    poses = [pose for one in seen if (pose := _pose(photo, one, scene.seed)) is not None]
    if any(elsewhere(pose, poses[0]) for pose in poses):
        return best_place(photo, poses, scene.surface, scene.image_of, scene.seed)
    pose = _pose(photo, _Seen.joined(seen), scene.seed)
    if pose is None:
        return None
    return replace(photo, local_from_camera=Estimate(pose, np.zeros((6, 6)), 0.0, Provenance.MEASURED))


def _pose(photo: Photo, seen: _Seen, seed: int) -> Rigid3 | None:
    """The pose that enough of the points agree with and that does not contradict the approximate one."""
    agree = _PLACED_M * float(photo.camera.params[0] / np.median(seen.away))
    found = resect(photo.camera, seen.pixels, seen.xyz, agree, seed=seed)
    enough = max(_FEWEST, _LEAST_SHARE * len(seen.pixels))
    if found is None or found.inliers.sum() < enough or not agrees_with_prior(found.pose, photo):
        return None
    return found.pose


def tied_to_neighbours(scene: Scene, placed: Placed) -> Placed:
    """Adds tie points to pairs that have none yet, where adjusted poses and the scan agree with them.

    Where windows repeat, the rays of different windows may meet as well, but before or behind the wall.
    """
    place = {number: k for k, number in enumerate(placed.numbers.tolist())}
    known, tied = _Known(scene), _tied(placed)
    known.add(placed)
    parts, count = [placed.ties], len(placed.ties.xyz)
    for pair in scene.common:
        if pair.first not in place or pair.second not in place:
            continue
        i, j = place[pair.first], place[pair.second]
        if tied[i, j]:
            continue
        xyz, good = _intersected(placed.photos[i], placed.photos[j], pair.pixels)
        if good.sum() >= _FEWEST:
            good &= known.off(pair.first, pair.second, pair.pixels) < _PLACED_M
        if good.sum() >= _FEWEST:
            parts.append(_ties(i, j, xyz[good], pair.pixels[good], count))
            count += int(good.sum())
    joined = (np.concatenate([getattr(t, f) for t in parts]) for f in ("xyz", "photo", "point", "pixels"))
    return replace(placed, ties=TiePoints(*joined))


def without_contradicted(scene: Scene, placed: Placed) -> Placed:
    """Leaves out the tie points that the scan contradicts.

    A false match of two photos that lies on its epipolar line leaves hardly a residual, and a third photo
    from the place of one of them agrees with it. A few such points turn a photo in which they lie far from
    others. Only the scan tells: their rays meet before or behind it. Where nothing was scanned, nothing is
    contradicted; and where most points of a pair are, its poses err and not its matches.
    """
    ties, known = placed.ties, _Known(scene)
    known.add(placed)
    false = np.zeros(len(ties.xyz), np.bool_)
    for i, j in combinations(range(len(placed.photos)), 2):
        points, pixels = _shared(ties, i, j)
        first, second = int(placed.numbers[i]), int(placed.numbers[j])
        if len(points):
            off = np.fmin(known.off(first, second, pixels), known.off(second, first, pixels[:, ::-1]))
            away = off >= _PLACED_M
            if away.sum() < (off < _PLACED_M).sum():
                false[points] |= away
    keep = ~false[ties.point]
    return replace(placed, ties=TiePoints(ties.xyz, ties.photo[keep], ties.point[keep], ties.pixels[keep]))


def _shared(ties: TiePoints, first: int, second: int) -> tuple[Int, Float]:
    """The tie points (m,) that two photos show, and their pixels (m, 2, 2) in both."""
    a, b = (np.flatnonzero(ties.photo == k) for k in (first, second))
    points, at, there = np.intersect1d(ties.point[a], ties.point[b], return_indices=True)
    return points, np.stack([ties.pixels[a[at]], ties.pixels[b[there]]], axis=1)


def _tied(placed: Placed) -> Bool:
    """Which photos (p, p) share tie points."""
    ties, shape = placed.ties, (len(placed.photos), len(placed.ties.xyz))
    sees = csr_array((np.ones(len(ties.photo)), (ties.photo, ties.point)), shape=shape)
    return np.asarray((sees @ sees.T).toarray() > 0)


def _ties(i: int, j: int, xyz: Float, pixels: Float, first: int) -> TiePoints:
    n = len(xyz)
    photo: Int = np.repeat([i, j], n)
    point: Int = np.tile(np.arange(first, first + n), 2)
    return TiePoints(xyz, photo, point, np.concatenate([pixels[:, 0], pixels[:, 1]]))


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
