"""Where a facade pixel lies in a photo."""

from collections.abc import Callable

import cv2
import numpy as np

from frontage.geometry import camera as maths
from frontage.geometry.arrays import Array, Float
from frontage.geometry.homography import apply_homography, homography_from_pose
from frontage.model import Facade, Photo
from frontage.ortho.frame import Raster
from frontage.raster.sourcemap import SourceMap, bend, mean_jacobian, nodes
from frontage.raster.tiles import Tile

FLAT_ERROR = 0.02  # photo px that interpolation between exactly projected nodes may cost
_STEPS = (16, 8, 4)  # px between nodes; finer ones would cost more than projecting every pixel
_FLAT = 1e-4  # m of relief within a tile that no photo resolves

PixelMap = Callable[[Array, Array, Array | float], Float]
"""(column, row, y in m) of the raster, any shape (...), to photo pixels (..., 2); NaN where it cannot see."""


def full_projection(photo: Photo, facade: Facade, raster: Raster) -> PixelMap:
    """The map with lens distortion and relief; exact for every camera model."""
    camera_from_facade = photo.pose.inverse @ facade.frame

    def to_photo(column: Array, row: Array, y: Array | float) -> Float:
        xyz = raster.xyz(column, row, y)
        flat = photo.camera.project(camera_from_facade.apply(xyz.reshape(-1, 3)))
        return flat.reshape(*xyz.shape[:-1], 2)

    return to_photo


def plane_homography(photo: Photo, facade: Facade, raster: Raster) -> Float:
    """Paper A's map (3, 3) from raster to photo pixels: the undistorted camera, the plane y = 0."""
    camera_from_facade = photo.pose.inverse @ facade.frame
    K = maths.calibration_matrix(photo.camera.model, photo.camera.params)
    return homography_from_pose(K, camera_from_facade.R, camera_from_facade.t, raster.facade_from_pixel)


def homography_projection(photo: Photo, facade: Facade, raster: Raster) -> PixelMap:
    """`plane_homography` as a map; it knows neither distortion nor relief, as in the paper."""
    H = plane_homography(photo, facade, raster)

    def to_photo(column: Array, row: Array, _: Array | float) -> Float:
        column, row = np.broadcast_arrays(column, row)
        flat = np.column_stack([column.ravel(), row.ravel()]).astype(np.float64)
        return apply_homography(H, flat).reshape(*column.shape, 2)

    return to_photo


def pixel_map(photo: Photo, facade: Facade, raster: Raster, projection: str) -> PixelMap:
    """The map that the option `projection` names."""
    return (full_projection if projection == "full" else homography_projection)(photo, facade, raster)


def map_tile(to_photo: PixelMap, tile: Tile, y: Array | None) -> SourceMap:
    """Where the pixel centres of a tile lie in the photo, on the plane (`y` None) or a relief y (m, n) m.

    NaN in y = the plane. The map is exact at nodes and interpolated between them and in depth when the second
    differences (and, in depth, exact values between the nodes) promise an error below `FLAT_ERROR`; otherwise
    every pixel is projected.
    """
    depth = None if y is None else np.nan_to_num(np.asarray(y, np.float32), nan=0.0)
    low, high = (0.0, 0.0) if depth is None else _range(depth)
    depths = (low,) if low == high else (low, high)
    step = _STEPS[0]
    for _ in range(2):  # the error falls with the square of the step: the second try is right
        columns, rows = nodes(tile.c0, tile.c1, step)[None, :], nodes(tile.r0, tile.r1, step)[:, None]
        grids = [to_photo(columns, rows, v) for v in depths]
        error = max(bend(g) for g in grids) / 8.0
        if error <= FLAT_ERROR or step == _STEPS[-1]:
            break
        step = next((s for s in _STEPS[1:] if error * (s / step) ** 2 <= 0.9 * FLAT_ERROR), _STEPS[-1])
    jacobian = mean_jacobian(grids[0], step)
    if error <= FLAT_ERROR:
        bounds = np.min([g.min((0, 1)) for g in grids], 0), np.max([g.max((0, 1)) for g in grids], 0)
        if low == high:
            return SourceMap((grids[0],), step, tile.shape, jacobian, *bounds)
        powers = _powers_of_depth(lambda v: to_photo(columns, rows, v), low, high)
        if powers is not None:
            return SourceMap(powers, step, tile.shape, jacobian, *bounds, depth=depth)
    c, r = np.arange(tile.c0, tile.c1) + 0.5, np.arange(tile.r0, tile.r1) + 0.5
    every = to_photo(c[None, :], r[:, None], 0.0 if depth is None else depth)
    return SourceMap.exact(every, jacobian)


def _range(depth: Array) -> tuple[float, float]:
    """Smallest and largest depth of a tile, one value when they are closer than a tenth of a millimetre."""
    low, high, _, _ = cv2.minMaxLoc(depth)
    middle = 0.5 * (low + high)
    return (middle, middle) if high - low < _FLAT else (low, high)


def _powers_of_depth(at: Callable[[float], Float], low: float, high: float) -> tuple[Float, ...] | None:
    """Grids (p, q, 2) of the powers of y that give the map between two depths, or None when two are too few.

    A pinhole's map is a rational function of y; over a facade's relief its third order is far below a pixel.
    """
    middle = 0.5 * (low + high)
    first, centre, last = at(low), at(middle), at(high)
    half = 0.5 * (high - low)
    slope, curve = (last - first) / (2 * half), (last - 2 * centre + first) / (2 * half * half)
    error = 0.0
    for share in (-0.5, 0.5):
        d = share * half
        error = max(error, float(np.abs(centre + d * (slope + d * curve) - at(middle + d)).max()))
    if not error <= FLAT_ERROR:
        return None
    if float(np.abs(curve).max()) * half * half <= FLAT_ERROR:
        return centre - middle * slope, slope
    return centre - middle * slope + middle**2 * curve, slope - 2 * middle * curve, curve
