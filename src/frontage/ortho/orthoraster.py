"""The raster of an ortho-image: where its pixels lie on the plane of the facade."""

import math
from dataclasses import dataclass

import numpy as np

from frontage.errors import OptionError
from frontage.geometry.arrays import Array, Float
from frontage.model import Facade
from frontage.ortho.options import OrthoOptions
from frontage.raster.memory import NOT_METRES, require_memory, require_scratch
from frontage.raster.tiles import IN_MEMORY, Tile

_MAX_PIXELS = 40_000_000_000
_BAND_BYTES = (4, 4, 4, 4, 2)  # of a pixel: colour, depth, effective gsd, intensity, source
_LONGEST_FRONT_M = 1000.0  # a facade beyond is rather one in feet or millimetres


@dataclass(frozen=True)
class OrthoRaster:
    """A raster in the plane of a facade: columns run along +x, rows along -z (downwards).

    corner  (x, z) m, the outer upper left corner of the first pixel
    gsd     m per pixel
    """

    corner: tuple[float, float]
    gsd: float
    width: int
    height: int

    @property
    def facade_from_pixel(self) -> Float:
        """The matrix (3, 3) from ``(column, row, 1)`` to ``(x, z, 1)`` in m."""
        return np.array([[self.gsd, 0.0, self.corner[0]], [0.0, -self.gsd, self.corner[1]], [0.0, 0.0, 1.0]])

    def xyz(self, column: Array, row: Array, y: Array | float = 0.0) -> Float:
        """Converts pixel positions of shape (...), first centre at 0.5, and depths y to points (..., 3) m."""
        column, row = np.asarray(column, np.float64), np.asarray(row, np.float64)
        x, z = self.corner[0] + column * self.gsd, self.corner[1] - row * self.gsd
        points = np.empty((*np.broadcast_shapes(x.shape, np.shape(y), z.shape), 3))
        points[..., 0], points[..., 1], points[..., 2] = x, y, z
        return points

    def pixel(self, xyz_facade: Array) -> Array:
        """Projects points (n, 3) m of the facade frame orthogonally to pixels (n, 2) of their precision."""
        at = np.empty((2, len(xyz_facade)), xyz_facade.dtype)
        np.subtract(xyz_facade[:, 0], self.corner[0], out=at[0])
        np.subtract(self.corner[1], xyz_facade[:, 2], out=at[1])
        at /= self.gsd
        return at.T

    def coarser(self, step: int) -> "OrthoRaster":
        """Returns the raster of cells of step x step pixels that covers this one."""
        return OrthoRaster(self.corner, self.gsd * step, -(-self.width // step), -(-self.height // step))

    def part(self, tile: Tile) -> "OrthoRaster":
        """Returns the raster of the pixels of a tile."""
        left, top = self.corner
        return OrthoRaster((left + tile.c0 * self.gsd, top - tile.r0 * self.gsd), self.gsd, *tile.shape[::-1])

    def of_cells(self, size: float) -> "OrthoRaster":
        """Returns the raster of cells of `size` m from the same corner that covers this one amply."""
        return OrthoRaster(
            self.corner,
            size,
            math.ceil(self.width * self.gsd / size) + 1,
            math.ceil(self.height * self.gsd / size) + 1,
        )

    def window_of(self, other: "OrthoRaster", tile: Tile) -> tuple[tuple[int, int, int, int], Array, Array]:
        """Finds the window of this raster that is needed to interpolate at the pixels of a tile of `other`.

        Returns (r0, r1, c0, c1), with at least two cells per side if there are as many, and the columns u
        (n,) and rows v (m,) of the tile's pixels within it; whole numbers are centres of cells.
        """
        ratio = other.gsd / self.gsd
        u = (np.arange(tile.c0, tile.c1) + 0.5) * ratio + (other.corner[0] - self.corner[0]) / self.gsd - 0.5
        v = (np.arange(tile.r0, tile.r1) + 0.5) * ratio + (self.corner[1] - other.corner[1]) / self.gsd - 0.5
        c0, c1 = _window(u, self.width)
        r0, r1 = _window(v, self.height)
        return (r0, r1, c0, c1), u - c0, v - r0


def _window(at: Array, size: int) -> tuple[int, int]:
    """First and last (excluded) of `size` cells that interpolation at the sorted positions needs."""
    first = int(np.clip(np.floor(at[0]), 0, max(size - 2, 0)))
    return first, int(np.clip(np.floor(at[-1]) + 2, first + 1, size))


def facade_raster(facade: Facade, options: OrthoOptions) -> OrthoRaster:
    """Returns the raster that covers the outline of the facade and its margin.

    Its corner lies at a whole number of pixels from the origin of the facade frame. Raises OptionError (I320)
    when the gsd is so small that the image could not be stored, InputError (I322) when its bands need more
    memory or scratch space than there is.
    """
    x0, z0, x1, z1 = facade.extent
    gsd, margin = options.gsd, options.margin
    left, right = math.floor((x0 - margin) / gsd), math.ceil((x1 + margin) / gsd)
    bottom, top = math.floor((z0 - margin) / gsd), math.ceil((z1 + margin) / gsd)
    width, height = max(right - left, 1), max(top - bottom, 1)
    remedy = NOT_METRES if max(x1 - x0, z1 - z0) > _LONGEST_FRONT_M else "choose a larger gsd"
    what = f"facade {facade.id} is {x1 - x0:.1f} x {z1 - z0:.1f} m; a gsd of {gsd:g} m gives "
    what += f"{width} x {height} pixels"
    if width * height > _MAX_PIXELS:
        raise OptionError(f"{what}; {remedy}", code="I320")
    bands = [width * height * size for size in _BAND_BYTES]
    require_memory(sum(b for b in bands if b <= IN_MEMORY), f"{what}, which", remedy)
    require_scratch(sum(b for b in bands if b > IN_MEMORY), f"{what}, which", remedy)
    return OrthoRaster((left * gsd, top * gsd), gsd, width, height)
