"""Pixel <-> world of the ortho-image of one facade, from its sidecar and its depth raster alone."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import tifffile

from frontage.errors import FrontageError, InputError, WorkspaceError
from frontage.geometry.arrays import Array, Float
from frontage.io.rasters.geotiff import read_geotiff
from frontage.io.rasters.sidecar import read_sidecar
from frontage.raster.tiles import Tile

_TILE = 1024  # px of the relief that are read at a time


@dataclass(frozen=True)
class WorldPoint:
    """A world position (m, in the run's CRS), the depth y (m) it was taken at, and whether relief gave it.

    sigma  m, standard error along the wall's normal; None = not known
    """

    x: float
    y: float
    z: float
    depth: float
    surface: str  # "relief" or "plane"
    sigma: float | None


@dataclass(frozen=True)
class PixelPoint:
    """An ortho-image position (px, centre of the first at 0.5), the depth y (m), whether it is inside."""

    column: float
    row: float
    depth: float
    inside: bool


class FacadePixels:
    """The ortho-image of one facade as a measuring device: pixel to world and back.

    `raster_to_world` (4, 4) acts on (column, row, y, 1): y = 0 is the plane, y > 0 lies behind it. The relief
    is `depth.tif`; where it holds no measurement the plane is used, and the answer says so.
    """

    def __init__(self, folder: Path) -> None:
        """Open `folder` (OUT/facades/B07_F1). Raises FileError if it holds no ortho-image."""
        self.folder = folder
        self.sidecar = read_sidecar(folder)
        self.raster_to_world: Float = self.sidecar.raster_to_world
        self.size = self.sidecar.size
        self._depth: Array | None = None
        self._tiles: dict[tuple[int, int], Array] = {}

    @property
    def crs(self) -> str | None:
        """The CRS of the world coordinates."""
        return self.sidecar.crs

    @property
    def depth(self) -> Array:
        """The relief (h, w) float32 m, NaN where none was measured; read on first use."""
        if self._depth is None:
            try:
                self._depth = np.asarray(tifffile.imread(self.folder / "depth.tif"))
            except (OSError, ValueError) as error:
                raise WorkspaceError(
                    f"{self.folder / 'depth.tif'} cannot be read ({error}); run `frontage ortho` again"
                ) from None
        return self._depth

    def world_from_pixels(self, column_row: Float, relief: bool = True) -> tuple[Float, Float, Array]:
        """Pixels (n, 2) to world (n, 3) m, their depth y (n,) m and whether the relief was used (n,)."""
        cr = np.atleast_2d(np.asarray(column_row, np.float64))
        y, used = self._relief(cr) if relief else (np.zeros(len(cr)), np.zeros(len(cr), bool))
        M = self.raster_to_world
        return np.column_stack([cr, y]) @ M[:3, :3].T + M[:3, 3], y, used

    @cached_property
    def plane_variance(self) -> Float:
        """The variance (m2) of the plane along its normal as coefficients (6,) of 1, x, z, x2, xz, z2.

        x and z are facade coordinates (m); the covariance of the frame is propagated to that place.
        """
        C = self.sidecar.facade.local_from_facade.covariance
        # A small turn w moves the point (x, 0, z) by w_z x - w_x z along y.
        return np.array([C[1, 1], 2 * C[1, 5], -2 * C[1, 3], C[5, 5], -2 * C[3, 5], C[3, 3]])

    @property
    def scatter(self) -> float:
        """Standard deviation (m) of single points about the plane, which the relief is made from."""
        return float(self.sidecar.facade.roughness)

    def sigma_across(self, column_row: Float, relief: Array) -> Float:
        """Standard errors (n,) m along the normal at pixels (n, 2): of the plane, or of the relief (n,).

        The relief follows the points, so it has their scatter on top of the plane's error.
        """
        corner, gsd = self.sidecar.corner, self.sidecar.gsd
        x, z = corner[0] + gsd * column_row[:, 0], corner[1] - gsd * column_row[:, 1]
        terms = np.stack([np.ones_like(x), x, z, x * x, x * z, z * z])
        variance = np.maximum(self.plane_variance @ terms, 0.0) + np.where(relief, self.scatter**2, 0.0)
        return np.asarray(np.sqrt(variance), np.float64)

    def pixels_from_world(self, xyz_world: Float) -> tuple[Float, Float]:
        """World points (n, 3) m to pixels (n, 2) and their depth y (n,) m behind the plane."""
        M = self.raster_to_world
        # Subtract first: at UTM size the full product would lose digits.
        local = np.atleast_2d(np.asarray(xyz_world, np.float64)) - M[:3, 3]
        cry: Float = np.linalg.solve(M[:3, :3], local.T).T.astype(np.float64)
        return cry[:, :2], cry[:, 2]

    def pixel_to_world(self, column: float, row: float, relief: bool = True) -> WorldPoint:
        """One pixel (centre of the first at 0.5, 0.5) to the world. Raises InputError outside the image."""
        w, h = self.size
        if not (0 <= column <= w and 0 <= row <= h):
            raise InputError(f"pixel ({column:g}, {row:g}) lies outside the ortho-image of {w} x {h} px")
        xyz, y, used = self.world_from_pixels(np.array([[column, row]]), relief)
        X, Y, Z = (float(v) for v in xyz[0])
        sigma = float(self.sigma_across(np.array([[column, row]]), used)[0])
        known = sigma if np.isfinite(sigma) else None
        return WorldPoint(X, Y, Z, float(y[0]), "relief" if used[0] else "plane", known)

    def world_to_pixel(self, x: float, y: float, z: float) -> PixelPoint:
        """One world position (m, the run's CRS) to its pixel: the foot of its perpendicular on the plane."""
        if not np.isfinite([x, y, z]).all():
            raise InputError("X, Y and Z must be finite numbers")
        (cr,), (depth,) = self.pixels_from_world(np.array([[x, y, z]]))
        w, h = self.size
        inside = bool(0 <= cr[0] <= w and 0 <= cr[1] <= h)
        return PixelPoint(float(cr[0]), float(cr[1]), float(depth), inside)

    def _relief(self, cr: Float) -> tuple[Float, Array]:
        """Depth y (n,) m at pixels (n, 2), 0 where none was measured, and whether it was (n,)."""
        w, h = self.size
        c, r = np.floor(cr).astype(np.int64).T
        inside = (c >= 0) & (c < w) & (r >= 0) & (r < h)
        y = np.full(len(cr), np.nan)
        for key in np.unique(np.column_stack([r, c])[inside] // _TILE, axis=0):
            mine = inside & (r // _TILE == key[0]) & (c // _TILE == key[1])
            y[mine] = self._tile(int(key[0]), int(key[1]))[r[mine] % _TILE, c[mine] % _TILE]
        used = np.isfinite(y)
        return np.where(used, y, 0.0), used

    def _tile(self, i: int, j: int) -> Array:
        """A tile of the relief, read on first use: of a gigapixel only what is asked for."""
        if (i, j) not in self._tiles:
            w, h = self.size
            window = Tile(i * _TILE, min((i + 1) * _TILE, h), j * _TILE, min((j + 1) * _TILE, w))
            try:
                self._tiles[i, j] = read_geotiff(self.folder / "depth.tif", window)[0]
            except FrontageError as error:
                raise WorkspaceError(f"the relief cannot be read: {error}") from None
        return self._tiles[i, j]
