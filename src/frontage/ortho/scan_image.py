"""The pixels that come from the scan (its colour, intensity or shaded depth), and the intensity band."""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool
from frontage.model import Scan
from frontage.ortho.bands import TILE_PX, Bands, fill_missing, much_is_missing
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.points import FacadePoints
from frontage.ortho.splat import Samples, splat, surface_samples
from frontage.ortho.surface import DrawingSurface
from frontage.raster import gridding
from frontage.raster.tiles import allocate, tiles


def intensity_band(points: FacadePoints, raster: OrthoRaster) -> Array | None:
    """Returns the scan's intensity (h, w) float32 0..1 on the facade, NaN where there is none.

    None when the scan has no intensity or no point is used.
    """
    scan, used = points.scan, points.used
    if scan.intensity is None or not used.any():
        return None
    value = np.take(scan.intensity, np.flatnonzero(used))[:, None]
    samples = surface_samples(points.xyz_used, value, raster, points.gaps)
    band = allocate((raster.height, raster.width, 1), np.float32, np.nan)
    known = allocate((raster.height, raster.width), np.bool_)
    splat(samples, raster, band, known)
    return np.asarray(band[..., 0])


def paint_missing_from_scan(
    bands: Bands, points: FacadePoints, surface: DrawingSurface, photos: int
) -> tuple[str, ...]:
    """Paints what the photos left empty from the scan, and returns the name of the scan as a source.

    `photos` is their number. Without photos the scan paints everything. With photos it fills the gaps only if
    they are large and the scan has colour or intensity. Returns an empty tuple when nothing was painted.
    """
    raster = surface.raster
    if not points.used.any():
        return ()
    if photos == 0:
        return _paint_scan(bands, points, raster)
    if not much_is_missing(bands, surface) or _picture_kind(points.scan) == "depth":
        return ()
    own = Bands(raster)
    names = _paint_scan(own, points, raster)
    return names if fill_missing(bands, own, photos + 1, raster) else ()


def _picture_kind(scan: Scan) -> str:
    """What a picture from the scan can show: "colour", else "intensity", else "depth"."""
    if scan.rgb is not None and np.ptp(scan.rgb) > 0:
        return "colour"
    if scan.intensity is not None and np.ptp(scan.intensity) > 0:
        return "intensity"
    return "depth"


def _paint_scan(bands: Bands, points: FacadePoints, raster: OrthoRaster) -> tuple[str, ...]:
    """Fills pixels, source and gsd from the scan's colour, intensity or depth; returns the source's name."""
    scan, used = points.scan, points.used
    xyz, kind = points.xyz_used, _picture_kind(scan)
    if kind == "colour" and scan.rgb is not None:
        value = scan.rgb[used].astype(np.float32)
    elif kind == "intensity" and scan.intensity is not None:
        value = _stretched(scan.intensity[used])[:, None]
    else:
        value = xyz[:, 1:2].astype(np.float32)
    samples = surface_samples(xyz, value, raster, points.gaps)
    band = allocate((raster.height, raster.width, value.shape[1]), np.float32)
    known = allocate((raster.height, raster.width), np.bool_)
    splat(samples, raster, band, known)
    span = _depth_range(samples) if kind == "depth" else None
    for tile in tiles(raster.height, raster.width, TILE_PX):
        shown = band[tile.window]
        if span is not None:
            spacing = raster.gsd * float(np.median(samples.gaps.px))
            shown = _shaded(shown[..., 0], known[tile.window], spacing, raster.gsd, span)
        _paint_tile(bands, shown, known[tile.window], tile.window)
        rows, columns = np.arange(tile.r0, tile.r1), np.arange(tile.c0, tile.c1)
        gsd = samples.gaps.at(rows, columns) * raster.gsd
        bands.gsd[tile.window] = np.where(known[tile.window], gsd, np.nan)
    return (f"{scan.name} ({kind})",)


def _paint_tile(bands: Bands, value: Array, known: Bool, window: tuple[slice, slice]) -> None:
    """Writes values (m, n, 1 or 3) in 0..255 to the pixels of a window, and marks their source."""
    rgb = np.clip(np.rint(value), 0, 255).astype(np.uint8)
    bands.pixels[window][..., :3] = np.where(known[..., None], np.broadcast_to(rgb, (*known.shape, 3)), 0)
    bands.pixels[window][..., 3] = np.where(known, 255, 0)
    bands.source[window] = known


def _stretched(intensity: Array) -> Array:
    """Stretches intensity (n,) between its 1 % and 99 % quantiles to grey values 0..255, gamma 2.2."""
    low, high = np.quantile(intensity, [0.01, 0.99])
    share = np.clip((intensity - low) / max(high - low, 1e-9), 0.0, 1.0)
    grey: Array = (255.0 * share ** (1 / 2.2)).astype(np.float32)
    return grey


def _depth_range(samples: Samples) -> tuple[float, float]:
    """The 2 % and 98 % quantiles of the depth, m, at least 5 cm apart."""
    low, high = np.quantile(samples.value[:, 0], [0.02, 0.98])
    return float(low), float(max(high, low + 0.05))


def _shaded(y: Array, known: Bool, spacing: float, gsd: float, span: tuple[float, float]) -> Array:
    """Grey values (h, w, 1): the surface lit from the upper left, and darker the deeper it lies."""
    y = gridding.nearest_filled(np.where(known, y, np.nan).astype(np.float32))
    y = np.nan_to_num(y, nan=span[1])
    smooth = cv2.GaussianBlur(y, (0, 0), max(1.0, spacing / gsd))
    dz, dx = np.gradient(smooth, gsd)
    lit = (0.8 + 0.45 * (dz + dx)) / np.sqrt(1.0 + dx * dx + dz * dz)
    depth = 1.0 - 0.55 * np.clip((smooth - span[0]) / (span[1] - span[0]), 0.0, 1.0)
    shaded: Array = 255.0 * np.clip(lit * depth, 0.0, 1.0)[..., None]
    return shaded
