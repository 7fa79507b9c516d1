"""Tells how well every photo shows every part of a facade, and from which it is hidden.

This is told on cells of a few pixels. The quality of a photo is ``cos(theta) / Z^2`` (pixel density times
frontality); it fades towards the border of the photo and is smoothed over a metre. What hides a cell is read
from depth buffers of the cloud (`visibility.py`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float
from frontage.model import Photo
from frontage.ortho.occluders import OccluderCloud
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.project import map_tile
from frontage.ortho.surface import DrawingSurface
from frontage.ortho.visibility import Visibility, visibility
from frontage.raster import interpolation
from frontage.raster.tiles import Tile, tiles

_CELL_M = 0.04
_MAX_CELLS = 4_000_000
_MAX_VALUES = 12_000_000  # cells times photos: what is told of each must fit into memory
_SMOOTHING_M = 1.0  # window over which quality is averaged
_TILE_CELLS = 512  # of which one polynomial takes the projection
_SURELY_PX = 64.0  # beyond the border of a photo; a polynomial is bounded at its nodes only
_MAP_ERROR_PX = 0.25  # in the photo: quality fades over many pixels
_SMOOTH_CELLS = 8  # between the places at which smooth quantities are computed
_BORDER = 0.05  # share of the photo's width over which quality fades to zero


@dataclass(frozen=True)
class ViewPlan:
    """How k photos show a facade, by cells (h, w) of `step` x `step` pixels; the best photo comes first.

    depth    (h, w) float32 m, of the cells
    quality  (k, h, w) float32, larger is better, 0 = not seen
    gsd      (k, h, w) float32 m, size of a pixel of the photo on the facade
    radius   (k, h, w) float32, distance from the middle of the photo, 1 = in its corner
    clear    (k, h, w) bool, seen with nothing in front
    behind   (k, h, w) bool, behind what stands free before the facade, such as trees and cars
    solid    (k, h, w) bool, behind what has no gaps, such as cars
    """

    cells: OrthoRaster
    step: int
    depth: Array
    photos: tuple[Photo, ...]
    quality: Array
    gsd: Array
    radius: Array
    clear: Bool
    behind: Bool
    solid: Bool

    def seeing(self, through: Bool) -> "ViewPlan":
        """Returns the plan in which photos see nothing behind free-standing things but in cells `through`."""
        seen = ~self.behind | through
        return replace(self, quality=self.quality * seen, behind=self.behind & ~through)

    def without(self, names: frozenset[str]) -> "ViewPlan | None":
        """Returns the plan without the photos of these ids; None when the others see nothing."""
        keep = [k for k, photo in enumerate(self.photos) if photo.id not in names]
        bands = {b: getattr(self, b)[keep] for b in ("quality", "gsd", "radius", "clear", "behind", "solid")}
        plan = replace(self, photos=tuple(self.photos[k] for k in keep), **bands)
        return plan if (plan.quality * ~plan.behind).any() else None

    def of_tile(self, band: Array, tile: Tile) -> Array:
        """Returns the values of a band in the cells of a tile, which begins at a whole cell."""
        rows, columns = ((tile.r0, tile.r1), (tile.c0, tile.c1))
        (r0, r1), (c0, c1) = ((first // self.step, -(-last // self.step)) for first, last in (rows, columns))
        return band[r0:r1, c0:c1]


def plan_views(
    surface: DrawingSurface, occluders: OccluderCloud | None, photos: Sequence[Photo], options: OrthoOptions
) -> ViewPlan | None:
    """Tells how well the photos show every cell that they do not hide; None when none shows the facade."""
    if not photos or occluders is None:
        return None
    raster = surface.raster
    most = min(_MAX_CELLS, _MAX_VALUES // min(len(photos), options.max_photos))
    step = max(1, round(_CELL_M / raster.gsd), int(np.ceil(np.sqrt(raster.width * raster.height / most))))
    cells = raster.coarser(step)
    coarse = surface.on(cells)
    measured = coarse.depth(Tile(0, cells.height, 0, cells.width))
    y = np.zeros((cells.height, cells.width), np.float32) if measured is None else measured
    views = [v for p in photos if (v := _photo_view(p, coarse, y, options)) is not None]
    views = sorted(views, key=lambda v: -float(v.quality.sum()))[: options.max_photos]
    if not views:
        return None
    spacing = surface.facade.spacing
    seen = [_visible(v, cells, y, occluders, spacing) for v in views]
    quality = np.stack([s.factor * v.quality for s, v in zip(seen, views, strict=True)])
    behind = np.stack([s.behind for s in seen]) & (quality > 0.0)
    if not (quality * ~behind).any():
        return None
    clear = np.stack([s.factor == 1.0 for s in seen]) & (quality > 0.0) & ~behind
    scales = [_scale(v.photo, coarse, options) for v in views]
    gsd, radius = (np.stack(band) for band in zip(*scales, strict=True))
    solid = np.stack([s.solid for s in seen]) & behind
    used = tuple(v.photo for v in views)
    return ViewPlan(cells, step, y, used, quality, gsd, radius, clear, behind, solid)


@dataclass(frozen=True)
class _PhotoView:
    """How a photo sees the cells: its centre (3,) m in the facade frame, the distance (h, w) m of the cells
    from it, and their smoothed quality (h, w); both float32."""

    photo: Photo
    centre: Float
    distance: Array
    quality: Array


def _photo_view(photo: Photo, surface: DrawingSurface, y: Array, options: OrthoOptions) -> _PhotoView | None:
    """Looks at the cells at depths y (h, w) m from a photo; None when it stands behind or looks elsewhere."""
    cells = surface.raster
    centre = surface.facade.frame.inverse.apply(photo.pose.t[None])[0]
    if centre[1] >= 0:
        return None
    inset = _inset(photo, surface, y, options)
    if not (inset > 1.0).any():
        return None
    x = cells.corner[0] + (np.arange(cells.width) + 0.5) * cells.gsd - centre[0]
    z = cells.corner[1] - (np.arange(cells.height) + 0.5) * cells.gsd - centre[2]
    ahead = y - np.float32(centre[1])
    square = ahead * ahead + (x * x).astype(np.float32) + (z * z).astype(np.float32)[:, None]
    distance = np.sqrt(square)
    fade = np.clip((inset - 1.0) / (_BORDER * max(photo.camera.width, photo.camera.height)), 0.0, 1.0)
    quality = np.maximum(ahead, 0.0) / (square * distance) * fade
    k = max(1, round(_SMOOTHING_M / cells.gsd)) | 1
    smooth = cv2.blur(quality, (k, k), borderType=cv2.BORDER_REPLICATE)
    return _PhotoView(photo, centre, distance, np.where(fade > 0, np.maximum(smooth, np.float32(1e-12)), 0))


def _visible(
    view: _PhotoView, cells: OrthoRaster, y: Array, cloud: OccluderCloud, spacing: float
) -> Visibility:
    """How a photo sees the cells at depths y (h, w) m; those that it does not show are hidden."""
    shown = view.quality > 0.0
    rows, columns = (np.flatnonzero(shown.any(axis)) for axis in (1, 0))
    tile = Tile(int(rows[0]), int(rows[-1]) + 1, int(columns[0]), int(columns[-1]) + 1)
    part = tile.window
    found = visibility(view.centre, cells.part(tile), y[part], view.distance[part], cloud, spacing)
    whole = Visibility(np.zeros_like(y), np.zeros_like(shown), np.zeros_like(shown))
    for band in ("factor", "behind", "solid"):
        getattr(whole, band)[part] = getattr(found, band)
    return whole


def _inset(photo: Photo, surface: DrawingSurface, y: Array, options: OrthoOptions) -> Array:
    """Distance (h, w) float32 px of the cells from the border of a photo; -1 outside.

    Tiles whose outermost cells all lie beyond one side of the photo are not projected cell by cell, because
    most photos of a street do not show a facade.
    """
    size = np.array([photo.camera.width, photo.camera.height])
    inset = np.full(y.shape, -1.0, np.float32)
    to_photo = surface.projection_into(photo, options.projection)
    for tile in tiles(y.shape[0], y.shape[1], _TILE_CELLS):
        at = map_tile(to_photo, tile, y[tile.window], _MAP_ERROR_PX)
        beside = (at.high < -_SURELY_PX) | (at.low > size + _SURELY_PX)
        if beside.any() or not np.isfinite(at.low).all():
            continue
        u, v = at.planes((-0.5, -0.5), 1.0)
        w, h = (np.float32(n) for n in size)
        np.minimum(np.minimum(u, w - u), np.minimum(v, h - v), out=inset[tile.window])
    return inset


def _scale(photo: Photo, surface: DrawingSurface, options: OrthoOptions) -> tuple[Array, Array]:
    """Returns how large photo pixels are on the plane, and how far they lie from the middle of the photo.

    The size (h, w) float32 is in m of the facade, in the worse direction. The distance (h, w) float32 is 1 in
    the corners of the photo.

    The first is the pixel size over the smallest singular value of the Jacobian. Both are smooth: they are
    computed on a coarser raster and interpolated.
    """
    cells = surface.raster
    coarse = cells.coarser(_SMOOTH_CELLS)
    if min(coarse.width, coarse.height) < 2:
        coarse = cells
    column, row = np.arange(coarse.width) + 0.5, np.arange(coarse.height) + 0.5
    at = surface.on(coarse).projection_into(photo, options.projection)(column[None, :], row[:, None], 0.0)
    half = 0.5 * np.array([photo.camera.width, photo.camera.height])
    radius = np.nan_to_num(np.linalg.norm(at - half, axis=-1) / np.linalg.norm(half), nan=1.0)
    gsd = _gsd(at, coarse.gsd)
    (r0, r1, c0, c1), u, v = coarse.window_of(cells, Tile(0, cells.height, 0, cells.width))
    both = np.dstack([gsd, radius]).astype(np.float32)[r0:r1, c0:c1]
    gsd, radius = cv2.split(interpolation.bilinear(both, u, v))
    return gsd, radius


def _gsd(at: Float, size: float) -> Float:
    """Metres of facade per photo pixel (h, w) in the worse direction, of places (h, w, 2) px in a photo.

    Their distance on the facade is `size` m; a single row or column tells nothing (NaN).
    """
    if min(at.shape[:2]) < 2:
        return np.full(at.shape[:2], np.nan)
    (a, c), (b, d) = np.moveaxis(np.gradient(at, axis=1), -1, 0), np.moveaxis(np.gradient(at, axis=0), -1, 0)
    total, det = a * a + b * b + c * c + d * d, a * d - b * c
    with np.errstate(invalid="ignore", divide="ignore"):
        smallest = np.sqrt(np.maximum(total - np.sqrt(np.maximum(total**2 - 4 * det**2, 0.0)), 0.0) / 2)
        return np.asarray(size / smallest)
