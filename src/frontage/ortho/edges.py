"""Locates the edges where the surface steps back, such as reveals, from the points themselves.

The cells of the relief are too coarse for this. Points near a step belong either to its near or to its far
side. The near surface is opaque, so a recess seen obliquely has a strip without points beside its edge; there
the near surface is taken to end half a spacing after its last point. Where points of both sides are close,
the edge runs between them. Both rules follow from the distances to the two sets of points. The distances are
smoothed over most of a spacing, which straightens random roughness and does not move straight edges.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int, picked_rows
from frontage.ortho.gaps import Gaps
from frontage.ortho.orthoraster import OrthoRaster
from frontage.raster import gridding, interpolation
from frontage.raster.tiles import Tile, allocate, tiles

_TILE_PX = 1024
_PER_SPACING = 3  # cells per spacing
_CLOSING = 2.0  # spacings, as in `splat`
_BEYOND = 0.5  # spacings by which a surface extends past its last point
_SMOOTH = 0.7  # spacings
_TAIL = 3.0  # sigmas of the smoothing, beyond which both sides weigh the same
_EVERY = 16  # cells, of whose spacings the median is taken
_REACH = 6.0  # spacings around a tile on which its cells depend


@dataclass(frozen=True)
class Steps:
    """Distance (h, w) float32 to the edges of steps, in cells of `raster`; negative on the near side."""

    raster: OrthoRaster
    distance: Array

    def recessed(self, raster: OrthoRaster, tile: Tile) -> Bool:
        """Returns which pixels (m, n) of a tile of another raster lie on the far side of their step."""
        (r0, r1, c0, c1), u, v = self.raster.window_of(raster, tile)
        far: Bool = interpolation.bilinear(self.distance[r0:r1, c0:c1], u, v) > 0.0
        return far


def measure_steps(
    points: tuple[Int, Float],
    cells: OrthoRaster,
    near: Array,
    far: Array,
    *,
    step: float,
    raster: OrthoRaster,
    gaps: Gaps,
) -> Steps:
    """Locates the edges of the steps from points: their flat cell numbers (n,) and places (n, 3) m.

    `near` and `far` (h, w) m are the nearest and farthest depth around each of the `cells`; there is a step
    where they differ by more than `step` m. `raster` and `gaps` are those of the picture.
    """
    k = max(1, int(np.median(gaps.px) / _PER_SPACING))
    fine = raster.coarser(k)
    distance = allocate((fine.height, fine.width), np.float32)
    stepped = far - near > step
    box = np.ones((5, 5), np.uint8)  # so that points beyond the cells in question count too
    near, far = cv2.erode(near, box), cv2.dilate(far, box)
    at, recessed, band = _sorted_points(points, near, far, step=step, fine=fine)
    reach = int(np.ceil(_REACH * max(1.0, float(gaps.px.max()) / k))) + 2
    for tile in tiles(fine.height, fine.width, _TILE_PX):
        (r0, r1, c0, c1), _, _ = cells.window_of(fine, tile)
        if not stepped[r0:r1, c0:c1].any():
            continue
        r, c = tile.r0 - reach, tile.c0 - reach
        shape = (tile.shape[0] + 2 * reach, tile.shape[1] + 2 * reach)
        part = gridding.of_rows(band, r, r + shape[0])
        cell, inside = gridding.cell_index(at[part] - np.array([c, r], at.dtype), shape)
        spacing = gaps.at(np.arange(r, r + shape[0]) * k, np.arange(c, c + shape[1]) * k) / np.float32(k)
        sides = []
        for side in (~recessed[part][inside], recessed[part][inside]):
            hit = np.zeros(shape[0] * shape[1], bool)
            hit[cell[side]] = True
            sides.append(hit.reshape(shape))
        signed = _signed_distance(sides[0], sides[1], spacing)
        distance[tile.window] = signed[reach:-reach, reach:-reach]
    return Steps(fine, distance)


def _sorted_points(
    points: tuple[Int, Float], near: Array, far: Array, *, step: float, fine: OrthoRaster
) -> tuple[Float, Bool, Array]:
    """Returns positions (n, 2) in `fine` of the points at steps, and which lie on the far side.

    They are ordered by bands of rows (`gridding.by_rows`), whose numbers (n,) follow.
    """
    cell, xyz = points
    low, high, y = np.take(near, cell), np.take(far, cell), xyz[:, 1]
    use = (high - low > step) & (y <= high + step)
    at, recessed = fine.pixel(picked_rows(use, xyz)), (y > 0.5 * (low + high))[use]
    order, band = gridding.by_rows(at[:, 1])
    return np.take(at.T, order, axis=1).T, recessed[order], band


def _signed_distance(near: Bool, far: Bool, spacing: Array) -> Array:
    """Distance (h, w) float32, in cells, to the edge between two sampled sides; negative on the near side.

    It is told as far as it is smoothed over.
    """
    sigma = max(0.5, _SMOOTH * float(np.median(spacing[::_EVERY, ::_EVERY])))
    most = _TAIL * sigma
    filled = _CLOSING * float(spacing.max()) + 1.0  # beyond, there is neither of the sides
    nearer = gridding.distance_within(near, filled) <= gridding.distance_within(far, filled)
    near_side = gridding.closed(near, _CLOSING * spacing) & nearer
    far_side = gridding.closed(far, _CLOSING * spacing) & ~nearer
    outside, inside = (gridding.distance_within(side, most) for side in (near_side, ~near_side))
    signed = cv2.subtract(outside, inside, dtype=cv2.CV_32F)
    ends = np.minimum(gridding.distance_within(far_side, _BEYOND * float(spacing.max())), _BEYOND * spacing)
    smooth: Array = cv2.GaussianBlur(signed - ends, (0, 0), sigma)
    return smooth
