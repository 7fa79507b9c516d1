"""Where a facade pixel lies in a photo."""

from collections.abc import Callable

import cv2
import numpy as np

from frontage.geometry import camera as maths
from frontage.geometry.arrays import Array, Float
from frontage.geometry.homography import apply_homography, homography_from_pose
from frontage.model import Facade, Photo
from frontage.ortho.orthoraster import OrthoRaster
from frontage.raster.sourcemap import SourceMap, fitted, jacobian_of
from frontage.raster.tiles import Tile

FLAT_ERROR = 0.01  # photo px that a polynomial may differ from the projection
_DEGREES = (5, 9)  # of the polynomials of a tile; higher ones would cost more than projecting every pixel
_DEPTH_DEGREE = (
    2  # a pinhole's map is a rational function of y; over a relief its third order is below 0.01 px
)
_STRAIGHT = 0.001  # photo px that a second power of y must move something by
_FLAT = 1e-4  # m of relief within a tile that no photo resolves

PixelMap = Callable[[Array, Array, Array | float], Float]
"""(column, row, y in m) of the raster, any shape (...), to photo pixels (..., 2); NaN where it cannot see."""


def full_projection(photo: Photo, facade: Facade, raster: OrthoRaster) -> PixelMap:
    """The map with lens distortion and relief; exact for every camera model."""
    camera_from_facade = photo.pose.inverse @ facade.frame

    def to_photo(column: Array, row: Array, y: Array | float) -> Float:
        xyz = raster.xyz(column, row, y)
        flat = photo.camera.project(camera_from_facade.apply(xyz.reshape(-1, 3)))
        return flat.reshape(*xyz.shape[:-1], 2)

    return to_photo


def plane_homography(photo: Photo, facade: Facade, raster: OrthoRaster) -> Float:
    """Paper A's map (3, 3) from raster to photo pixels: the undistorted camera, the plane y = 0."""
    camera_from_facade = photo.pose.inverse @ facade.frame
    K = maths.calibration_matrix(photo.camera.model, photo.camera.params)
    return homography_from_pose(K, camera_from_facade.R, camera_from_facade.t, raster.facade_from_pixel)


def homography_projection(photo: Photo, facade: Facade, raster: OrthoRaster) -> PixelMap:
    """`plane_homography` as a map; it knows neither distortion nor relief, as in the paper."""
    H = plane_homography(photo, facade, raster)

    def to_photo(column: Array, row: Array, _: Array | float) -> Float:
        column, row = np.broadcast_arrays(column, row)
        flat = np.column_stack([column.ravel(), row.ravel()]).astype(np.float64)
        return apply_homography(H, flat).reshape(*column.shape, 2)

    return to_photo


def pixel_map(photo: Photo, facade: Facade, raster: OrthoRaster, projection: str) -> PixelMap:
    """The map that the option `projection` names."""
    return (full_projection if projection == "full" else homography_projection)(photo, facade, raster)


def shifted(to_photo: PixelMap, offset: float) -> PixelMap:
    """The map of a surface that lies `offset` m farther behind the plane."""
    if offset == 0.0:
        return to_photo
    return lambda column, row, y: to_photo(column, row, y + offset)


def map_tile(to_photo: PixelMap, tile: Tile, y: Array | None) -> SourceMap:
    """Where the pixel centres of a tile lie in the photo, on the plane (`y` None) or a relief y (m, n) m.

    NaN in y = the plane. The map is a polynomial when one of `_DEGREES` errs by at most `FLAT_ERROR` where
    it errs most; otherwise every pixel is projected.
    """
    depth = None if y is None else np.nan_to_num(np.asarray(y, np.float32), nan=0.0)
    low, high = (0.0, 0.0) if depth is None else _range(depth)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    columns, rows = 0.5 * (tile.c0 + tile.c1), 0.5 * (tile.r0 + tile.r1)
    half_width, half_height = 0.5 * (tile.c1 - tile.c0), 0.5 * (tile.r1 - tile.r0)

    def at(c: Array, r: Array, d: Array) -> Float:
        return to_photo(columns + half_width * c, rows + half_height * r, middle + half * d)

    for degree in _DEGREES:
        found = fitted(at, degree, _DEPTH_DEGREE if half > 0.0 else 0)
        if found.error <= FLAT_ERROR:
            jacobian = np.column_stack(
                [found.factors[0, 0, 1] / half_width, found.factors[0, 1, 0] / half_height]
            )
            powers = _powers(found.factors, middle, half)
            used = depth if len(powers) > 1 else None
            return SourceMap(powers, tile.shape, jacobian, found.low, found.high, depth=used)
    c, r = np.arange(tile.c0, tile.c1) + 0.5, np.arange(tile.r0, tile.r1) + 0.5
    every = to_photo(c[None, :], r[:, None], 0.0 if depth is None else depth)
    return SourceMap.of_pixels(every, jacobian_of(every))


def _range(depth: Array) -> tuple[float, float]:
    """Smallest and largest depth of a tile, one value when they are closer than a tenth of a millimetre."""
    low, high, _, _ = cv2.minMaxLoc(depth)
    middle = 0.5 * (low + high)
    return (middle, middle) if high - low < _FLAT else (low, high)


def _powers(factors: Float, middle: float, half: float) -> tuple[Float, ...]:
    """Coefficients (p, q, 2) of powers of y m from those (k, p, q, 2) of T_k of ``(y - middle) / half``."""
    if len(factors) == 1:
        return (factors[0],)
    g0, g1, g2 = factors[0] - factors[2], factors[1] / half, 2.0 * factors[2] / half**2
    if 2.0 * float(np.abs(factors[2]).sum()) <= _STRAIGHT:
        return g0 - middle * g1, g1
    return g0 - middle * g1 + middle**2 * g2, g1 - 2.0 * middle * g2, g2
