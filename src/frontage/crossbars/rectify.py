"""Rectifies the views of a window onto planes parallel to the wall.

Whatever lies behind the wall is seen through the opening. Every view is therefore resampled once, onto the
wall itself, where the outline bounds what it can show of the window. A plane at depth d behind the wall is
the same picture scaled about the foot of the camera on the wall: the ray through (x, 0, z) from a camera
at (cx, -e, cz) meets the plane at ``c + (1 + d / e) ((x, z) - c)``. This is exact, so that a sweep over
depths costs nothing but scaling.
"""

from dataclasses import dataclass, field
from functools import cached_property

import cv2
import numpy as np

from frontage.crossbars.window import Window, WindowView
from frontage.geometry.arrays import Array, Float
from frontage.raster.resample import resample
from frontage.raster.sourcemap import SourceMap, fitted, jacobian_of

FINEST_M = 0.0025  # pixel of a rectified view: bars are at least six times as wide
COARSEST_M = 0.02
_SCAN_PX_M = 0.005  # without photos
_OVERSAMPLED = 1.5  # rectified px per px of the finest photo, so that resampling loses nothing
_PAD_M = 0.03  # around the outline
_DEGREE = 4  # of the polynomial that stands for the projection over one window
_EXACT_PX = 0.05  # its error, beyond which every pixel is projected


@dataclass(frozen=True)
class Grid:
    """A raster on a plane parallel to the wall: row 0 is the lowest, column 0 the leftmost.

    x0, z0  m, the lower left corner; px  m, side of a pixel; shape (rows, columns)
    """

    x0: float
    z0: float
    px: float
    shape: tuple[int, int]

    def start(self, axis: int) -> float:
        """The coordinate of the first pixel's edge: x for axis 0, z for axis 1."""
        return self.x0 if axis == 0 else self.z0

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """x0, z0, x1, z1 in m."""
        rows, columns = self.shape
        return self.x0, self.z0, self.x0 + columns * self.px, self.z0 + rows * self.px

    def centres(self, axis: int) -> Float:
        """Coordinates of the pixel centres: x of the columns for axis 0, z of the rows for axis 1."""
        count = self.shape[1 - axis]
        return np.asarray(self.start(axis) + (np.arange(count) + 0.5) * self.px, np.float64)

    def pixels(self, xz: Float) -> Float:
        """Positions (n, 2) (column, row) of places (n, 2) m, first pixel centre at 0."""
        return np.asarray((xz - np.array([self.x0, self.z0])) / self.px - 0.5, np.float64)


@dataclass(frozen=True, eq=False)
class WallView:
    """A view resampled onto the wall, which is the reference of all deeper planes.

    name    of the photo
    image   (h, w, 3) float32, 0..255
    inside  (h, w) float32, 1 where the photo looks through the opening, 0 on the wall and beside the photo
    foot    (x, z) m of the camera on the wall; distance m of the camera from the wall
    gsd     m per px of the photo across (x) and along (z)
    tilt    (2,) how far a point moves on the wall, in x and z, per m that it lies deeper
    shift   (2,) m, by which the view is displaced to agree with the others
    """

    name: str
    image: Array = field(repr=False)
    inside: Array = field(repr=False)
    foot: Float
    distance: float
    gsd: tuple[float, float]
    tilt: Float
    shift: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def grey(self) -> Array:
        """The mean of the colours (h, w) float32."""
        return grey_of(self.image)

    def at(self, grid: Grid, depth: float, layer: Array) -> Array:
        """Returns a layer (h, w, ...) of this view on the plane at a depth m, in the same raster.

        A layer may be coarser than the raster, also along one axis only.
        """
        rows, columns = layer.shape[:2]
        scale = 1.0 + depth / self.distance
        matrix = np.zeros((2, 3))
        for axis, count in ((0, columns), (1, rows)):
            px = grid.px * grid.shape[1 - axis] / count
            foot = (float(self.foot[axis]) - grid.start(axis)) / px - 0.5
            matrix[axis, axis] = 1.0 / scale
            matrix[axis, 2] = foot - (foot + self.shift[axis] / px) / scale
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return np.asarray(cv2.warpAffine(layer, matrix, (columns, rows), flags=flags))


