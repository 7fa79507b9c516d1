"""Any scan file, by its suffix: the one door for point clouds."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from frontage.errors import FileError
from frontage.io.colmap import model_folder, read_colmap_points
from frontage.io.placement import Wanted
from frontage.io.scans.e57 import read_e57
from frontage.io.scans.las import read_las
from frontage.io.scans.npz import load_scan
from frontage.io.scans.ply import read_ply
from frontage.io.scans.ptx import read_ptx
from frontage.io.scans.trajectory import read_trajectory
from frontage.io.scans.xyz import read_xyz
from frontage.model import Grid, Scan, WorldRef

SUFFIXES = (".las", ".laz", ".e57", ".ptx", ".ply", ".xyz", ".csv", ".txt", ".asc", ".pts", ".bin", ".npz")
Progress = Callable[[float], None]


class ScanSource(BaseModel):
    """One scan file of a project, and what the user says of it."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    path: str = Field(description="file, or a COLMAP folder; the project file also takes globs")
    crs: str | None = Field(
        default=None, description="CRS of the file's coordinates, over what the file says"
    )
    units: Literal["m", "ft", "us-ft"] | None = Field(
        default=None, description="unit of the file's coordinates"
    )
    offset: tuple[float, float, float] = Field(
        default=(0.0, 0.0, 0.0), description="m, added to the file's coordinates"
    )
    pose: Literal["trusted", "approximate"] = Field(
        default="trusted", description="how far the file's pose may be trusted"
    )
    sigma_position: float = Field(default=2.0, gt=0, description="m, of an approximate pose")
    sigma_heading: float = Field(default=5.0, gt=0, le=180, description="degrees, of an approximate pose")
    sigma_level: float = Field(default=0.1, gt=0, le=90, description="degrees, of an approximate pose")
    sigma_range: float | None = Field(default=None, gt=0, description="m, one sigma of a range, when known")
    trajectory: str | None = Field(default=None, description="CSV or SBET of the vehicle")
    stations: str | None = Field(
        default=None, description="JSON of station positions; found by itself beside the scan"
    )

    @property
    def sigmas(self) -> tuple[float, ...] | None:
        """Six sigmas of the pose, m and rad (x, y, z, about x, y, z); None when it is trusted."""
        if self.pose == "trusted":
            return None
        level, heading = np.radians(self.sigma_level), np.radians(self.sigma_heading)
        return (self.sigma_position,) * 3 + (float(level), float(level), float(heading))


def read_scans(
    source: ScanSource | str | Path,
    world: WorldRef | None = None,
    target_crs: str | None = None,
    bounds: tuple[float, ...] | None = None,
    resolution: float | None = None,
    progress: Progress | None = None,
) -> list[Scan]:
    """Every scan of a file, in local metres of one world; several for E57 and PTX.

    world       of the run; None: decided from this file (projected metric CRS, whole-metre origin)
    target_crs  the CRS the user asks for
    bounds      (x0, y0, x1, y1) or (x0, y0, z0, x1, y1, z1), m world: points outside are left out
    resolution  m: at most one point per cube of this size (COPC stops at that level of its tree)
    progress    called with the share done, 0..1

    Raises FileError, CrsError, MissingExtra.
    """
    s = source if isinstance(source, ScanSource) else ScanSource(path=str(source))
    p = Path(s.path)
    wanted = Wanted(p.name, world, target_crs, s.crs, s.units, s.offset)
    scans = _read(p, s, wanted, bounds, resolution, progress)
    if s.sigma_range is not None:
        scans = [replace(scan, sigma_range=s.sigma_range) for scan in scans]
    if bounds is not None:
        scans = [cropped(scan, bounds) for scan in scans]
        scans = [scan for scan in scans if len(scan)]
        if not scans:
            raise FileError(p, "holds no points within the bounds", "check the bounds", code="I105")
    if resolution is not None:
        scans = [thinned(scan, resolution) for scan in scans]
    if progress is not None:
        progress(1.0)
    return scans


