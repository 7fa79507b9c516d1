"""Projects the pixels of a facade into a photo (paper A, section 3.1)."""

from collections.abc import Callable
from functools import lru_cache
from math import comb

import cv2
import numpy as np
from numpy.polynomial.chebyshev import cheb2poly

from frontage.geometry import camera as maths
from frontage.geometry.arrays import Array, Float
from frontage.geometry.homography import apply_homography, homography_from_pose
from frontage.model import Facade, Photo
from frontage.ortho.orthoraster import OrthoRaster
from frontage.raster.sourcemap import SourceMap, fitted, jacobian_of
from frontage.raster.tiles import Tile

MAP_ERROR_PX = 0.01  # in the photo: by how much a polynomial may differ from the projection
# Degrees of the polynomials of a tile, in columns and rows and in depth; higher ones cost more than
# projecting every pixel. Balconies and deep entrances near the photo need the higher ones in depth.
_DEGREES = ((5, 2), (5, 3), (5, 4), (9, 6))
_SMALL_PX = 256  # sides of tiles to which lower degrees fit as well
_SMALL_DEGREES = ((3, 2), *_DEGREES)
_DROPPED_PX = 0.001  # in the photo: powers of the depth and degrees with less effect are dropped
_FLAT_M = 1e-4  # relief within a tile that no photo resolves

PixelMap = Callable[[Array, Array, Array | float], Float]
"""From (column, row, y in m) of the raster, any shape (...), to photo pixels (..., 2); NaN = not seen."""


def full_projection(photo: Photo, facade: Facade, raster: OrthoRaster) -> PixelMap:
    """Returns the map with lens distortion and relief, exact for every camera model."""
    camera_from_facade = photo.pose.inverse @ facade.frame

    def to_photo(column: Array, row: Array, y: Array | float) -> Float:
        xyz = raster.xyz(column, row, y)
        flat = photo.camera.project(camera_from_facade.apply(xyz.reshape(-1, 3)))
        return flat.reshape(*xyz.shape[:-1], 2)

    return to_photo


def plane_homography(photo: Photo, facade: Facade, raster: OrthoRaster) -> Float:
    """Returns paper A's homography (3, 3) from raster to photo pixels: no distortion, the plane y = 0."""
    camera_from_facade = photo.pose.inverse @ facade.frame
    K = maths.calibration_matrix(photo.camera.model, photo.camera.params)
    return homography_from_pose(K, camera_from_facade.R, camera_from_facade.t, raster.facade_from_pixel)


def homography_projection(photo: Photo, facade: Facade, raster: OrthoRaster) -> PixelMap:
    """Returns `plane_homography` as a map; as in the paper, it knows neither distortion nor relief."""
    H = plane_homography(photo, facade, raster)

    def to_photo(column: Array, row: Array, _: Array | float) -> Float:
        column, row = np.broadcast_arrays(column, row)
        flat = np.column_stack([column.ravel(), row.ravel()]).astype(np.float64)
        return apply_homography(H, flat).reshape(*column.shape, 2)

    return to_photo


def pixel_map(photo: Photo, facade: Facade, raster: OrthoRaster, projection: str) -> PixelMap:
    """Returns the map that the option `projection` names: "full" or "homography"."""
    return (full_projection if projection == "full" else homography_projection)(photo, facade, raster)


def shifted(to_photo: PixelMap, offset: float) -> PixelMap:
    """Returns the map of a surface that lies `offset` m farther behind the plane."""
    if offset == 0.0:
        return to_photo
    return lambda column, row, y: to_photo(column, row, y + offset)