@dataclass(frozen=True, eq=False)
class PlaneView:
    """A view on the plane of the frame.

    image   (h, w, 3) float32, 0..255
    inside  (h, w) float32, 1 where the photo shows that plane within the outline of the opening
    gsd     m per px of the photo across (x) and along (z)
    """

    name: str
    image: Array = field(repr=False)
    inside: Array = field(repr=False)
    gsd: tuple[float, float]

    @cached_property
    def grey(self) -> Array:
        """The mean of the colours (h, w) float32."""
        return grey_of(self.image)

    @staticmethod
    def of(grid: Grid, view: WallView, depth: float, mask: Array) -> "PlaneView":
        """Returns a view at a depth m; `mask` is the outline's."""
        inside = view.at(grid, depth, view.inside) * mask
        return PlaneView(view.name, view.at(grid, depth, view.image), inside, view.gsd)


def grey_of(image: Array) -> Array:
    """Returns the mean of the colours of a picture (h, w, 3) float32, (h, w) float32."""
    return np.asarray(cv2.transform(image, np.full((1, 3), 1.0 / 3.0)))


def window_grid(window: Window) -> Grid:
    """Returns the raster of a window, as fine as its finest view justifies; of the scan without views."""
    finest = window.views[0].gsd / _OVERSAMPLED if window.views else _SCAN_PX_M
    px = float(np.clip(finest, FINEST_M, COARSEST_M))
    low, high = window.ring.min(0) - _PAD_M, window.ring.max(0) + _PAD_M
    columns, rows = np.ceil((high - low) / px).astype(int)
    return Grid(float(low[0]), float(low[1]), px, (int(rows), int(columns)))


def outline_mask(grid: Grid, ring: Float, soft: bool = True) -> Array:
    """Returns how much of every pixel a ring (k, 2) m covers, (h, w) float32 0..1."""
    factor = 4 if soft else 1
    rows, columns = grid.shape
    shift = 8
    at = (grid.pixels(ring) + 0.5) * factor - 0.5
    mask = np.zeros((rows * factor, columns * factor), np.uint8)
    cv2.fillPoly(mask, [np.rint(at * (1 << shift)).astype(np.int32)], 255, shift=shift)
    small = cv2.resize(mask, (columns, rows), interpolation=cv2.INTER_AREA) if soft else mask
    return np.asarray(small, np.float32) / 255.0


def on_wall(window: Window, view: WindowView, grid: Grid, mask: Array) -> WallView | None:
    """Resamples a view onto the wall; None where it shows nothing of the opening.

    mask  `outline_mask` of the opening
    """
    found = _map(window, view, grid)
    if found is None:
        return None
    rows, columns = view.pixels.shape[:2]
    u, v = found.planes((0.0, 0.0), 1.0)
    known = (u > -0.5) & (v > -0.5) & (u < columns - 0.5) & (v < rows - 0.5)
    inside = mask * known
    if float(inside.sum()) < 0.2 * float(mask.sum()):
        return None
    image = resample(view.pixels, found)[..., :3].astype(np.float32)
    eye = window.frame.inverse.apply(view.photo.pose.t[None])[0]
    distance = window.wall_y - float(eye[1])
    middle = window.ring.mean(0)
    foot = eye[[0, 2]]
    inverse = np.linalg.inv(found.jacobian) * grid.px
    gsd = (float(np.hypot(*inverse[0])), float(np.hypot(*inverse[1])))
    return WallView(view.photo.id, image, inside, foot, distance, gsd, (middle - foot) / distance)


def _map(window: Window, view: WindowView, grid: Grid) -> SourceMap | None:
    """Returns where the raster's pixels lie in a view's crop, by a polynomial or pixel by pixel."""
    rows, columns = grid.shape

    def at(column: Array, row: Array, _: Array) -> Float:
        x = grid.x0 + (column + 1.0) / 2 * columns * grid.px
        z = grid.z0 + (row + 1.0) / 2 * rows * grid.px
        return view.project(window.frame, np.column_stack([x, np.full(x.shape, window.wall_y), z]))

    middle = at(np.array([-1.0, 1, 0, 0]) / columns, np.array([0, 0, -1.0, 1]) / rows, np.zeros(4))
    jacobian = np.column_stack([middle[1] - middle[0], middle[3] - middle[2]])
    if not np.isfinite(jacobian).all() or abs(np.linalg.det(jacobian)) < 1e-6:
        return None
    found = fitted(at, _DEGREE, 0)
    if found.error < _EXACT_PX:
        return SourceMap((found.factors[0],), grid.shape, jacobian, found.low, found.high)
    c, r = np.meshgrid((np.arange(columns) + 0.5) * 2 / columns - 1, (np.arange(rows) + 0.5) * 2 / rows - 1)
    every = at(c.ravel(), r.ravel(), c.ravel()).reshape(*grid.shape, 2)
    return SourceMap.of_pixels(every, jacobian_of(every))
