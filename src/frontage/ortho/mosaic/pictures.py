"""The photos rectified on the cells of a plan, in linear light: what mosaics are decided on."""

from collections.abc import Sequence
from dataclasses import dataclass

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
_EXPOSED = np.flatnonzero(
    (np.float32(np.log(2 * _DARKEST)) < _LOG_LIGHT) & (np.float32(np.log(_BRIGHTEST)) > _LOG_LIGHT)
)
_FIRST, _LAST = int(_EXPOSED[0]), int(_EXPOSED[-1])  # codes that are neither too dark nor saturated


@dataclass(frozen=True, eq=False)
class CellPictures:
    """What k photos show in the cells (h, w) of a plan.

    log_light  (k, h, w, 3) float32, natural logarithm of linear light (1 = saturated)
    radius     (k, h, w) float32, distance from the middle of the photo, 1 = in its corner
    shown      (k, h, w) bool, where the photo shows the facade; elsewhere its light is 0
    exposed    (k, h, w) bool, where it is shown and neither too dark nor saturated in any channel
    """

    log_light: Array
    radius: Array
    shown: Bool
    exposed: Bool


def cell_pictures(plan: ViewPlan, rectified: CellPhotos) -> CellPictures:
    """Returns the light of every photo of a plan on its cells."""
    shape = (len(plan.photos), plan.cells.height, plan.cells.width)
    log_light = np.zeros((*shape, 3), np.float32)
    shown = plan.quality > 0
    exposed = np.empty(shape, np.bool_)
    for k, photo in enumerate(plan.photos):
        codes = rectified(photo, shown[k])
        light = cv2.LUT(cv2.cvtColor(codes, cv2.COLOR_RGBA2RGB), _LOG_LIGHT)
        cv2.copyTo(light, shown[k].view(np.uint8), log_light[k])
        well = cv2.inRange(codes, (_FIRST,) * 3 + (0,), (_LAST,) * 3 + (255,))
        np.logical_and(well, shown[k], out=exposed[k])
    return CellPictures(log_light, plan.radius, shown, exposed)


def picked(bands: Array | Sequence[Array], number: Array) -> Array:
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