def _read(
    p: Path,
    s: ScanSource,
    wanted: Wanted,
    bounds: tuple[float, ...] | None,
    resolution: float | None,
    progress: Progress | None,
) -> list[Scan]:
    """Dispatch by suffix."""
    suffix = p.suffix.lower()
    if p.is_dir():
        model_folder(p)
        return [read_colmap_points(p, wanted)]
    if suffix in (".las", ".laz"):
        track = read_trajectory(s.trajectory) if s.trajectory else None
        return [read_las(p, wanted, s.stations, track, bounds, resolution, progress)]
    if suffix == ".e57":
        return read_e57(p, wanted, s.sigmas)
    if suffix == ".ptx":
        return read_ptx(p, wanted, s.sigmas)
    if suffix == ".ply":
        return [read_ply(p, wanted)]
    if suffix == ".npz":
        return [load_scan(p)]
    if p.stem.lower() == "points3d" and suffix in (".txt", ".bin"):
        return [read_colmap_points(p, wanted)]
    if suffix in (".xyz", ".csv", ".txt", ".asc", ".pts"):
        return [read_xyz(p, wanted)]
    raise FileError(
        p,
        f"unknown kind of scan {suffix!r}" if p.exists() else "no such file",
        "Frontage reads " + ", ".join(SUFFIXES[:-2]),
        code="I101",
    )


def cropped(scan: Scan, bounds: tuple[float, ...]) -> Scan:
    """The points within (x0, y0, x1, y1) or (x0, y0, z0, x1, y1, z1) m world, without raster."""
    k = len(bounds) // 2
    low = np.array(bounds[:k]) - scan.world.origin[:k]
    high = np.array(bounds[k:]) - scan.world.origin[:k]
    keep = ((scan.xyz[:, :k] >= low) & (scan.xyz[:, :k] <= high)).all(axis=1)
    return scan if keep.all() else _kept(scan, keep)


def thinned(scan: Scan, resolution: float) -> Scan:
    """The first point of every cube of `resolution` m.

    Beams without return are dropped: they would no longer compare with the others.
    """
    cell = np.floor((scan.xyz - scan.xyz.min(0)) / resolution).astype(np.int64)
    size = cell.max(0) + 1
    _, first = np.unique((cell[:, 0] * size[1] + cell[:, 1]) * size[2] + cell[:, 2], return_index=True)
    keep = np.zeros(len(scan), bool)
    keep[first] = True
    return replace(_kept(scan, keep), no_returns=())


def _kept(scan: Scan, keep: Any) -> Scan:
    """`scan.take` without its raster: a beam that was cropped away is no beam without return."""
    return scan.take(np.flatnonzero(keep))


def scan_info(path: str | Path) -> dict[str, Any]:
    """Facts of a scan file for `frontage info`: points, extent, CRS (world), spacing, sensors, fields, notes.

    `spacing` is the median distance to the nearest neighbour of some thousand points, m.
    Raises FileError, CrsError, MissingExtra.
    """
    scans = read_scans(path)
    low = np.min([s.world.to_world(s.xyz.min(0)) for s in scans], axis=0)
    high = np.max([s.world.to_world(s.xyz.max(0)) for s in scans], axis=0)
    return {
        "path": str(path),
        "format": Path(path).suffix.lower().lstrip(".") or "colmap",
        "points": sum(len(s) for s in scans),
        "crs": scans[0].world.crs,
        "minimum": low.round(4).tolist(),
        "maximum": high.round(4).tolist(),
        "scans": [_scan_facts(s) for s in scans],
        "notes": list(dict.fromkeys(n for s in scans for n in s.notes)),
    }


def _scan_facts(s: Scan) -> dict[str, Any]:
    fields = [n for n in ("intensity", "rgb", "time", "return_number") if getattr(s, n) is not None]
    raster = list(s.grid.index.shape) if isinstance(s.grid, Grid) else None
    return {
        "name": s.name,
        "points": len(s),
        "spacing": round(spacing(s), 5),
        "fields": fields,
        "origins": len(s.origins),
        "with_origin": float(np.mean(s.origin_index >= 0)),
        "raster": raster,
    }


def spacing(scan: Scan, sample: int = 2000) -> float:
    """Median distance of a point to its nearest neighbour, m, at `sample` of the points; 0 for one point."""
    from scipy.spatial import cKDTree

    if len(scan) < 2:
        return 0.0
    tree = cKDTree(scan.xyz, balanced_tree=False, compact_nodes=False)
    distance, _ = tree.query(scan.xyz[:: max(1, len(scan) // sample)], k=2)
    return float(np.median(np.asarray(distance)[:, 1]))
