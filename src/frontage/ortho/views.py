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
from frontage.ortho.surface import DrawingSurface
from frontage.ortho.visibility import visibility
from frontage.raster.tiles import Tile

_CELL_M = 0.04
_MAX_CELLS = 4_000_000
_MAX_VALUES = 12_000_000  # cells times photos: what is told of each must fit into memory
_SMOOTHING_M = 1.0  # window over which quality is averaged
_BORDER = 0.05  # share of the photo's width over which quality fades to zero


@dataclass(frozen=True)
class ViewPlan:
    """How k photos show a facade, by cells (h, w) of `step` x `step` pixels; the best photo comes first.

    quality  (k, h, w) float32, larger is better, 0 = not seen
    gsd      (k, h, w) float32 m, size of a pixel of the photo on the facade
    clear    (k, h, w) bool, seen with nothing in front
    behind   (k, h, w) bool, behind what stands free before the facade, such as trees and cars
    """

    cells: OrthoRaster
    step: int
    photos: tuple[Photo, ...]
    quality: Array
    gsd: Array
    clear: Bool
    behind: Bool

    def seeing(self, through: Bool) -> "ViewPlan":
        """Returns the plan in which photos see nothing behind free-standing things but in cells `through`."""
        seen = ~self.behind | through
        return replace(self, quality=self.quality * seen, behind=self.behind & ~through)

    def without(self, names: frozenset[str]) -> "ViewPlan | None":
        """Returns the plan without the photos of these ids; None when the others see nothing."""
        keep = [k for k, photo in enumerate(self.photos) if photo.id not in names]
        bands = {b: getattr(self, b)[keep] for b in ("quality", "gsd", "clear", "behind")}
        plan = replace(self, photos=tuple(self.photos[k] for k in keep), **bands)
        return plan if (plan.quality * ~plan.behind).any() else None

    def window(self, band: Array, tile: Tile) -> Array:
        """Returns the values (m, n) of a band of cells at the pixels of a tile."""
        rows, columns = np.arange(tile.r0, tile.r1) // self.step, np.arange(tile.c0, tile.c1) // self.step
        return band[rows[:, None], columns]


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
    coarse = replace(surface, raster=cells)
    measured = coarse.depth(Tile(0, cells.height, 0, cells.width))
    y = np.zeros((cells.height, cells.width)) if measured is None else measured.astype(np.float64)
    views = [v for p in photos if (v := _photo_view(p, coarse, y, options)) is not None]
    views = sorted(views, key=lambda v: -float(v.quality.sum()))[: options.max_photos]
    if not views:
        return None
    seen = [visibility(v.photo, v.at, coarse, y, occluders) for v in views]
    quality = np.stack([(s.factor * v.quality).astype(np.float32) for s, v in zip(seen, views, strict=True)])
    behind = np.stack([s.behind for s in seen]) & (quality > 0.0)
    if not (quality * ~behind).any():
        return None
    clear = np.stack([s.factor == 1.0 for s in seen]) & (quality > 0.0) & ~behind
    gsd = np.stack([v.gsd.astype(np.float32) for v in views])
    return ViewPlan(cells, step, tuple(v.photo for v in views), quality, gsd, clear, behind)


@dataclass(frozen=True)
class _PhotoView:
    """How a photo sees the cells: its pixels (h, w, 2), smoothed quality (h, w), effective gsd (h, w) m."""

    photo: Photo
    at: Float
    quality: Array
    gsd: Array


def _photo_view(photo: Photo, surface: DrawingSurface, y: Array, options: OrthoOptions) -> _PhotoView | None:
    """Projects the cells at depths y (h, w) m into a photo; None when it stands behind or looks elsewhere."""
    facade, cells = surface.facade, surface.raster
    centre = facade.frame.inverse.apply(photo.pose.t[None])[0]
    if centre[1] >= 0:
        return None
    column, row = np.arange(cells.width) + 0.5, np.arange(cells.height) + 0.5
    to_photo = surface.projection_into(photo, options.projection)
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
    k = max(1, round(_SMOOTHING_M / cells.gsd)) | 1
    smooth = cv2.blur(quality, (k, k), borderType=cv2.BORDER_REPLICATE)
    flat = to_photo(column[None, :], row[:, None], 0.0)
    return _PhotoView(
        photo, at, np.where(fade > 0, np.maximum(smooth, 1e-12), 0.0), _effective_gsd(flat, cells.gsd)
    )


def _effective_gsd(at: Float, gsd: float) -> Array:
    """Metres of facade per photo pixel (h, w) in the worse direction: gsd / smallest singular value of J."""
    if min(at.shape[:2]) < 2:
        return np.full(at.shape[:2], np.nan)
    (a, c), (b, d) = np.moveaxis(np.gradient(at, axis=1), -1, 0), np.moveaxis(np.gradient(at, axis=0), -1, 0)
    total, det = a * a + b * b + c * c + d * d, a * d - b * c
    with np.errstate(invalid="ignore", divide="ignore"):
        smallest = np.sqrt(np.maximum(total - np.sqrt(np.maximum(total**2 - 4 * det**2, 0.0)), 0.0) / 2)
        out: Array = gsd / smallest
    return out
