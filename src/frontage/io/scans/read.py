"""Any scan file: the one entry for point clouds."""

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from frontage.errors import FileError
from frontage.io.files import out_of_memory
from frontage.io.placement import PlacementRequest
from frontage.io.scans.formats import scan_format
from frontage.io.scans.origins import with_possible_origins
from frontage.io.scans.precision import unit_notes
from frontage.io.scans.request import Progress, ScanRequest
from frontage.io.scans.subset import cropped, require_box, require_resolution, thinned
from frontage.model import Scan, WorldRef


class ScanSource(BaseModel):
    """One scan file of a project, and what the user states about it."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    path: str = Field(description="file, or a COLMAP folder; the project file also takes globs")
    crs: str | None = Field(
        default=None, description="CRS of the file's coordinates, over what the file says"
    )
    units: Literal["m", "cm", "mm", "ft", "us-ft"] | None = Field(
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


def scan_inputs(source: ScanSource | str | Path) -> tuple[Path, ...]:
    """Every file that `read_scans` opens for a source: results that come from the scan depend on all of them.

    Files that the source names are listed even when they do not exist.

    Raises FileError (of no known format, a folder without a COLMAP model).
    """
    s = source if isinstance(source, ScanSource) else ScanSource(path=str(source))
    path = Path(s.path)
    return scan_format(path).inputs(path, _request(s))


def read_scans(
    source: ScanSource | str | Path,
    world: WorldRef | None = None,
    target_crs: str | None = None,
    bounds: tuple[float, ...] | None = None,
    resolution: float | None = None,
    *,
    progress: Progress | None = None,
) -> list[Scan]:
    """Read every scan of a file, in local metres of one world; E57 and PTX files may hold several.

    world       of the run; None: decided from this file (projected metric CRS, whole-metre origin)
    target_crs  the CRS that the user asks for
    bounds      (x0, y0, x1, y1) or (x0, y0, z0, x1, y1, z1), m world: points outside are left out
    resolution  m: at most one point per cube of this size is kept
    progress    called with the share done, 0..1

    Raises FileError (missing, empty, truncated, corrupt, of no known format, no points within the bounds),
    CrsError (unknown, missing, cannot be transformed), MissingExtra (E57 without pye57), InputError (bounds
    or a resolution that are no lengths).
    """
    require_box(bounds)
    require_resolution(resolution)
    s = source if isinstance(source, ScanSource) else ScanSource(path=str(source))
    path = Path(s.path)
    request = replace(_request(s, world, target_crs), bounds=bounds, resolution=resolution, progress=progress)
    scans = _believed(path, s, request)
    if s.sigma_range is not None:
        scans = [replace(scan, sigma_range=s.sigma_range) for scan in scans]
    if bounds is not None:
        scans = [scan for scan in (cropped(scan, bounds) for scan in scans) if len(scan)]
        if not scans:
            raise FileError(path, "holds no points within the bounds", "check the bounds", code="I105")
    if resolution is not None:
        scans = [thinned(scan, resolution) for scan in scans]
    if progress is not None:
        progress(1.0)
    return scans


def _believed(path: Path, s: ScanSource, request: ScanRequest) -> list[Scan]:
    """The scans of the file, without origins that cannot be right, with notes on what is doubtful."""
    kind = scan_format(path)
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # damaged values are dropped or refused
            scans = kind.read(path, request)
        if kind.measured:
            scans = [with_possible_origins(scan) for scan in scans]
    except MemoryError as problem:
        raise out_of_memory(path, problem) from problem
    notes = [*_unused(s, kind.inputs(path, request)), *unit_notes(path, scans, s.units)]
    return [replace(scan, notes=(*scan.notes, *notes)) for scan in scans] if notes else scans


def _unused(s: ScanSource, opened: tuple[Path, ...]) -> list[str]:
    """A sentence for every file that the source names and the reader does not open."""
    stated = {"trajectory": s.trajectory, "stations": s.stations}
    return [
        f"{Path(s.path).name}: the stated {name}, {Path(file).name}, is not used"
        for name, file in stated.items()
        if file is not None and Path(file) not in opened
    ]


def _request(s: ScanSource, world: WorldRef | None = None, target_crs: str | None = None) -> ScanRequest:
    """What the source states, as the readers take it."""
    placement = PlacementRequest(Path(s.path).name, world, target_crs, s.crs, s.units, s.offset)
    return ScanRequest(placement, s.sigmas, s.stations, s.trajectory)
