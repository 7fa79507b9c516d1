"""Checks whether the photos and the scan agree about the depth of the facade.

The picture is drawn from the photos on a surface that the scan measured. If that surface is off by d along
the normal of the facade, a photo taken under the angle theta shows everything displaced by ``d tan(theta)``,
and two photos displace it differently. Patches rectified from two photos are therefore compared. Their shift
along the base gives d, which is a multi-image intersection with a single unknown. Their shift across the base
does not depend on the depth and tells how well the two poses agree.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.geometry.rigid import skew
from frontage.model import Facade, Photo, PhotoOffset
from frontage.ortho.checks.patches import without_shading
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.project import map_tile
from frontage.ortho.surface import DrawingSurface, ImageOf
from frontage.ortho.views import ViewPlan
from frontage.raster.resample import resample
from frontage.raster.tiles import Tile, tiles

_PATCH_PX = 128
_PATCHES = 40  # at most, evenly spread; their mean is about six times as certain as a single one
_FEWEST_PATCHES = 8  # for an estimate
_PHOTOS = 4  # at most, those with the widest bases; more would only take longer
_NARROW = 0.6  # of the widest base of a patch; narrower ones have a third of its weight and tell little more
_CLEAR = 0.98  # share of a patch that nothing may hide
_TEXTURE = 2.0  # grey values, standard deviation of a patch without its shading
_ALIKE = 0.6  # correlation of two patches after the shift, above which both show the same thing
_STEPS = 3  # iterations of least-squares matching
_CONVERGED_PX = 0.001
_MATCHING_PX = 0.01  # common error of all shifts, from the maps and the interpolation of the patches
_OUTLIER = 3.0  # robust standard deviations
_SURE = 3.0  # standard errors, of scan and photos together, beyond which a difference is significant
_VISIBLE_PX = 0.1  # displacement from which an offset matters
_LEFT = 0.5  # share of an offset that may remain after it was applied; otherwise it explains nothing


@dataclass(frozen=True)
class _Pairs:
    """One row per comparison: numbers of the patch and of the pair of photos (n,), offset in depth (n,) m,
    weight (n,) px^2/m^2 (the squared base), and shift across the base (n,) px."""

    patch: Int
    pair: Int
    depth: Float
    weight: Float
    across: Float


def photo_offset(
    surface: DrawingSurface, plan: ViewPlan | None, image_of: ImageOf, options: OrthoOptions
) -> PhotoOffset | None:
    """Measures how far behind the surface of the scan the photos see the facade.

    The offset is `applied` when it is significant against the uncertainty of scan and photos together and
    large enough to be visible. Returns None without a plan, with fewer than eight comparable patches, and for
    the homography, which knows no depth.
    """
    if plan is None or options.projection != "full":
        return None
    facade, raster = surface.facade, surface.raster
    patches, visible = _patches(raster, plan)
    centre = np.array([[0.5 * (t.c0 + t.c1), 0.5 * (t.r0 + t.r1)] for t in patches]).reshape(-1, 2)
    slopes = np.stack([_slopes(p, facade, raster, centre) for p in plan.photos])
    chosen = _widest(slopes, visible)
    if len(chosen) < 2:
        return None
    views = [(plan.photos[k], slopes[k], visible[k]) for k in chosen]
    reach = float(np.abs(slopes[chosen]).max())

    pose_px = _pose_error([photo for photo, _, _ in views], facade, raster)

    def measured(offset: float) -> PhotoOffset | None:
        return _estimate(_compare(replace(surface, offset=offset), patches, views, image_of), pose_px)

    def matters(found: PhotoOffset) -> bool:
        certain = abs(found.value) > _SURE * float(np.hypot(found.sigma, facade.sigma_plane))
        return certain and reach * abs(found.value) > _VISIBLE_PX

    first = measured(0.0)
    if first is None or not matters(first):
        return first
    rest = measured(first.value)  # on patches that are hardly shifted against each other any more
    if rest is None or abs(rest.value) > _LEFT * abs(first.value):
        return first
    total = replace(rest, value=first.value + rest.value)
    return replace(total, applied=matters(total))


def _patches(raster: OrthoRaster, plan: ViewPlan) -> tuple[list[Tile], Bool]:
    """Returns the patches that two photos or more see completely, and which photos see them (k, n) bool."""
    whole = [t for t in tiles(raster.height, raster.width, _PATCH_PX) if t.shape == (_PATCH_PX, _PATCH_PX)]
    seen = np.zeros((len(plan.photos), len(whole)), bool)
    for n, tile in enumerate(whole):
        r, c = (
            slice(a // plan.step, -(-b // plan.step)) for a, b in ((tile.r0, tile.r1), (tile.c0, tile.c1))
        )
        seen[:, n] = plan.clear[:, r, c].mean((1, 2)) >= _CLEAR
    shared = np.flatnonzero(seen.sum(0) >= 2)
    shared = shared[np.linspace(0, len(shared) - 1, min(len(shared), _PATCHES)).astype(int)]
    return [whole[n] for n in shared.tolist()], seen[:, shared]


def _slopes(photo: Photo, facade: Facade, raster: OrthoRaster, at: Float) -> Float:
    """Displacement (n, 2) px per metre of depth of what the photo shows at raster pixels (n, 2)."""
    centre = facade.frame.inverse.apply(photo.pose.t[None])[0]
    ray = raster.xyz(at[:, 0], at[:, 1]) - centre
    slopes: Float = np.column_stack([-ray[:, 0], ray[:, 2]]) / (ray[:, 1:2] * raster.gsd)
    return slopes


def _widest(slopes: Float, visible: Bool) -> list[int]:
    """Chooses the photos (at most `_PHOTOS`) whose pairs tell most about depth, by their squared bases."""
    k = len(slopes)
    worth = np.zeros((k, k))
    for a, b in combinations(range(k), 2):
        both = visible[a] & visible[b]
        worth[a, b] = worth[b, a] = ((slopes[a, both] - slopes[b, both]) ** 2).sum()
    if not worth.any():
        return []
    chosen = [int(v) for v in np.unravel_index(np.argmax(worth), worth.shape)]
    while len(chosen) < min(_PHOTOS, k):
        gain = worth[chosen].sum(0)
        gain[chosen] = -1.0
        if gain.max() <= 0.0:
            break
        chosen.append(int(np.argmax(gain)))
    return sorted(chosen)


def _compare(
    surface: DrawingSurface,
    patches: Sequence[Tile],
    views: Sequence[tuple[Photo, Float, Bool]],
    image_of: ImageOf,
) -> _Pairs:
    """Compares patches of pairs of photos with wide bases, holding one photo in memory at a time."""
    chosen = _wide_pairs(views)
    grey = []
    for number, (photo, _, _) in enumerate(views):
        image, to_photo = image_of(photo.id), surface.projection_into(photo, "full")
        shown = {}
        for n in sorted({n for n, pair, _ in chosen if number in pair}):
            at = map_tile(to_photo, patches[n], surface.depth(patches[n]))
            grey_values = resample(image, at, out=np.empty(at.shape, np.uint8))
            shown[n] = without_shading(grey_values.astype(np.float32))
        grey.append(shown)
    window = cv2.createHanningWindow((_PATCH_PX, _PATCH_PX), cv2.CV_32F)
    rows = []
    for n, (a, b), base in chosen:
        move, length = _shift(grey[a][n], grey[b][n], window), float(np.hypot(*base))
        if move is not None:
            along, across = base @ move / length, (base[0] * move[1] - base[1] * move[0]) / length
            rows.append((n, a * len(views) + b, along / length, length**2, across))
    table = np.array(rows, np.float64).reshape(-1, 5)
    return _Pairs(table[:, 0].astype(int), table[:, 1].astype(int), table[:, 2], table[:, 3], table[:, 4])


def _wide_pairs(views: Sequence[tuple[Photo, Float, Bool]]) -> list[tuple[int, tuple[int, int], Float]]:
    """The numbers of a patch and of two photos that see it, and their base (2,) px/m, patch by patch.

    Pairs with bases narrower than `_NARROW` of the widest are left out.
    """
    chosen = []
    for n in range(len(views[0][2])):
        seeing = [number for number, (_, _, visible) in enumerate(views) if visible[n]]
        bases = {(a, b): views[b][1][n] - views[a][1][n] for a, b in combinations(seeing, 2)}
        widest = max((float(np.hypot(*base)) for base in bases.values()), default=0.0)
        chosen += [(n, pair, base) for pair, base in bases.items() if np.hypot(*base) > _NARROW * widest]
    return chosen


def _pose_error(photos: Sequence[Photo], facade: Facade, raster: OrthoRaster) -> float:
    """Standard error, px per axis, of the shift between two photos that their poses bring about.

    A pose that is moved by v and turned by w about its camera moves what it shows at X by v + w x (X - C).
    """
    X = facade.frame.t
    variance = []
    for photo in photos:
        pose = photo.local_from_camera
        if pose is not None:
            J = np.column_stack([np.eye(3), -skew(X - pose.value.t)])
            moved = facade.frame.R.T @ (J @ pose.covariance @ J.T) @ facade.frame.R
            variance.append(0.5 * (moved[0, 0] + moved[2, 2]))
    return float(np.sqrt(2.0 * np.mean(variance)) / raster.gsd)


def _estimate(pairs: _Pairs, pose_px: float) -> PhotoOffset | None:
    """Returns the mean depth with its standard error; None when there are too few patches.

    Patches are independent samples; the pairs of one patch are not. The standard error adds to their scatter
    what all of them share: the error of the matching and the disagreement of the poses, because a pair that
    is shifted by p px across its base may be shifted as much along it. `pose_px` is what the standard errors
    of the poses let expect.
    """
    patch, index = np.unique(pairs.patch, return_inverse=True)
    if len(patch) < _FEWEST_PATCHES:
        return None
    depth = np.bincount(index, pairs.weight * pairs.depth) / np.bincount(index, pairs.weight)
    middle = float(np.median(depth))
    spread = 1.4826 * float(np.median(np.abs(depth - middle)))
    good = np.abs(depth - middle) <= _OUTLIER * spread
    mean, count = float(depth[good].mean()), int(good.sum())
    scatter = float(depth[good].std(ddof=1)) / np.sqrt(count)
    kept = good[index]
    poses = [np.median(pairs.across[kept & (pairs.pair == p)]) for p in np.unique(pairs.pair[kept])]
    base = np.sqrt(np.mean(pairs.weight[kept]))
    common = np.sqrt(np.mean(np.square(poses)) + _MATCHING_PX**2 + pose_px**2) / base
    return PhotoOffset(mean, float(np.hypot(scatter, common)), count, False)


def _shift(a: Array, b: Array, window: Array) -> Float | None:
    """Returns the shift (2,) px of patch b against a; None where texture or similarity is missing.

    Phase correlation is good to a tenth of a pixel but biased towards whole pixels. Least-squares matching
    removes the bias; it uses the gradients of both patches so that the noise of neither reduces the shift.
    """
    border = _PATCH_PX // 5
    inner = np.s_[border:-border, border:-border]
    spread = _spread(a[inner])
    if min(spread, _spread(b[inner])) < _TEXTURE:
        return None
    move = np.array(cv2.phaseCorrelate(a * window, b * window)[0])
    # The middle with one pixel around it, for gradients.
    around = np.s_[border - 1 : 1 - border, border - 1 : 1 - border]
    first = a[around] / np.float32(spread)
    size = (first.shape[1], first.shape[0])
    for _ in range(_STEPS):
        if np.hypot(*move) > _PATCH_PX / 8:
            return None
        M = np.array([[1.0, 0.0, move[0] + border - 1], [0.0, 1.0, move[1] + border - 1]])
        back = cv2.warpAffine(b, M, size, flags=cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP)
        second = back * np.float32(1.0 / max(_spread(back[1:-1, 1:-1]), 1e-6))
        if _correlation(first[1:-1, 1:-1], second[1:-1, 1:-1]) < _ALIKE:
            return None
        mean, rest = first + second, (first - second)[1:-1, 1:-1].ravel()
        slopes = np.empty((2, len(rest)), np.float32)  # to the right and down, times four
        np.subtract(mean[1:-1, 2:], mean[1:-1, :-2], out=slopes[0].reshape(size[1] - 2, size[0] - 2))
        np.subtract(mean[2:, 1:-1], mean[:-2, 1:-1], out=slopes[1].reshape(size[1] - 2, size[0] - 2))
        normal = (slopes @ slopes.T).astype(np.float64)
        if np.linalg.det(normal) <= 0.0:
            return None
        step = np.linalg.solve(normal, 4.0 * (slopes @ rest).astype(np.float64))
        move += step
        if np.hypot(*step) < _CONVERGED_PX:
            break
    return np.asarray(move, np.float64)


def _spread(values: Array) -> float:
    """The standard deviation of a picture (h, w)."""
    return float(cv2.meanStdDev(values)[1][0, 0])


def _correlation(a: Array, b: Array) -> float:
    """Correlation of two pictures (h, w), each of standard deviation 1."""
    shared = float(np.vdot(np.ascontiguousarray(a), np.ascontiguousarray(b))) / a.size
    return shared - cv2.mean(a)[0] * cv2.mean(b)[0]
