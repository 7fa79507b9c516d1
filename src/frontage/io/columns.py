"""From the raw columns of a file to a `Scan`: dropping bad points, scaling intensity and colour."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.io.placement import Placement
from frontage.model import Estimate, Grid, Scan

_SAMPLE = 500_000  # values that a quantile is taken from, evenly spread
_MANY = 1000  # points: real colour varies in every channel over so many
_LOW, _HIGH = 0.001, 0.999  # quantiles: a mirror-like flash must not darken a whole facade


@dataclass
class Columns:
    """What a file says of its points, row by row: xyz (n, 3) float64 *local* metres, the rest as stored.

    grid (h, w) int64 indexes the rows, -1 = no return. `keep` (n,) bool marks the rows to keep, None = all.
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


def to_scan(path: object, columns: Columns, placement: Placement) -> Scan:
    """The noun: rows without finite coordinates dropped, intensity and colour by `normalised`, `rgb8`.

    Raises FileError when no point is left.
    """
    c = _kept(path, columns)
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


def _kept(path: object, c: Columns) -> Columns:
    """Drop the rows that are not wanted or not finite; the raster follows."""
    finite = np.isfinite(c.xyz).all(axis=1)
    keep = finite if c.keep is None else finite & c.keep
    if not finite.all():
        c.notes.append(f"{c.name}: {int((~finite).sum())} points without finite coordinates dropped")
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


def rgb8(rgb: Array | None, c: Columns) -> Array | None:
    """Colour (n, 3) of any integer or float type as uint8; None, with a note, when it cannot be colour: one
    value throughout, or a channel that never changes over a whole scan (other data in the colour fields).

    16-bit fields are halved to their upper byte, except when no value passes 255: many programs store 8-bit
    colour in LAS's 16-bit fields. Floats are taken as 0..1 when none passes 1, else as 0..255.
    """
    if rgb is None or len(rgb) == 0:
        return None
    constant = (rgb == rgb[0]).all(axis=0)
    if constant.all() or (constant.any() and len(rgb) > _MANY):
        if rgb.any():
            c.notes.append(f"{c.name}: its colour fields hold no colour (a channel never changes): dropped")
        return None
    top = rgb.max()
    if rgb.dtype.kind == "f":
        return np.clip(np.nan_to_num(rgb) * (255.0 if top <= 1.0 else 1.0), 0, 255).round().astype(np.uint8)
    return rgb.astype(np.uint8) if top <= 255 else (rgb >> 8).astype(np.uint8)


def normalised(columns: Sequence[Array | None]) -> list[Array | None]:
    """Intensities of the scans of one file as float32 0..1, with one scale for all of them.

    Values that lie in 0..1 already are kept. Others are scaled linearly from min(0, 0.1 % quantile) to the
    99.9 % quantile and clipped; linear, so that ratios of reflectance survive. A constant gives None.
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
