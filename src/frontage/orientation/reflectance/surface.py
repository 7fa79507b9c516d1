"""The surface of a scan, ready to be drawn: points without loners, their spacing, normals and tones."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Array, Float, Int, freeze
from frontage.model import Scan
from frontage.orientation.reflectance.radiometry import corrected, fit_radiometry, log_tone
from frontage.raster.zbuffer import local_spacing
from frontage.solve.surfels import Surfels, make_surfels

_FEWEST_TOGETHER = 3  # points in one cube below which they are noise
PIECE = 8.0
"""The size of the flat pieces that tell the normals, in spacings."""

_LUMA = np.array([0.299, 0.587, 0.114])
_STATIONS = 64  # more origins are a trajectory, whose single points have no offset of their own
_SIGMA_RANGE = 0.003  # m, of a range, where the scan does not state it


@dataclass(frozen=True, eq=False)
class ScannedSurface:
    """What a scan shows, point by point.

    xyz      (n, 3) float64 m, local
    spacing  (n,) float64 m, distance to neighbouring points on the surface
    tone     (n,) float32 log reflectance or log colour; None when the scan has neither
    kind     "intensity", "colour" or "geometry": what the tone was made from
    pieces   flat pieces of the surface, with normals
    sigma    m, standard error of a point across its surface
    """

    xyz: Float
    spacing: Float
    tone: Array | None
    kind: str
    pieces: Surfels
    sigma: float

    def __post_init__(self) -> None:
        n = len(self.xyz)
        freeze(self, xyz=((n, 3), np.float64), spacing=((n,), np.float64), tone=((n,), np.float32))

    def __len__(self) -> int:
        return len(self.xyz)

    def near(self, reach: float, xyz: Float) -> Int:
        """Returns the nearest flat piece (m,) of points (m, 3) m; -1 beyond `reach` m."""
        return _nearest_piece(self.pieces, xyz, reach)


def scanned_surface(scan: Scan, source: str = "auto", seed: int = 0) -> ScannedSurface:
    """Prepares a scan for drawing.

    `source` is "intensity", "colour", "geometry", or "auto": the first of these that the scan has. Raises
    ValueError for a source that the scan does not have.
    """
    kind = _kind(scan, source)
    spacing, together = local_spacing(scan.xyz)
    keep = np.flatnonzero(together >= _FEWEST_TOGETHER)
    kept = scan.take(keep)
    typical = float(np.median(spacing[keep])) if len(keep) else 0.05
    centre = np.median(kept.xyz, axis=0) if len(keep) else np.zeros(3)
    pieces = make_surfels(kept, PIECE * typical, centre, np.inf)
    tone = _tones(kept, kind, pieces, PIECE * typical, seed)
    sigma = kept.sigma_range or _SIGMA_RANGE
    return ScannedSurface(
        kept.xyz, spacing[keep], None if tone is None else tone.astype(np.float32), kind, pieces, sigma
    )


def point_tones(scan: Scan, source: str = "auto", seed: int = 0) -> Float:
    """Returns the log tones (n,) of all points of a scan, corrected for range and incidence.

    Unlike `scanned_surface` it keeps lone points. `source` is "intensity", "colour", or "auto": the first of
    these that the scan has. Raises ValueError when the scan lacks it, or has neither.
    """
    kind = _kind(scan, source)
    if kind == "geometry":
        raise ValueError(f"{scan.name} has neither intensity nor colour")
    spacing, together = local_spacing(scan.xyz)
    keep = np.flatnonzero(together >= _FEWEST_TOGETHER)
    if not len(keep):
        keep = np.arange(len(scan))
    cell = PIECE * float(np.median(spacing[keep]))
    kept = scan.take(keep)
    pieces = make_surfels(kept, cell, np.median(kept.xyz, axis=0), np.inf)
    tone = _tones(scan, kind, pieces, cell, seed)
    assert tone is not None
    return tone


def sources_of(scan: Scan) -> tuple[str, ...]:
    """What a scan can be drawn from: "intensity" and "colour" where it has them, and always "geometry"."""
    intensity = scan.intensity is not None and np.ptp(scan.intensity) > 0
    colour = scan.rgb is not None and np.ptp(scan.rgb) > 0
    there = {"intensity": intensity, "colour": colour, "geometry": True}
    return tuple(kind for kind, is_there in there.items() if is_there)


def _kind(scan: Scan, source: str) -> str:
    found = sources_of(scan)
    if source == "auto":
        return found[0]
    if source not in found:
        raise ValueError(f"{scan.name} has no {source}")
    return source


def _tones(scan: Scan, kind: str, pieces: Surfels, reach: float, seed: int) -> Float | None:
    """The logarithm of reflectance or colour (n,); None for geometry."""
    if kind == "geometry":
        return None
    if kind == "colour":
        rgb: Any = scan.rgb
        return np.asarray(np.log((rgb @ _LUMA + 8.0) / 263.0))  # dark noise does not dominate the logarithm
    intensity: Any = scan.intensity
    tone = log_tone(intensity)
    if not scan.has_origins or not len(pieces):
        return tone
    piece = _nearest_piece(pieces, scan.xyz, reach)
    ray = scan.xyz - scan.sensor_of(np.arange(len(scan)))
    ranges = np.linalg.norm(ray, axis=1)
    normal = np.where((piece >= 0)[:, None], pieces.normal[piece], np.nan)
    cosine = np.abs(np.einsum("ij,ij->i", ray, normal)) / np.maximum(ranges, 0.1)
    stations = len(scan.origins) if len(scan.origins) <= _STATIONS else 1
    station = np.where(scan.origin_index < stations, scan.origin_index, 0).astype(np.int64)
    model = fit_radiometry(tone, ranges, cosine, station, piece, stations, seed)
    return corrected(tone, model, ranges, cosine, station)


def _nearest_piece(pieces: Surfels, xyz: Float, reach: float) -> Int:
    if not len(pieces):
        return np.full(len(xyz), -1)
    distance, index = cKDTree(pieces.xyz).query(xyz, distance_upper_bound=reach, workers=-1)
    return np.where(np.isfinite(distance), index, -1).astype(np.int64)
