"""Vehicle trajectories (CSV, SBET): the sensor's position at the time of every point."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pyproj import CRS

from frontage.errors import FileError
from frontage.geometry.arrays import Array, Float
from frontage.io.crs import LARGEST_M
from frontage.io.files import reading, require_file, whole_file
from frontage.io.placement import Placement, PlacementRequest
from frontage.io.scans.table import read_table
from frontage.model import WorldRef

TRACK_STEP_M = 0.05
"""Distance along the track between stored sensor positions: an origin is wrong by at most half of it."""

_WEEK_S = 604_800.0  # the GPS week
_ADJUSTED_S = 1e9  # LAS 1.4: adjusted standard GPS time = GPS time - 1e9 s
_GAP_S = 1.0  # no position is interpolated further than this from a sample
_SBET = np.dtype([("time", "<f8"), ("lat", "<f8"), ("lon", "<f8"), ("alt", "<f8"), ("rest", "<f8", 13)])


@dataclass(frozen=True, eq=False)
class Trajectory:
    """The track of a sensor.

    time  (k,) s, strictly increasing
    xyz   (k, 3) in the file's own coordinates
    crs   of these coordinates; None = the scan's
    """

    path: Path
    time: Float
    xyz: Float
    crs: CRS | None = None


def read_trajectory(path: str | Path) -> Trajectory:
    """Read a trajectory from CSV (its header row names gps_time, x, y, z) or SBET (Applanix: .sbet, .out).

    Raises FileError when the file is missing, damaged, not a trajectory, or holds fewer than two positions.
    """
    p = require_file(path)
    if p.suffix.lower() in (".sbet", ".out"):
        time, xyz, crs = _sbet(p)
    else:
        time, xyz, crs = _csv(p)
    ok = np.isfinite(time) & (np.abs(xyz) < LARGEST_M).all(1)
    time, first = np.unique(time[ok], return_index=True)
    if len(time) < 2:
        raise FileError(
            p, "holds fewer than two positions at different times", "check its columns", code="I109"
        )
    return Trajectory(p, time, xyz[ok][first], crs)


def _csv(path: Path) -> tuple[Float, Float, CRS | None]:
    table = read_table(path, "trajectory CSV")
    time = table.column("gps_time", "gpstime", "time", "t")
    axes = [
        table.column(*names)
        for names in (("x", "easting", "east"), ("y", "northing", "north"), ("z", "height", "altitude", "up"))
    ]
    if time is None or any(a is None for a in axes):
        raise FileError(
            path, "its header row does not name gps_time, x, y, z", "name these columns", code="I109"
        )
    return time, np.column_stack(axes), None  # type: ignore[arg-type]


def _sbet(path: Path) -> tuple[Float, Float, CRS | None]:
    """Records of 17 little-endian doubles: time, latitude, longitude (rad), ellipsoidal height, ..."""
    with reading(path, "SBET"):
        if path.stat().st_size % _SBET.itemsize:
            raise FileError(
                path, "truncated: its size is not a multiple of an SBET record", "copy it again", code="I103"
            )
        r = np.fromfile(path, _SBET)
        if (np.abs(r["lat"]) > np.pi / 2).any() or (np.abs(r["lon"]) > 2 * np.pi).any():
            raise ValueError("latitudes or longitudes are out of range")
    return (
        r["time"],
        np.column_stack([np.degrees(r["lon"]), np.degrees(r["lat"]), r["alt"]]),
        CRS.from_epsg(4979),
    )


def rays_from_trajectory(
    track: Trajectory, time: Array, place: Placement, notes: list[str]
) -> tuple[Float, Array]:
    """Origins (s, 3) m local along the track, `TRACK_STEP_M` apart, and each point's nearest (n,) int32.

    The sensor's position is interpolated at each point's time and rounded to the nearest stored origin.
    Points before or after the track, or in gaps of more than a second, get -1, and `notes` gets a sentence.
    When the scan has adjusted standard GPS time and the track has seconds of the week, the scan's times are
    converted, also with a note.

    Raises FileError when the times do not overlap at all.
    """
    xyz = _local(track, place, notes)
    t = _same_clock(track, np.asarray(time, np.float64), notes)
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(xyz, axis=0), axis=1))])
    step = np.rint(np.interp(t, track.time, arc) / TRACK_STEP_M).astype(np.int64)
    after = np.clip(np.searchsorted(track.time, t), 1, len(track.time) - 1)
    near = np.minimum(np.abs(t - track.time[after]), np.abs(t - track.time[after - 1])) <= _GAP_S
    known = near & (t >= track.time[0] - TRACK_STEP_M) & (t <= track.time[-1] + TRACK_STEP_M)
    if not known.all():
        count = int((~known).sum())
        notes.append(f"{track.path.name}: {count} points lie outside its times; their origin is unknown")
    used, inverse = np.unique(step[known], return_inverse=True)
    origins = np.column_stack([np.interp(used * TRACK_STEP_M, arc, xyz[:, k]) for k in range(3)])
    index = np.full(len(t), -1, np.int32)
    index[known] = inverse
    return origins, index


def _local(track: Trajectory, place: Placement, notes: list[str]) -> Float:
    """The track in local metres; without a CRS of its own it is placed as the scan is."""
    if track.crs is None:
        return place.to_local(track.xyz)
    world = WorldRef(place.world.origin, place.world.crs)
    own = PlacementRequest(track.path.name, world).place(track.crs, track.xyz)
    notes.extend(own.notes)
    return own.to_local(track.xyz)


def _same_clock(track: Trajectory, time: Float, notes: list[str]) -> Float:
    """Convert the times of points (n,) s to the track's clock. Raises FileError when no clock fits."""
    reduced = "the GPS times of the points were reduced to seconds of the week"
    for t, note in (
        (time, ""),
        ((time + _ADJUSTED_S) % _WEEK_S, reduced),
        (time % _WEEK_S, reduced),
    ):
        if t.max() >= track.time[0] and t.min() <= track.time[-1]:
            if note:
                notes.append(f"{track.path.name}: {note}")
            return t
    raise FileError(
        track.path,
        f"its times {track.time[0]:.1f}..{track.time[-1]:.1f} s do not overlap those of the points, "
        f"{time.min():.1f}..{time.max():.1f} s",
        "name the trajectory of this scan",
        code="I109",
    )


def write_trajectory(path: str | Path, samples: Float, world: WorldRef) -> Path:
    """Write a trajectory as CSV with a header row; world coordinates to 0.1 mm, angles in degrees to 1e-5.

    samples  (k, 7): gps_time s, x, y, z m local, roll, pitch, heading rad

    Raises FileError (cannot be written).
    """
    p = Path(path)
    table = np.column_stack([samples[:, 0], world.to_world(samples[:, 1:4]), np.degrees(samples[:, 4:7])])
    with whole_file(p) as temporary, temporary.open("w", encoding="ascii", newline="\n") as f:
        f.write("gps_time,x,y,z,roll,pitch,heading\n")
        np.savetxt(f, table, fmt=["%.6f", *["%.4f"] * 3, *["%.5f"] * 3], delimiter=",")
    return p
