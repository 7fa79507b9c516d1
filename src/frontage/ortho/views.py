"""Which photo shows which part of a facade best, and whether anything stands in between.

Views are chosen on cells of some pixels: quality ``cos(theta) / Z^2`` (pixel density times frontality),
fading towards the photo's border and smoothed over a metre so that patches stay large, among the photos in
whose depth buffer (the cloud, splatted) the cell is not hidden. Nothing is blended;
what no photo sees stays nodata.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.model import Facade, Photo
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.project import pixel_map
from frontage.ortho.recess import DEEPEST_REVEAL
from frontage.ortho.relief import ReliefMap
from frontage.raster.tiles import Tile
from frontage.raster.zbuffer import splat_depth

_CELL = 0.04  # m
_MAX_CELLS = 4_000_000
_REDUCED = 4  # photo px per depth buffer px
_TOLERANCE = 0.15  # m: what stands less in front of a surface is that surface
_OCCLUDER = DEEPEST_REVEAL + _TOLERANCE  # m in front of the surface: not the facade's own wall, frame or sill
_SELF = 1e-4  # of its quality is what a cell counts that the facade itself hides: used when nothing else is
_BLUNT = 0.05  # m: discs that are larger do not know a sill's outline, and hide only what stands far behind
_LEAN = 2.0  # discs of up to twice the wall's typical spacing
_LOYALTY = 1.5  # how much a whole neighbourhood in one photo is worth, as a logarithm of quality
_AROUND = 0.3  # m: that neighbourhood
_ROUNDS = 6
_SPLAT = 0.75  # spacings: discs of this radius leave no gap on a square lattice seen from the front
_PATCH = 1.0  # m over which quality is smoothed
_BORDER = 0.05  # share of the photo's width over which quality fades to zero


@dataclass(frozen=True)
class ViewPlan:
    """Per cell: `label` (h, w) int16, index into `photos`, -1 = none; `gsd` (h, w) m of that photo; and which
    photos (k, h, w) bool see it with nothing in front."""

    cells: OrthoRaster
    step: int
    photos: tuple[Photo, ...]
    label: Array
    gsd: Array
    clear: Array

    def window(self, band: Array, tile: Tile) -> Array:
        """Values of a band of cells at the pixels of a tile."""
        rows, columns = np.arange(tile.r0, tile.r1) // self.step, np.arange(tile.c0, tile.c1) // self.step
        return band[rows[:, None], columns]


@dataclass(frozen=True)
class OccluderCloud:
    """What may hide the facade: points (n, 3) m local, spacing (n,) m of the surface each belongs to."""

    xyz: Float
    spacing: Float


def plan_views(
    facade: Facade,
    raster: OrthoRaster,
    relief: ReliefMap | None,
    cloud: OccluderCloud,
    photos: Sequence[Photo],
    options: OrthoOptions,
) -> ViewPlan | None:
    """The best unhidden photo of every cell; None when no photo shows the facade at all."""
    step = max(1, round(_CELL / raster.gsd), int(np.ceil(np.sqrt(raster.width * raster.height / _MAX_CELLS))))
    cells = raster.coarser(step)
    y = np.zeros((cells.height, cells.width))
    if relief is not None:
        measured = relief.at(cells, Tile(0, cells.height, 0, cells.width), filled=True)
        y = measured.astype(np.float64)
    views = [v for p in photos if (v := _photo_view(p, facade, cells, y, options)) is not None]
    views = sorted(views, key=lambda v: -float(v.quality.sum()))[: options.max_photos]
    if not views:
        return None
    visible = [_visibility(v, facade, cells, y, cloud) for v in views]
    quality = np.stack([free * v.quality for free, v in zip(visible, views, strict=True)])
    clear = np.stack([(free == 1.0) & (v.quality > 0.0) for free, v in zip(visible, views, strict=True)])
    label = _connected(quality, max(1, round(_AROUND / cells.gsd)))
    gsd = np.take_along_axis(np.stack([v.gsd for v in views]), label[None].astype(np.int64), 0)[0]
    seen = np.take_along_axis(quality, label[None].astype(np.int64), 0)[0] > 0
    label[~seen] = -1
    if not seen.any():
        return None
    chosen = tuple(v.photo for v in views)
    return ViewPlan(cells, step, chosen, label, np.where(seen, gsd, np.nan).astype(np.float32), clear)


@dataclass(frozen=True)
class _PhotoView:
    """A photo's look at the cells: pixels (h, w, 2), smoothed quality (h, w), effective gsd (h, w) m."""

    photo: Photo
    at: Float
    quality: Array
    gsd: Array


