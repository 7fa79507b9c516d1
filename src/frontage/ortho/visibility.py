"""Tells what hides the cells of a facade from a photo: the facade's own parts, or what stands free before it.

The cloud is splatted into depth buffers of the photo, every point as a disc of its spacing. The facade's own
parts (reveals, sills, balconies) stay where they are. Cars and people move between scan and photo, and the
wall shows between the leaves of a tree, so what stands free makes it likely, and not certain, that the facade
is hidden; there the photos are asked as well (`mosaic/seethrough.py`).
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float
from frontage.model import Photo
from frontage.ortho.occluders import OccluderCloud
from frontage.ortho.recess import DEEPEST_REVEAL_M
from frontage.ortho.surface import DrawingSurface
from frontage.raster.zbuffer import splat_depth

_REDUCED = 2  # photo px per px of the depth buffer
_TOLERANCE_M = 0.15  # points less far in front of a surface belong to that surface
_OCCLUDER_M = DEEPEST_REVEAL_M + _TOLERANCE_M  # in front of the surface: not its own wall, frame or sill
_SELF_HIDDEN = 1e-4  # factor on the quality of cells hidden by the facade itself: a last resort
_BLUNT_M = 0.05  # larger discs cannot resolve a sill and hide only what lies far behind
_LEAN = 2.0  # allows for discs of up to twice the typical spacing of the wall
_BESIDE = 0.05  # of the width of a facade: discs of points beside it reach into it
_SPLAT = 0.75  # radius of the discs in spacings: a square lattice seen from the front shows no gap


@dataclass(frozen=True, eq=False)
class Visibility:
    """How a photo sees cells (h, w).

    factor  float, 1 with nothing in front, `_SELF_HIDDEN` behind small parts of the facade, else 0
    behind  bool, behind what stands free before the facade
    """

    factor: Array
    behind: Bool


def visibility(
    photo: Photo, at: Float, surface: DrawingSurface, y: Array, cloud: OccluderCloud
) -> Visibility:
    """Tells how a photo sees the cells of a surface that lie at `at` (h, w, 2) px in it, y (h, w) m deep."""
    facade, cells = surface.facade, surface.raster
    column, row = np.arange(cells.width) + 0.5, np.arange(cells.height) + 0.5
    at_cells = facade.frame.apply(cells.xyz(column[None, :], row[:, None], y).reshape(-1, 3))
    ray = at_cells - photo.pose.t
    own = np.linalg.norm(ray, axis=1).reshape(y.shape)
    cosine = np.maximum((ray @ facade.frame.R[:, 1]).reshape(y.shape) / own, 1e-3)
    # Discs face the photo. Where a surface is seen obliquely, its own discs reach out in front of it.
    slack = _LEAN * _SPLAT * facade.spacing * np.sqrt(np.maximum(1.0 / cosine**2 - 1.0, 0.0))
    box = np.ones((3, 3), np.uint8)
    xyz = photo.pose.inverse.apply(cloud.xyz)
    ahead = _towards(xyz, photo.pose.inverse.apply(at_cells))
    part, stands = (
        _nearest(photo, at, xyz[kind], cloud.spacing[kind]) - own + slack
        for kind in (ahead & ~cloud.free, ahead & cloud.free)
    )
    # A cell between two hidden ones is hidden, and the outline of a tree or car is known to a cell at best.
    behind = cv2.dilate((stands < -_OCCLUDER_M).astype(np.uint8), box) > 0
    large, small = (
        cv2.morphologyEx((part < -limit).astype(np.uint8), cv2.MORPH_CLOSE, box) > 0
        for limit in (_OCCLUDER_M, _TOLERANCE_M)
    )
    if _SPLAT * facade.spacing > _BLUNT_M:
        small[:] = False
    return Visibility(np.where(large, 0.0, np.where(small, _SELF_HIDDEN, 1.0)), behind)


def _towards(xyz: Float, cells: Float) -> Bool:
    """Which points (n, 3) lie in the directions of the cells (m, 3), both in m in the frame of the camera.

    Only these need to be projected, which is most of the work.
    """
    if (cells[:, 2] <= 0.0).any():
        return np.ones(len(xyz), bool)
    slopes = cells[:, :2] / cells[:, 2:]
    low, high = slopes.min(0), slopes.max(0)
    border = _BESIDE * (high - low)
    depth = np.maximum(xyz[:, 2:], 1e-6)
    above = (xyz[:, :2] >= (low - border) * depth).all(1)
    below = (xyz[:, :2] <= (high + border) * depth).all(1)
    return np.asarray((xyz[:, 2] > 0.0) & above & below)


def _nearest(photo: Photo, at: Float, xyz: Float, spacing: Float) -> Array:
    """Distance (h, w) m of the nearest of some points (n, 3) m on the rays at `at` (h, w, 2) px.

    The points are in the frame of the camera.
    """
    reduced = _REDUCED
    distance = np.linalg.norm(xyz, axis=1)
    shape = (-(-photo.camera.height // reduced), -(-photo.camera.width // reduced))
    radius = _pixels_per_radian(photo) / reduced * _SPLAT * spacing / np.maximum(distance, 1e-6)
    buffer = splat_depth(photo.camera.project(xyz) / reduced, distance, radius, shape)
    u, v = np.nan_to_num(np.moveaxis(at, -1, 0), nan=0.0) / reduced
    c, r = (np.clip(i.astype(np.int64), 0, n - 1) for i, n in ((u, shape[1]), (v, shape[0])))
    return np.asarray(buffer[r, c])


def _pixels_per_radian(photo: Photo) -> float:
    """Photo pixels per radian at the principal axis, from the camera model itself."""
    ahead = photo.camera.project(np.array([[0.0, 0.0, 1.0], [1e-4, 0.0, 1.0]]))
    return float(np.linalg.norm(ahead[1] - ahead[0]) / 1e-4)
