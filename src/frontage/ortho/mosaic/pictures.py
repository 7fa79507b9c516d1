"""The photos rectified on the cells of a plan, in linear light: what mosaics are decided on."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool
from frontage.model import Camera, Photo
from frontage.ortho.rectified import CellPhotos
from frontage.ortho.views import ViewPlan
from frontage.raster.light import linear_light

_DARKEST = 0.004  # of a saturated pixel: below, the light of an 8-bit picture is known to a third at best
_BRIGHTEST = 0.9
_LOG_LIGHT = np.log(np.maximum(linear_light(np.arange(256, dtype=np.uint8)), np.float32(_DARKEST)))


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

    @cached_property
    def exposed(self) -> Bool:
        """The cells (k, h, w) that are neither too dark nor saturated in any channel."""
        low, high = np.float32(np.log(2 * _DARKEST)), np.float32(np.log(_BRIGHTEST))
        exposed = self.shown.copy()
        for channel in range(3):
            light = self.log_light[..., channel]
            exposed &= (light > low) & (light < high)
        return exposed


def cell_pictures(plan: ViewPlan, rectified: CellPhotos) -> CellPictures:
    """Returns the light of every photo of a plan on its cells."""
    shape = (len(plan.photos), plan.cells.height, plan.cells.width)
    log_light = np.zeros((*shape, 3), np.float32)
    radius, shown = np.zeros(shape, np.float32), plan.quality > 0
    for k, photo in enumerate(plan.photos):
        found = rectified(photo, shown[k])
        log_light[k] = cv2.LUT(cv2.cvtColor(found.codes, cv2.COLOR_RGBA2RGB), _LOG_LIGHT)
        log_light[k][~shown[k]] = 0.0
        radius[k] = found.radius * shown[k]
    return CellPictures(log_light, radius, shown)


def picked(bands: Array, number: Array) -> Array:
    """The values (h, w, ...) of bands (k, h, w, ...), of each cell those of the band of its `number` (h, w).

    Whole bands are copied through masks, which is several times as fast as picking cell by cell.
    """
    out: Array = bands[0].copy()
    for k in range(1, len(bands)):
        cv2.copyTo(bands[k], (number == k).view(np.uint8), out)
    return out


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
