"""Tells what hides the cells of a facade from a photo: the facade's own parts, or what stands free before it.

Seen from a photo, every point of the cloud casts a shadow on the plane of the facade. The shadows are drawn
into buffers on that plane, every point as a disc of its spacing, enlarged by the same central projection. A
buffer holds the smallest distance from the photo, along the normal of the facade. No lens takes part in this,
and the buffers are no larger than the facade.

The facade's own parts (reveals, sills, balconies) stay where they are. Cars and people move between scan and
photo, and the wall shows between the leaves of a tree, so what stands free makes it likely, and not certain,
that the facade is hidden; there the photos are asked as well (`mosaic/seethrough.py`).
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float
from frontage.ortho.occluders import OccluderCloud, Spaced
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.recess import DEEPEST_REVEAL_M
from frontage.raster.zbuffer import splat_depth

_FINER = 2  # pixels of a buffer per cell, along rows and columns
_TOLERANCE_M = 0.15  # points less far in front of a surface belong to that surface
_OCCLUDER_M = (
    DEEPEST_REVEAL_M + _TOLERANCE_M
)  # a part of the facade so far in front is no wall, frame or sill
_SELF_HIDDEN = 1e-4  # factor on the quality of cells hidden by the facade itself: a last resort
_BLUNT_M = 0.05  # larger discs cannot resolve a sill and hide only what lies far behind
_SPLAT = 0.75  # radius of the discs in spacings: a square lattice seen from the front shows no gap
_NOTHING = 65535  # in buffers of uint16
_NEAREST_M = 0.05  # points nearer to the photo along the normal are taken as lying beside it


@dataclass(frozen=True, eq=False)
class Visibility:
    """How a photo sees cells (h, w).

    factor  float32, 1 with nothing in front, `_SELF_HIDDEN` behind small parts of the facade, else 0
    behind  bool, behind what stands free before the facade
    solid   bool, behind such a thing without gaps
    """

    factor: Array
    behind: Bool
    solid: Bool


def visibility(
    centre: Float, cells: OrthoRaster, y: Array, distance: Array, cloud: OccluderCloud, spacing: float
) -> Visibility:
    """Tells how a photo sees the cells of a raster, whose surface lies y (h, w) m deep.

    `centre` (3,) m is the projection centre in the facade frame, `distance` (h, w) m that of the cells from
    it, and `spacing` m that of the points on the wall.
    """
    fine = OrthoRaster(cells.corner, cells.gsd / _FINER, cells.width * _FINER, cells.height * _FINER)
    column, row = np.arange(cells.width) + 0.5, np.arange(cells.height) + 0.5
    x, z = cells.corner[0] + column * cells.gsd, cells.corner[1] - row * cells.gsd
    own = (y - np.float32(centre[1])).astype(np.float32)
    stretch = np.float32(-centre[1]) / own  # the rays to the cells meet the plane at these places
    u = ((x - centre[0]) / fine.gsd).astype(np.float32) * stretch
    u += np.float32((centre[0] - fine.corner[0]) / fine.gsd - 0.5)
    v = ((centre[2] - z) / fine.gsd).astype(np.float32)[:, None] * stretch
    v += np.float32((fine.corner[1] - centre[2]) / fine.gsd - 0.5)
    slope = distance / own  # metres along the ray per metre along the normal
    box = np.ones((3, 3), np.uint8)
    u, v = cv2.convertMaps(u, v, cv2.CV_16SC2, nninterpolation=True)
    part, light, blocks = (
        _nearest(centre, of, fine, (u, v)) for of in (cloud.part, cloud.light, cloud.solid)
    )
    stands = np.minimum(light, blocks)
    # What hides the cells beside one hides that cell only if it lies before it, too.
    around = cv2.erode(part, box, borderType=cv2.BORDER_REPLICATE)
    part, around, stands, blocks = (_behind(near, own, slope) for near in (part, around, stands, blocks))
    # A cell between two hidden ones is hidden, and the outline of a tree or car is known to a cell at best.
    behind, solid = (cv2.dilate((off < -_TOLERANCE_M).astype(np.uint8), box) > 0 for off in (stands, blocks))
    large, small = (
        (cv2.morphologyEx((part < -limit).astype(np.uint8), cv2.MORPH_CLOSE, box) > 0) & (around < -limit)
        for limit in (_OCCLUDER_M, _TOLERANCE_M)
    )
    if _SPLAT * spacing > _BLUNT_M:
        small[:] = False
    factor = np.where(large, 0.0, np.where(small, _SELF_HIDDEN, 1.0)).astype(np.float32)
    return Visibility(factor, behind, solid)


def _behind(nearest: Array, own: Array, slope: Array) -> Array:
    """How far (h, w) m along their rays what casts shadows lies behind cells, negative before them.

    `nearest` (h, w) m are the distances of what casts a shadow on the cells along the normal, and are changed
    in place; `own` (h, w) m are those of the cells, `slope` (h, w) metres along the ray per metre of that.
    """
    nearest -= own
    nearest *= slope
    return nearest


def _nearest(centre: Float, points: Spaced, raster: OrthoRaster, at: tuple[Array, Array]) -> Array:
    """The smallest distance (h, w) m along the normal of points whose shadows fall on places of a raster.

    The places are those of a map of OpenCV. Where no shadow falls, the distance is infinite.
    """
    if not len(points[0]):
        return np.full(at[0].shape[:2], np.inf, np.float32)
    shadows, unit = _shadows(centre, *points, raster)
    level = cv2.remap(shadows, *at, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)
    return np.where(level == _NOTHING, np.float32(np.inf), level * unit)


def _shadows(centre: Float, xyz: Array, spacing: Array, raster: OrthoRaster) -> tuple[Array, np.float32]:
    """The smallest distance (h, w) uint16 along the normal of points (n, 3) m whose shadows cover a pixel.

    The points are in the facade frame. Also returns the unit of the distance in m, less than a millimetre
    within 65 m of a photo; where no shadow falls, the distance is 65535.
    """
    c = centre.astype(np.float32)
    away = xyz[:, 1] - c[1]
    unit = np.float32(max(float(away.max()), _NEAREST_M) / (_NOTHING - 1))
    level = (np.where(away > _NEAREST_M, away, np.float32(0.0)) / unit).astype(np.uint16)  # 0 is not drawn
    stretch = -c[1] / np.maximum(away, np.float32(_NEAREST_M))
    at = np.empty((2, len(xyz)), np.float32)
    u = np.subtract(xyz[:, 0], c[0], out=at[0])
    u *= stretch
    u += c[0] - np.float32(raster.corner[0])
    v = np.subtract(c[2], xyz[:, 2], out=at[1])
    v *= stretch
    v += np.float32(raster.corner[1]) - c[2]
    at /= np.float32(raster.gsd)
    stretch *= spacing
    stretch *= np.float32(_SPLAT / raster.gsd)
    return splat_depth(at.T, level, stretch, (raster.height, raster.width)), unit
