"""From the raw columns of a file to a `Scan`: bad points are dropped, intensity and colour are scaled."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.io.placement import Placement
from frontage.model import Estimate, Grid, Scan

_SAMPLE = 500_000  # values, evenly spread, that a quantile is taken from
_MANY_POINTS = 1000  # over so many points, real colour varies in every channel
FARTHEST_M = 1.3e7  # from the local origin, about the diameter of the Earth: what is farther is damaged
_LOW, _HIGH = 0.001, 0.999  # quantiles, so that a mirror-like reflection does not darken a whole facade


@dataclass
class PointColumns:
    """What a file states about its points, row by row.

    xyz           (n, 3) float64, *local* metres
    intensity, rgb, time, return_number, return_count
                  (n,) or (n, 3), as stored
    origins       (s, 3) m local: sensor positions; `origin_index` (n,) points into them, -1 = unknown
    grid          (h, w) int64: the row of every beam of a structured scan, -1 = no return
    keep          (n,) bool: the rows to keep; None = all
    pose          of the scanner, local from scanner
    notes         sentences for the user
    """

    name: str
    xyz: Float
    intensity: Array | None = None
    rgb: Array | None = None
    time: Array | None = None
    return_number: Array | None = None
    return_count: Array | None = None
    origins: Float | None = None
    origin_index: Array | None = None
    grid: Array | None = None
    keep: Array | None = None
    pose: Estimate[Rigid3] | None = None
    notes: list[str] = field(default_factory=list)


def to_scan(path: object, columns: PointColumns, placement: Placement) -> Scan:
    """Make the scan: drop rows without finite coordinates, scale intensity and colour.

    Raises FileError when no point is left.
    """
    c = _kept(columns)
    if not len(c.xyz):
        raise FileError(path, "holds no points", "export or copy it again", code="I105")
    many = c.return_count is not None and c.return_count.max(initial=0) > 1
    time = c.time if c.time is not None and np.ptp(c.time) > 0 and np.isfinite(c.time).all() else None
    return Scan(
        c.name,
        c.xyz,
        placement.world,
        np.empty((0, 3)) if c.origins is None else c.origins,
        np.full(len(c.xyz), -1, np.int32) if c.origin_index is None else c.origin_index,
        intensity=normalised([c.intensity])[0],
        rgb=rgb8(c.rgb, c),
        time=time,
        return_number=c.return_number if many else None,
        return_count=c.return_count if many else None,
        grid=None if c.grid is None else Grid(c.grid),
        local_from_scanner=c.pose,
        notes=tuple(dict.fromkeys([*placement.notes, *c.notes])),
    )


def _kept(c: PointColumns) -> PointColumns:
    """Drop the rows that are not to be kept or not finite, and renumber the grid."""
    with np.errstate(invalid="ignore"):
        finite: Array = np.all(np.abs(c.xyz) <= FARTHEST_M, axis=1)  # False for NaN
    keep = finite if c.keep is None else finite & c.keep
    if not finite.all():
        far = int((np.isfinite(c.xyz).all(axis=1) & ~finite).sum())
        lost = len(finite) - int(finite.sum()) - far
        for count, what in (
            (lost, "without finite coordinates"),
            (far, "farther away than the Earth is wide"),
        ):
            if count:
                c.notes.append(f"{c.name}: {count} points {what} were dropped")
    if keep.all():
        return c
    rows = {
        n: getattr(c, n)[keep]
        for n in ("xyz", "intensity", "rgb", "time", "return_number", "return_count", "origin_index")
        if getattr(c, n) is not None
    }
    grid = c.grid
    if grid is not None:
        new = np.append(np.where(keep, np.cumsum(keep) - 1, -1), -1)
        grid = new[grid]
    return replace(c, keep=None, grid=grid, **rows)


def rgb8(rgb: Array | None, c: PointColumns) -> Array | None:
    """Convert colour (n, 3) of any integer or float type to uint8.

    Returns None, with a note, when the fields cannot hold colour: one value throughout, or a channel that
    never changes over a whole scan (some programs store other data there). Of 16-bit values the upper byte is
    taken, unless none exceeds 255: many programs store 8-bit colour in the 16-bit fields of LAS. Floats are
    taken as 0..1 when none exceeds 1, else as 0..255.
    """
    if rgb is None or len(rgb) == 0:
        return None
    constant = (rgb == rgb[0]).all(axis=0)
    if constant.all() or (constant.any() and len(rgb) > _MANY_POINTS):
        if rgb.any():
            c.notes.append(
                f"{c.name}: its colour fields hold no colour (a channel never changes) and were dropped"
            )
        return None
    top = rgb.max()
    if rgb.dtype.kind == "f":
        return np.clip(np.nan_to_num(rgb) * (255.0 if top <= 1.0 else 1.0), 0, 255).round().astype(np.uint8)
    return rgb.astype(np.uint8) if top <= 255 else (rgb >> 8).astype(np.uint8)


def normalised(columns: Sequence[Array | None]) -> list[Array | None]:
    """Scale the intensities of the scans of one file to float32 0..1, with one scale for all of them.

    Values that already lie in 0..1 are kept. Others are scaled linearly, so that ratios of reflectance
    survive, from min(0, 0.1 % quantile) to the 99.9 % quantile, and clipped. A constant intensity gives None.
    """
    given = [c for c in columns if c is not None and len(c)]
    if not given:
        return [None for _ in columns]
    low, high = min(float(np.nanmin(c)) for c in given), max(float(np.nanmax(c)) for c in given)
    if not np.isfinite([low, high]).all() or high <= low:
        return [None for _ in columns]
    if not (low >= 0.0 and high <= 1.0 and given[0].dtype.kind == "f"):
        sample = np.concatenate([c[:: max(1, len(c) // _SAMPLE)] for c in given]).astype(np.float64)
        lo, hi = np.nanquantile(sample, [_LOW, _HIGH])
        low, high = min(0.0, lo), hi if hi > min(0.0, lo) else high
    else:
        low, high = 0.0, 1.0
    return [None if c is None else _scaled(c, low, high) for c in columns]


def _scaled(values: Array, low: float, high: float) -> Array:
    """(values - low) / (high - low) clipped to 0..1, float32; NaN becomes 0."""
    v = values.astype(np.float32)
    v -= np.float32(low)
    v /= np.float32(high - low)
    np.nan_to_num(v, copy=False)
    return np.clip(v, 0.0, 1.0, out=v)
