"""Whether the photos agree with the scan about how far away the facade is.

A picture is drawn from the photos, on a surface that the scan measured. When that surface lies off by d along
the facade's normal, a photo under the angle theta shows everything displaced by ``d tan(theta)``, and two
photos displace it differently. So patches rectified from two photos are compared: their shift along the base
gives d, a multi-image intersection reduced to its one unknown; their shift across it, in which depth has no
say, tells how well the two poses agree at all.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.model import Facade, Photo, PhotoOffset
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.project import full_projection, map_tile, shifted
from frontage.ortho.relief import ReliefMap
from frontage.ortho.views import ViewPlan
from frontage.raster.resample import resample
from frontage.raster.tiles import Tile, tiles

_PATCH = 128  # px
_PATCHES = 80  # at most, evenly spread: their mean is a tenth as uncertain as one of them
_FEWEST = 8  # patches that make an estimate
_PHOTOS = 4  # at most: those with the widest bases; more would add time and little else
_CLEAR = 0.98  # share of a patch that must be free of what hides it
_TEXTURE = 2.0  # grey values, rms of a patch without its shading
_ALIKE = 0.6  # correlation of two patches after their shift: the same thing is seen
_STEPS = 3  # of least squares matching
_MATCHING = 0.01  # px that all shifts may be wrong by together: maps, and the interpolation of the patches
_OUTLIER = 3.0  # robust standard deviations
_SURE = 3.0  # standard deviations, of scan and photos together, that make a difference
_SEEN = 0.1  # px that an offset must displace something by to matter
_LEFT = 0.5  # share of an offset that may be left after it was taken away, or it explains nothing


@dataclass(frozen=True)
class _Pairs:
    """One row per patch compared: patch (n,) and pair (n,) numbers, depth (n,) m, weight (n,) px^2/m^2, shift
    across the base (n,) px."""

    patch: Int
    pair: Int
    depth: Float
    weight: Float
    across: Float


def photo_offset(
    facade: Facade,
    raster: OrthoRaster,
    relief: ReliefMap | None,
    plan: ViewPlan,
    image_of: Callable[[str], Array],
) -> PhotoOffset | None:
    """How far behind the scan's surface the photos see it; None when too few patches tell.

    It is `applied` where it is certain beyond the scan's and the photos' own uncertainty, and large enough
    to be seen.
    """
    patches, visible = _patches(raster, plan)
    centre = np.array([[0.5 * (t.c0 + t.c1), 0.5 * (t.r0 + t.r1)] for t in patches]).reshape(-1, 2)
    slopes = np.stack([_slopes(p, facade, raster, centre) for p in plan.photos])
    chosen = _widest(slopes, visible)
    if len(chosen) < 2:
        return None
    views = [(plan.photos[k], slopes[k], visible[k]) for k in chosen]
    reach = float(np.abs(slopes[chosen]).max())

    def measured(offset: float) -> PhotoOffset | None:
        return _estimate(_compared(facade, raster, relief, patches, views, image_of, offset))

    def matters(found: PhotoOffset) -> bool:
        certain = abs(found.value) > _SURE * float(np.hypot(found.sigma, facade.sigma_plane))
        return certain and reach * abs(found.value) > _SEEN

    first = measured(0.0)
    if first is None or not matters(first):
        return first
    rest = measured(first.value)  # on patches that are hardly shifted any more
    if rest is None or abs(rest.value) > _LEFT * abs(first.value):
        return first
    total = replace(rest, value=first.value + rest.value)
    return replace(total, applied=matters(total))


def _patches(raster: OrthoRaster, plan: ViewPlan) -> tuple[list[Tile], Bool]:
    """Patches that two photos or more see whole, and which photos (k, n) see which."""
    whole = [t for t in tiles(raster.height, raster.width, _PATCH) if t.shape == (_PATCH, _PATCH)]
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
    """Displacement (n, 2) px, per metre of depth, of what the photo shows at pixels (n, 2)."""
    centre = facade.frame.inverse.apply(photo.pose.t[None])[0]
    ray = raster.xyz(at[:, 0], at[:, 1]) - centre
    slopes: Float = np.column_stack([-ray[:, 0], ray[:, 2]]) / (ray[:, 1:2] * raster.gsd)
    return slopes


def _widest(slopes: Float, visible: Bool) -> list[int]:
    """The photos (at most `_PHOTOS`) whose pairs say most about depth: the sum of their squared bases."""
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


def _compared(
    facade: Facade,
    raster: OrthoRaster,
    relief: ReliefMap | None,
    patches: Sequence[Tile],
    views: Sequence[tuple[Photo, Float, Bool]],
    image_of: Callable[[str], Array],
    offset: float,
) -> _Pairs:
    """The patches of all pairs of photos compared, one photo in memory."""
    grey = []
    for photo, _, visible in views:
        image, to_photo = image_of(photo.id), shifted(full_projection(photo, facade, raster), offset)
        shown = {}
        for n in np.flatnonzero(visible).tolist():
            y = None if relief is None else relief.at(raster, patches[n], filled=True)
            shown[n] = _flattened(resample(image, map_tile(to_photo, patches[n], y)))
        grey.append(shown)
    window = cv2.createHanningWindow((_PATCH, _PATCH), cv2.CV_32F)
    rows = []
    for pair, (a, b) in enumerate(combinations(range(len(views)), 2)):
        for n in sorted(set(grey[a]) & set(grey[b])):
            base = views[b][1][n] - views[a][1][n]
            length = float(np.hypot(*base))
            move = _shift(grey[a][n], grey[b][n], window)
            if move is not None and length > 0.0:
                along, across = base @ move / length, (base[0] * move[1] - base[1] * move[0]) / length
                rows.append((n, pair, along / length, length**2, across))
    table = np.array(rows, np.float64).reshape(-1, 5)
    return _Pairs(table[:, 0].astype(int), table[:, 1].astype(int), table[:, 2], table[:, 3], table[:, 4])


def _estimate(pairs: _Pairs) -> PhotoOffset | None:
    """Mean depth with its standard error; None when the patches are few.

    Patches are the independent samples, a patch's pairs are not. To their scatter comes what they share: the
    matching's own error, and what the poses disagree by: pairs that shift by p px across their base may do so
    along it.
    """
    patch, index = np.unique(pairs.patch, return_inverse=True)
    if len(patch) < _FEWEST:
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
    common = np.sqrt(np.mean(np.square(poses)) + _MATCHING**2) / base
    return PhotoOffset(mean, float(np.hypot(scatter, common)), count, False)


def _flattened(pixels: Array) -> Array:
    """Grey values (h, w) float32 without what varies over a patch: shadows, exposure."""
    grey = cv2.cvtColor(pixels, cv2.COLOR_RGBA2GRAY).astype(np.float32)
    flat: Array = cv2.GaussianBlur(grey, (0, 0), 1.0) - cv2.GaussianBlur(grey, (0, 0), 8.0)
    return flat


def _shift(a: Array, b: Array, window: Array) -> Float | None:
    """Shift (2,) px of patch b against a; None without texture or likeness.

    Phase correlation finds it to a tenth of a pixel, but leans towards whole ones; least squares matching,
    with the slopes of both patches so that neither's noise flattens it, does not.
    """
    inner = np.s_[_PATCH // 5 : -_PATCH // 5, _PATCH // 5 : -_PATCH // 5]
    if min(float(a[inner].std()), float(b[inner].std())) < _TEXTURE:
        return None
    move = np.array(cv2.phaseCorrelate(a * window, b * window)[0])
    for _ in range(_STEPS):
        if np.hypot(*move) > _PATCH / 8:
            return None
        M = np.array([[1.0, 0.0, move[0]], [0.0, 1.0, move[1]]])
        back = cv2.warpAffine(b, M, (_PATCH, _PATCH), flags=cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP)
        if np.corrcoef(a[inner].ravel(), back[inner].ravel())[0, 1] < _ALIKE:
            return None
        down, right = np.gradient(0.5 * (a / a[inner].std() + back / back[inner].std()))
        slopes = np.column_stack([right[inner].ravel(), down[inner].ravel()])
        rest = (a / a[inner].std() - back / back[inner].std())[inner].ravel()
        move += np.linalg.lstsq(slopes, rest, rcond=None)[0]
    return np.asarray(move, np.float64)