def map_tile(to_photo: PixelMap, tile: Tile, y: Array | None, most_error: float = MAP_ERROR_PX) -> SourceMap:
    """Computes where the pixel centres of a tile lie in the photo.

    They lie on a relief y (m, n) m, or on the plane where y is None or NaN. The map is a polynomial if one of
    `_DEGREES` has an error of at most `most_error` px of the photo; otherwise every pixel is projected.
    """
    depth = None if y is None else np.asarray(y, np.float32)
    low, high = 0.0, 0.0
    if depth is not None:
        if np.isnan(cv2.sumElems(depth)[0]):
            depth = np.nan_to_num(depth, nan=0.0)
        low, high = _range(*cv2.minMaxLoc(depth)[:2])
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    columns, rows = 0.5 * (tile.c0 + tile.c1), 0.5 * (tile.r0 + tile.r1)
    half_width, half_height = 0.5 * (tile.c1 - tile.c0), 0.5 * (tile.r1 - tile.r0)

    def at(c: Array, r: Array, d: Array) -> Float:
        return to_photo(columns + half_width * c, rows + half_height * r, middle + half * d)

    for degree, depth_degree in _SMALL_DEGREES if max(tile.shape) <= _SMALL_PX else _DEGREES:
        found = fitted(at, degree, depth_degree if half > 0.0 else 0)
        if found.error <= most_error:
            jacobian = np.column_stack(
                [found.factors[0, 0, 1] / half_width, found.factors[0, 1, 0] / half_height]
            )
            powers = _powers(found.factors, middle, half)
            used = depth if len(powers) > 1 else None
            return SourceMap(powers, tile.shape, jacobian, found.low, found.high, depth=used)
    c, r = np.arange(tile.c0, tile.c1) + 0.5, np.arange(tile.r0, tile.r1) + 0.5
    every = to_photo(c[None, :], r[:, None], 0.0 if depth is None else depth)
    return SourceMap.of_pixels(every, jacobian_of(every))


def _range(low: float, high: float) -> tuple[float, float]:
    """Smallest and largest depth of a tile; their mean twice when they differ by less than 0.1 mm."""
    middle = 0.5 * (low + high)
    return (middle, middle) if high - low < _FLAT_M else (low, high)


def _powers(factors: Float, middle: float, half: float) -> tuple[Float, ...]:
    """Converts coefficients (k, p, q, 2) px of T_k(t), |t| <= 1, to those of powers of ``middle + half t``.

    Powers without effect are dropped before, because they would be divided by powers of `half`.
    """
    shape = factors.shape
    powers = (_to_powers(len(factors)) @ factors.reshape(len(factors), -1)).reshape(shape)
    most = np.abs(powers).max(-1).sum((1, 2)).tolist()
    count = max([1, *(k + 1 for k, effect in enumerate(most) if effect > _DROPPED_PX)])
    powers = powers[:count]
    if count > 1:
        moved = _moved(count, middle, half) @ powers.reshape(count, -1)
        powers = moved.reshape(count, *shape[1:])
    largest = abs(middle) + half if count > 1 else 1.0
    return tuple(_without_high_degrees(power, largest**k) for k, power in enumerate(powers))


def _without_high_degrees(factors: Float, weight: float) -> Float:
    """The coefficients (p, q, 2) px without the highest degrees of rows and columns that have no effect.

    `weight` is the largest value that they are multiplied by.
    """
    effect = np.abs(factors).max(-1) * weight
    p, q = (_needed(effect.sum(axis).tolist()) for axis in (1, 0))
    return factors[:p, :q]


def _needed(effects: list[float]) -> int:
    """How many of the first degrees, whose effects (px) are given, differ visibly from all of them."""
    count, rest = len(effects), 0.0
    while count > 1 and (rest := rest + effects[count - 1]) <= _DROPPED_PX:
        count -= 1
    return count


def _moved(count: int, middle: float, half: float) -> Float:
    """The matrix (count, count) from coefficients of powers of t to those of ``middle + half t``."""
    return np.array(
        [
            [comb(k, j) * (-middle) ** (k - j) / half**k if k >= j else 0.0 for k in range(count)]
            for j in range(count)
        ]
    )


@lru_cache(maxsize=8)
def _to_powers(count: int) -> Float:
    """The matrix (count, count) from coefficients of Chebyshev polynomials to those of powers."""
    matrix = np.zeros((count, count))
    for k in range(count):
        column = cheb2poly(np.eye(count)[k, : k + 1])
        matrix[: len(column), k] = column
    return matrix
