"""Where a facade pixel lies in a photo."""

from collections.abc import Callable

import cv2
import numpy as np

from frontage.geometry import camera as maths
from frontage.geometry.arrays import Array, Float
from frontage.geometry.homography import apply_homography, homography_from_pose
from frontage.model import Facade, Photo
from frontage.ortho.frame import Raster
from frontage.raster.tiles import Tile

FLAT_ERROR = 0.02  # photo px that interpolation between exactly projected nodes may cost
_STEPS = (32, 16, 8, 4)  # px between nodes; finer ones would cost more than projecting every pixel

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


def map_tile(to_photo: PixelMap, tile: Tile, y: Array | None) -> tuple[Array, Float]:
    """Photo pixels (m, n, 2) float32 of a tile's pixel centres, and the typical Jacobian (2, 2).

    On the plane (`y` None) the map is exact at nodes and bilinear between them, the nodes being so dense that
    the second differences promise an error below `FLAT_ERROR`. On a relief (m, n) m, NaN = the plane, every
    pixel is projected.
    """
    r, c = np.arange(tile.r0, tile.r1) + 0.5, np.arange(tile.c0, tile.c1) + 0.5
    for step in _STEPS:
        rows, columns = _nodes(tile.r0, tile.r1, step), _nodes(tile.c0, tile.c1, step)
        grid = to_photo(columns[None, :], rows[:, None], 0.0)
        if _bend(grid) / 8.0 <= FLAT_ERROR:
            break
    jacobian = _jacobian(grid, step)
    if y is None and _bend(grid) / 8.0 <= FLAT_ERROR:
        return _interpolated(grid, step, tile.shape), jacobian
    depth = 0.0 if y is None else np.where(np.isfinite(y), y, 0.0)
    return to_photo(c[None, :], r[:, None], depth).astype(np.float32), jacobian


def _nodes(first: int, last: int, step: int) -> Float:
    """Positions `step` px apart from half a step before `first` to at least half a step past `last`."""
    return first + step * (np.arange(-(-(last - first) // step) + 2, dtype=np.float64) - 0.5)


def _bend(grid: Float) -> float:
    """Sum of the largest second differences along both axes, px; inf when a part is not visible."""
    if not np.isfinite(grid).all():
        return np.inf
    return float(sum(np.abs(np.diff(grid, 2, axis=a)).max(initial=0.0) for a in (0, 1)))


def _jacobian(grid: Float, step: int) -> Float:
    """Median d(photo)/d(column), d(photo)/d(row) over the known nodes, columns of a (2, 2) matrix."""
    by_column = np.diff(grid, axis=1).reshape(-1, 2) / step
    by_row = np.diff(grid, axis=0).reshape(-1, 2) / step
    J = []
    for d in (by_column, by_row):
        known = d[np.isfinite(d).all(1)]
        J.append(np.median(known, axis=0) if len(known) else np.ones(2))
    return np.column_stack(J)


def _interpolated(grid: Float, step: int, shape: tuple[int, int]) -> Array:
    """Bilinear values (m, n, 2) float32 at the pixel centres of a tile whose `_nodes` are given."""
    h, w = grid.shape[:2]
    # cv2.resize puts node k at (k + 0.5) step - 0.5; ours begin half a step before the tile: cut a step
    fine = cv2.resize(grid.astype(np.float32), (w * step, h * step), interpolation=cv2.INTER_LINEAR)
    inner: Array = fine[step : step + shape[0], step : step + shape[1]]
    return inner