def _photo_view(
    photo: Photo, facade: Facade, cells: OrthoRaster, y: Array, options: OrthoOptions
) -> _PhotoView | None:
    """How a photo sees the cells, or None when it does not: behind the facade, or looking elsewhere."""
    centre = facade.frame.inverse.apply(photo.pose.t[None])[0]
    if centre[1] >= 0:
        return None
    column, row = np.arange(cells.width) + 0.5, np.arange(cells.height) + 0.5
    to_photo = pixel_map(photo, facade, cells, options.projection)
    at = to_photo(column[None, :], row[:, None], y)
    size = np.array([photo.camera.width, photo.camera.height])
    with np.errstate(invalid="ignore"):
        inset = np.minimum(at, size - at).min(-1)
    if not (inset > 1.0).any():
        return None
    ray = cells.xyz(column[None, :], row[:, None], y) - centre
    distance = np.linalg.norm(ray, axis=-1)
    cosine = np.maximum(ray[..., 1] / distance, 0.0)
    fade = np.clip(np.nan_to_num(inset - 1.0) / (_BORDER * size.max()), 0.0, 1.0)
    quality = cosine / distance**2 * fade
    k = max(1, round(_PATCH / cells.gsd)) | 1
    smooth = cv2.blur(quality, (k, k), borderType=cv2.BORDER_REPLICATE)
    flat = to_photo(column[None, :], row[:, None], 0.0)
    return _PhotoView(
        photo, at, np.where(fade > 0, np.maximum(smooth, 1e-12), 0.0), _effective_gsd(flat, cells.gsd)
    )


def _effective_gsd(at: Float, gsd: float) -> Array:
    """Metres of facade per photo pixel in the worse direction: gsd / smallest singular value of J."""
    if min(at.shape[:2]) < 2:
        return np.full(at.shape[:2], np.nan)
    (a, c), (b, d) = np.moveaxis(np.gradient(at, axis=1), -1, 0), np.moveaxis(np.gradient(at, axis=0), -1, 0)
    total, det = a * a + b * b + c * c + d * d, a * d - b * c
    with np.errstate(invalid="ignore", divide="ignore"):
        smallest = np.sqrt(np.maximum(total - np.sqrt(np.maximum(total**2 - 4 * det**2, 0.0)), 0.0) / 2)
        out: Array = gsd / smallest
    return out


def _connected(quality: Array, radius: int) -> Array:
    """The photo (h, w) int16 of every cell, of the highest quality (k, h, w) and what its neighbours take.

    Iterated conditional modes with a Potts term over a window of 2 `radius` + 1 cells: seams run where two
    photos are about equally good, not around single cells.
    """
    with np.errstate(divide="ignore"):
        score = np.log(quality.astype(np.float32))
    label: Array = np.argmax(score, axis=0)
    side = 2 * radius + 1
    for _ in range(_ROUNDS):
        together = [
            s + _LOYALTY * cv2.blur((label == i).astype(np.float32), (side, side))
            for i, s in enumerate(score)
        ]
        label = np.argmax(np.stack(together), axis=0)
    return np.asarray(label.astype(np.int16))


def _visibility(
    view: _PhotoView, facade: Facade, cells: OrthoRaster, y: Array, cloud: OccluderCloud
) -> Array:
    """1 for cells (h, w) with nothing in front, `_SELF` with parts of the facade itself there, else 0."""
    photo = view.photo
    camera_from_local = photo.pose.inverse
    reduced = (-(-photo.camera.height // _REDUCED), -(-photo.camera.width // _REDUCED))
    xyz = camera_from_local.apply(cloud.xyz)
    distance = np.linalg.norm(xyz, axis=1)
    at = photo.camera.project(xyz) / _REDUCED
    focal = _pixels_per_radian(photo) / _REDUCED
    radius = focal * _SPLAT * cloud.spacing / np.maximum(distance, 1e-6)
    buffer = splat_depth(at, distance, radius, reduced)
    column, row = np.arange(cells.width) + 0.5, np.arange(cells.height) + 0.5
    surface = facade.frame.apply(cells.xyz(column[None, :], row[:, None], y).reshape(-1, 3))
    ray = surface - photo.pose.t
    own = np.linalg.norm(ray, axis=1).reshape(y.shape)
    cosine = np.maximum((ray @ facade.frame.R[:, 1]).reshape(y.shape) / own, 1e-3)
    # discs face the photo: seen obliquely, those of the surface itself reach out in front of it
    slack = _LEAN * _SPLAT * facade.spacing * np.sqrt(np.maximum(1.0 / cosine**2 - 1.0, 0.0))
    u, v = np.nan_to_num(np.moveaxis(view.at, -1, 0), nan=0.0) / _REDUCED
    c, r = (np.clip(i.astype(np.int64), 0, n - 1) for i, n in ((u, reduced[1]), (v, reduced[0])))
    box = np.ones((3, 3), np.uint8)
    hidden = (buffer[r, c] < own - _TOLERANCE - slack).astype(np.uint8)
    # a cell between two hidden ones is hidden; and the outline of a tree or car is known to a cell at best
    occluder = cv2.dilate((buffer[r, c] < own - _OCCLUDER - slack).astype(np.uint8), box)
    if _SPLAT * facade.spacing > _BLUNT:
        hidden[:] = 0
    own_shade = cv2.morphologyEx(hidden, cv2.MORPH_CLOSE, box)
    visible: Array = np.where(occluder > 0, 0.0, np.where(own_shade > 0, _SELF, 1.0))
    return visible


def _pixels_per_radian(photo: Photo) -> float:
    """Photo px per radian at the principal axis, from the camera model itself."""
    ahead = photo.camera.project(np.array([[0.0, 0.0, 1.0], [1e-4, 0.0, 1.0]]))
    return float(np.linalg.norm(ahead[1] - ahead[0]) / 1e-4)
