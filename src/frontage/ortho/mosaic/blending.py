"""The light that every photo is corrected by, so that no seam shows: bands of the mosaic blended on cells.

Bands coarser than a cell or two are blended over their own wavelength (Burt and Adelson, A multiresolution
spline with application to image mosaics, ACM TOG 1983); finer detail comes from one photo and is cut at the
seam. The result is a smooth factor per photo and cell. A picture of any size can therefore be painted tile by
tile, with one photo in memory.
"""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool
from frontage.ortho.mosaic.pictures import CellPictures, picked
from frontage.ortho.mosaic.radiometry import PhotoGains
from frontage.raster.gridding import nearest_filled

_BANDS = 6  # the coarsest is blended over 64 cells, about two and a half metres
_FINEST_CELLS = 1.0  # sigma: detail below is not blended
_FACTOR = 1.5  # largest logarithm of a correction beyond the gain of the photo


def light_corrections(label: Array, usable: Bool, pictures: CellPictures, gains: PhotoGains) -> Array:
    """Returns the logarithm (k, h, w, 3) float32 of the factor on the light of every photo.

    `label` (h, w) is the photo of every cell, and `usable` (k, h, w) are the cells in which a photo shows the
    wall well enough for its light to be blended into that of its neighbours.
    """
    filled = nearest_filled(np.where(label >= 0, label, np.nan).astype(np.float32)).astype(np.int16)
    added = np.empty_like(pictures.log_light)
    for k, radius in enumerate(pictures.radius):
        added[k] = gains.at(k, _one_farther(radius))
    light = pictures.log_light - added
    mosaic = picked(light, filled)
    used = np.unique(label[label >= 0]).tolist()
    for k in used:
        cv2.copyTo(mosaic, (~(usable[k] | (label == k))).view(np.uint8), light[k])
    blended = _blend([light[k] for k in used], [filled == k for k in used])
    for k in used:
        rest = cv2.GaussianBlur(blended - light[k], (0, 0), _FINEST_CELLS)
        added[k] = np.clip(rest, -_FACTOR, _FACTOR) - added[k]
    return added


def _one_farther(radius: Array) -> Array:
    """The distances (h, w) of a photo, 0 where it shows nothing; a cell there takes that of its neighbours.

    Corrections are interpolated between cells.
    """
    return np.asarray(np.where(radius > 0.0, radius, cv2.dilate(radius, np.ones((3, 3), np.uint8))))


def _blend(pictures: list[Array], masks: list[Bool]) -> Array:
    """Blends pictures (h, w, 3) float32 whose masks (h, w) together cover everything."""
    total: list[Array] = []
    weight: list[Array] = []
    for picture, mask in zip(pictures, masks, strict=True):
        share = mask.astype(np.float32)
        for number, current in enumerate(_bands(picture)):
            if number == len(total):
                total.append(np.zeros_like(current))
                weight.append(np.zeros(current.shape[:2], np.float32))
            total[number] += current * share[..., None]
            weight[number] += share
            share = cv2.pyrDown(share)
    bands = [t / np.maximum(w, 1e-6)[..., None] for t, w in zip(total, weight, strict=True)]
    out = bands[-1]
    for band in bands[-2::-1]:
        out = band + cv2.pyrUp(out, dstsize=band.shape[1::-1])
    return np.asarray(out)


def _bands(picture: Array) -> list[Array]:
    """The Laplacian pyramid of a picture, finest band first, as deep as its size allows."""
    bands: list[Array] = []
    rest = picture
    while len(bands) < _BANDS and min(rest.shape[:2]) >= 4:
        coarse = cv2.pyrDown(rest)
        bands.append(rest - cv2.pyrUp(coarse, dstsize=rest.shape[1::-1]))
        rest = coarse
    return [*bands, rest]
