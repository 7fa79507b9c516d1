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
    added, light = np.empty_like(pictures.log_light), np.empty_like(pictures.log_light)
    for k, radius in enumerate(pictures.radius):
        added[k] = gains.at(k, radius)
        cv2.subtract(pictures.log_light[k], added[k], dst=light[k])
    mosaic = picked(light, filled)
    used = np.unique(label[label >= 0]).tolist()
    for k in used:
        cv2.copyTo(mosaic, (~(usable[k] | (label == k))).view(np.uint8), light[k])
    blended = _blend([light[k] for k in used], [filled == k for k in used])
    for k in used:
        rest = cv2.GaussianBlur(cv2.subtract(blended, light[k]), (0, 0), _FINEST_CELLS)
        cv2.subtract(np.clip(rest, -_FACTOR, _FACTOR, out=rest), added[k], dst=added[k])
    return added


def _blend(pictures: list[Array], masks: list[Bool]) -> Array:
    """Blends pictures (h, w, 3) float32 of which each cell is covered by one of the masks (h, w).

    The finest band comes from one picture each; the shares of coarser ones change from cell to cell.
    """
    finest, total, weight = np.zeros_like(pictures[0]), list[Array](), list[Array]()
    for picture, mask in zip(pictures, masks, strict=True):
        own, *coarser = _bands(picture)
        cv2.copyTo(own, mask.view(np.uint8), finest)
        share = mask.astype(np.float32)
        for number, current in enumerate(coarser):
            share = cv2.pyrDown(share)
            if number == len(total):
                total.append(np.zeros_like(current))
                weight.append(np.zeros_like(share))
            total[number] += current * share[..., None]
            weight[number] += share
    bands = [finest, *(t / np.maximum(w, 1e-6)[..., None] for t, w in zip(total, weight, strict=True))]
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
        bands.append(cv2.subtract(rest, cv2.pyrUp(coarse, dstsize=rest.shape[1::-1])))
        rest = coarse
    return [*bands, rest]
