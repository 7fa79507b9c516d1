"""The photos rectified on the cells of a plan, in linear light: what mosaics are decided on."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Array, Bool
from frontage.model import Camera, Photo
from frontage.ortho.options import OrthoOptions
from frontage.ortho.project import map_tile
from frontage.ortho.surface import DrawingSurface, ImageOf
from frontage.ortho.views import ViewPlan
from frontage.raster.light import linear_light
from frontage.raster.resample import resample
from frontage.raster.tiles import tiles

_TILE_PX = 512
_DARKEST = 0.004  # of a saturated pixel: below, the light of an 8-bit picture is known to a third at best
_BRIGHTEST = 0.9


@dataclass(frozen=True, eq=False)
class CellPictures:
    """What k photos show in the cells (h, w) of a plan.

    log_light  (k, h, w, 3) float32, natural logarithm of linear light (1 = saturated)
    radius     (k, h, w) float32, distance from the middle of the photo, 1 = in its corner
    shown      (k, h, w) bool, where the photo shows the facade; elsewhere the others are 0
    """

    log_light: Array
    radius: Array
    shown: Bool

    @property
    def exposed(self) -> Bool:
        """The cells (k, h, w) that are neither too dark nor saturated in any channel."""
        low, high = np.log(2 * _DARKEST), np.log(_BRIGHTEST)
        return np.asarray(self.shown & ((self.log_light > low) & (self.log_light < high)).all(-1))


def rectify_photos(
    surface: DrawingSurface, plan: ViewPlan, image_of: ImageOf, options: OrthoOptions
) -> CellPictures:
    """Rectifies every photo of a plan on its cells, holding one photo in memory at a time."""
    shape = (len(plan.photos), plan.cells.height, plan.cells.width)
    log_light = np.zeros((*shape, 3), np.float32)
    radius, shown = np.zeros(shape, np.float32), plan.quality > 0
    coarse = replace(surface, raster=plan.cells)
    for k, photo in enumerate(plan.photos):
        image = image_of(photo.id)
        to_photo = coarse.projection_into(photo, options.projection)
        for tile in tiles(shape[1], shape[2], _TILE_PX):
            if not shown[k][tile.window].any():
                continue
            at = map_tile(to_photo, tile, coarse.depth(tile))
            inside = shown[k][tile.window]
            light = linear_light(resample(image, at)[..., :3])
            log_light[k][tile.window] = np.log(np.maximum(light, _DARKEST)) * inside[..., None]
            radius[k][tile.window] = _radius(photo, *at.planes((-0.5, -0.5), 1.0)) * inside
    return CellPictures(log_light, radius, shown)


def same_camera(photos: tuple[Photo, ...]) -> Array:
    """Numbers (k,) of the cameras of photos: the same for photos that share a camera."""
    known: list[tuple[object, ...]] = []
    numbers = []
    for photo in photos:
        key = _camera_key(photo.camera)
        if key not in known:
            known.append(key)
        numbers.append(known.index(key))
    return np.array(numbers, np.int64)


def _camera_key(camera: Camera) -> tuple[object, ...]:
    return camera.model, camera.width, camera.height, tuple(camera.params.tolist())


def _radius(photo: Photo, u: Array, v: Array) -> Array:
    """Distance of photo pixels (m, n) from the middle of the photo, in half diagonals."""
    w, h = photo.camera.width, photo.camera.height
    return np.asarray(np.hypot(u - 0.5 * w, v - 0.5 * h) / (0.5 * np.hypot(w, h)), np.float32)
