"""Colour, grey or shaded depth from the scan, and the intensity band."""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float
from frontage.model import Scan
from frontage.ortho.bands import TILE, Bands
from frontage.ortho.gaps import Gaps
from frontage.ortho.orthoraster import OrthoRaster
from frontage.ortho.splat import Samples, splat, surface_samples
from frontage.raster import gridding
from frontage.raster.tiles import allocate, tiles


def intensity_band(
    scan: Scan, xyz_facade: Float, near: Bool, raster: OrthoRaster, gaps: Gaps
) -> Array | None:
    """Intensity (h, w) float32 0..1 of the scan on the facade, NaN = none; None when the scan has none."""
    if scan.intensity is None or not near.any():
        return None
    samples = surface_samples(xyz_facade[near], scan.intensity[near][:, None], raster, gaps)
    band = allocate((raster.height, raster.width, 1), np.float32, np.nan)
    known = allocate((raster.height, raster.width), np.bool_)
    splat(samples, raster, band, known)
    flat: Array = band[..., 0]
    for tile in tiles(raster.height, raster.width, TILE):
        flat[tile.window][~known[tile.window]] = np.nan
    return flat


def picture_kind(scan: Scan) -> str:
    """What a picture from the scan shows: "colour", else "intensity", else "depth"."""
    if scan.rgb is not None and np.ptp(scan.rgb) > 0:
        return "colour"
    if scan.intensity is not None and np.ptp(scan.intensity) > 0:
        return "intensity"
    return "depth"


def paint_scan(
    bands: Bands, scan: Scan, xyz_facade: Float, near: Bool, raster: OrthoRaster, gaps: Gaps
) -> tuple[str, ...]:
    """Fill pixels, source and gsd from the scan's colour, else intensity, else shape; name the source."""
    points, kind = xyz_facade[near], picture_kind(scan)
    if kind == "colour" and scan.rgb is not None:
        value = scan.rgb[near].astype(np.float32)
    elif kind == "intensity" and scan.intensity is not None:
        value = _stretched(scan.intensity[near])[:, None]
    else:
        value = points[:, 1:2].astype(np.float32)
    samples = surface_samples(points, value, raster, gaps)
    band = allocate((raster.height, raster.width, value.shape[1]), np.float32)
    known = allocate((raster.height, raster.width), np.bool_)
    splat(samples, raster, band, known)
    shading = _depth_range(samples) if kind == "depth" else None
    for tile in tiles(raster.height, raster.width, TILE):
        _paint_tile(bands, band[tile.window], known[tile.window], samples, raster, tile.window, shading)
    return (f"{scan.name} ({kind})",)


def _paint_tile(
    bands: Bands,
    value: Array,
    known: Bool,
    samples: Samples,
    raster: OrthoRaster,
    window: tuple[slice, slice],
    shading: tuple[float, float] | None,
) -> None:
    """Pixels of one tile from its values."""
    if shading is not None:
        value = _shaded(
            value[..., 0], known, raster.gsd * float(np.median(samples.gaps.px)), raster.gsd, shading
        )
    rgb = np.clip(np.rint(value), 0, 255).astype(np.uint8)
    bands.pixels[window][..., :3] = np.where(known[..., None], np.broadcast_to(rgb, (*known.shape, 3)), 0)
    bands.pixels[window][..., 3] = np.where(known, 255, 0)
    bands.source[window] = known
    rows, columns = np.arange(window[0].start, window[0].stop), np.arange(window[1].start, window[1].stop)
    gsd = samples.gaps.at(rows, columns) * raster.gsd
    bands.gsd[window] = np.where(known, gsd, np.nan)


def _stretched(intensity: Array) -> Array:
    """Intensity (n,) to grey values 0..255 between its 1 % and 99 % quantiles, gamma 2.2."""
    low, high = np.quantile(intensity, [0.01, 0.99])
    share = np.clip((intensity - low) / max(high - low, 1e-9), 0.0, 1.0)
    grey: Array = (255.0 * share ** (1 / 2.2)).astype(np.float32)
    return grey


def _depth_range(samples: Samples) -> tuple[float, float]:
    low, high = np.quantile(samples.value[:, 0], [0.02, 0.98])
    return float(low), float(max(high, low + 0.05))


def _shaded(y: Array, known: Bool, spacing: float, gsd: float, span: tuple[float, float]) -> Array:
    """Grey (h, w, 1): light from the upper left on the surface, darker the deeper it lies."""
    y = gridding.nearest_filled(np.where(known, y, np.nan).astype(np.float32))
    y = np.nan_to_num(y, nan=span[1])
    smooth = cv2.GaussianBlur(y, (0, 0), max(1.0, spacing / gsd))
    dz, dx = np.gradient(smooth, gsd)
    lit = (0.8 + 0.45 * (dz + dx)) / np.sqrt(1.0 + dx * dx + dz * dz)
    depth = 1.0 - 0.55 * np.clip((smooth - span[0]) / (span[1] - span[0]), 0.0, 1.0)
    shaded: Array = 255.0 * np.clip(lit * depth, 0.0, 1.0)[..., None]
    return shaded
