"""Point clouds whose points know where they were measured from."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from frontage.geometry.arrays import Array, Float, Int, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model.estimate import Estimate
from frontage.model.noreturns import NoReturns, no_returns
from frontage.model.world import WorldRef

_PER_POINT = {
    "intensity": np.float32,
    "time": np.float64,
    "return_number": np.uint8,
    "return_count": np.uint8,
}


@dataclass(frozen=True, eq=False)
class Grid:
    """The raster of a structured scan: `index` (h, w) int64 into its points, -1 = beam without return."""

    index: Int

    def __post_init__(self) -> None:
        freeze(self, index=((None, None), np.int64))


@dataclass(frozen=True, eq=False)
class Scan:
    """A point cloud in local coordinates, with its rays.

    name          the file (and scan inside it) that it came from, for messages and reports
    xyz           (n, 3) float64 m, local
    world         local -> world
    origins       (s, 3) float64 m, local: where the sensor stood (stations) or was (trajectory samples)
    origin_index  (n,) int32 into `origins`; -1 = unknown
    intensity     (n,) float32, 0..1, or None; rgb (n, 3) uint8 or None; time (n,) float64 s or None
    return_number, return_count  (n,) uint8 or None
    grid          raster of a structured scan, or None (merged and cropped clouds have none)
    no_returns    beams without return of merged and cropped clouds
    sigma_range   m, standard error of a range, when known
    local_from_scanner  pose of the instrument, when the scan has exactly one
    notes         remarks of the reader (dropped points, assumed CRS, ...), one sentence each
    """

    name: str
    xyz: Float
    world: WorldRef
    origins: Float = None  # type: ignore[assignment]  # None: empty
    origin_index: Array = None  # type: ignore[assignment]  # None: all unknown
    intensity: Array | None = None
    rgb: Array | None = None
    time: Float | None = None
    return_number: Array | None = None
    return_count: Array | None = None
    grid: Grid | None = None
    no_returns: tuple[NoReturns, ...] = ()
    sigma_range: float | None = None
    local_from_scanner: Estimate[Rigid3] | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.xyz)
        if self.origins is None:
            object.__setattr__(self, "origins", np.empty((0, 3)))
        if self.origin_index is None:
            object.__setattr__(self, "origin_index", np.full(n, -1, np.int32))
        freeze(self, xyz=((n, 3), np.float64), origins=((None, 3), np.float64), rgb=((n, 3), np.uint8))
        freeze(
            self, origin_index=((n,), np.int32), **{name: ((n,), dtype) for name, dtype in _PER_POINT.items()}
        )
        self._check()

    def _check(self) -> None:
        """Raises ValueError for coordinates that are not finite and for indices without an origin."""
        for name in ("xyz", "origins"):
            if not np.isfinite(getattr(self, name)).all():
                raise ValueError(
                    f"{self.name}: {name} holds numbers that are not finite; leave these rows out"
                )
        low, high = self.origin_index.min(initial=-1), self.origin_index.max(initial=-1)
        if low < -1 or high >= len(self.origins):
            raise ValueError(
                f"{self.name}: origin_index runs from {low} to {high}, but there are "
                f"{len(self.origins)} origins"
            )

    def __repr__(self) -> str:
        """Say how many points it has, and what is known of them."""
        known = [name for name in ("intensity", "rgb", "time") if getattr(self, name) is not None]
        rays = f"{len(self.origins)} origins" if self.has_origins else "no origins"
        about = ", ".join([self.world.crs or "no CRS", rays, *known])
        return f"<Scan {self.name}: {len(self):,} points, {about}>"

    def __len__(self) -> int:
        return len(self.xyz)

    @property
    def has_origins(self) -> bool:
        """Whether at least one point knows where it was measured from."""
        return bool(np.any(self.origin_index >= 0))

    def take(self, index: Array) -> "Scan":
        """Returns the points at `index` (k,) int or (n,) bool, with `lost_beams` in place of the raster."""
        if index.dtype == np.bool_:
            index = np.flatnonzero(index)  # numpy takes rows by number several times as fast
        rows: dict[str, Any] = {
            name: np.take(value, index, axis=0)
            for name in ("xyz", "origin_index", "rgb", *_PER_POINT)
            if (value := getattr(self, name)) is not None
        }
        return replace(self, grid=None, no_returns=self.lost_beams(), **rows)

    def lost_beams(self) -> tuple[NoReturns, ...]:
        """Returns the beams without return of its own raster or of those it was merged from."""
        if self.grid is None or len(self.origins) != 1:
            return self.no_returns
        found = no_returns(self.xyz, self.origins[0], self.grid.index)
        return () if found is None else (found,)

    def sensor_of(self, index: Array) -> Float:
        """Returns the sensor positions (k, 3) m local of the points at `index`; NaN where unknown."""
        padded = np.vstack([self.origins, np.full(3, np.nan)])
        return np.asarray(padded[self.origin_index[index]])


def merge_scans(scans: Sequence[Scan], name: str = "merged") -> Scan:
    """Merges scans that share one `WorldRef` into one cloud and keeps its rays.

    Attributes that some scans lack are dropped. Of the rasters, only the beams without return are kept.
    Raises ValueError when the world references differ.
    """
    first = scans[0]
    if len(scans) == 1:
        return replace(first, grid=None, no_returns=first.lost_beams())
    if any((s.world.origin != first.world.origin).any() or s.world.crs != first.world.crs for s in scans):
        raise ValueError("scans to merge must share one world reference")
    start = np.cumsum([0, *(len(s.origins) for s in scans)])
    index = [
        np.where(s.origin_index >= 0, s.origin_index + o, -1) for s, o in zip(scans, start, strict=False)
    ]
    rows: dict[str, Any] = {
        name: np.concatenate([getattr(s, name) for s in scans])
        for name in ("rgb", *_PER_POINT)
        if all(getattr(s, name) is not None for s in scans)
    }
    sigmas = [s.sigma_range for s in scans if s.sigma_range is not None]
    return Scan(
        name,
        np.concatenate([s.xyz for s in scans]),
        first.world,
        np.concatenate([s.origins for s in scans]),
        np.concatenate(index),
        no_returns=tuple(
            replace(lost, origin=lost.origin + int(o))
            for s, o in zip(scans, start, strict=False)
            for lost in s.lost_beams()
        ),
        sigma_range=max(sigmas) if sigmas else None,
        notes=tuple(dict.fromkeys(n for s in scans for n in s.notes)),
        **rows,
    )
