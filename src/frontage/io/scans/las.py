"""Reading LAS and LAZ of every point format, and COPC with queries, chunk by chunk into local metres."""

import contextlib
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Any

import laspy
import numpy as np
from pyproj import CRS

from frontage.errors import FileError
from frontage.geometry.arrays import Array, Float
from frontage.io.columns import PointColumns, to_scan
from frontage.io.crs import parse_crs
from frontage.io.files import reading, require_file
from frontage.io.placement import Placement, PlacementRequest
from frontage.io.scans.lasheader import check_las
from frontage.io.scans.precision import require_fine_steps
from frontage.io.scans.request import Progress, ScanRequest
from frontage.io.scans.stations import rays_from_stations
from frontage.io.scans.trajectory import Trajectory, rays_from_trajectory, read_trajectory
from frontage.model import Scan

CHUNK_POINTS = 1_000_000  # about 60 MB of working memory
OWN_SOFTWARE = "frontage"  # generating software of our files: their intensity is 0..65535 for 0..1
ORIGIN_INDEX = "origin_index"  # extra dimension, for more sensor positions than point_source_id can count
_FEW_POINTS = 10_000  # enough to decide where a file lies
_FIELDS = {
    "intensity": "intensity",
    "gps_time": "time",
    "point_source_id": "source",
    "return_number": "return_number",
    "number_of_returns": "return_count",
    "withheld": "withheld",
    ORIGIN_INDEX: "ray",
}
"""LAS dimensions that are used, and what they are called here."""


def read_las(path: str | Path, request: ScanRequest) -> list[Scan]:
    """Read a LAS, LAZ or COPC file as one scan.

    With `bounds` or a `resolution`, only the needed nodes of a COPC file's octree are read; other files are
    read whole. Rays come from the trajectory, else from the stations file, else the scan has none.

    Raises FileError (missing, empty, truncated, corrupt), CrsError.
    """
    p = require_file(path)
    track = read_trajectory(request.trajectory) if request.trajectory else None
    with reading(p, "LAS/LAZ"):
        check_las(p)
        header, chunks, total = _open(p, request)
        with contextlib.closing(chunks):
            columns, placement = _stream(p, header, chunks, total, request)
    software = header.generating_software  # bytes where it is not ASCII
    own = isinstance(software, str) and software.startswith(OWN_SOFTWARE)
    if own and columns.intensity is not None:
        columns.intensity = columns.intensity.astype(np.float32) / 65535.0
    columns.origins, columns.origin_index = _rays(p, columns, placement, request.stations, track)
    return [to_scan(p, columns, placement)]


def las_files(path: Path, request: ScanRequest) -> tuple[Path, ...]:
    """The files that `read_las` opens: the scan, and its trajectory or its stations."""
    if request.trajectory is not None:
        return path, Path(request.trajectory)
    stations = _stations_file(path, request.stations)
    return (path,) if stations is None else (path, stations)


def _stations_file(path: Path, stated: str | None) -> Path | None:
    """The stations file that is stated, else the one beside the scan; None without either."""
    if stated is not None:
        return Path(stated)
    beside = path.with_name(path.name + ".stations.json")
    return beside if beside.exists() else None


def _crs(header: Any, path: Path) -> CRS | None:
    """The CRS of the header's WKT or GeoTIFF keys; None when there is none."""
    with reading(path, "LAS/LAZ"):
        found = header.parse_crs()
    return None if found is None else parse_crs(found.to_wkt(), str(path))


def _open(path: Path, request: ScanRequest) -> tuple[Any, Generator[Any, None, None], int]:
    """The header, the point records and their number; a COPC file is queried where that is asked for."""
    f = laspy.open(path)
    if f.header.point_count == 0:
        f.close()
        raise FileError(path, "holds no points", "export or copy it again", code="I105")
    is_copc = any(v.user_id == "copc" and v.record_id == 1 for v in f.header.vlrs)
    if not is_copc or (request.bounds is None and request.resolution is None):
        return f.header, _all_points(f), int(f.header.point_count)
    f.close()
    with laspy.CopcReader.open(path) as copc:
        box = _box(copc.header, path, request.placement, request.bounds)
        points = copc.query(box, resolution=request.resolution)
        return copc.header, (part for part in [points] if len(part)), len(points)


def _all_points(f: Any) -> Generator[Any, None, None]:
    with f:
        yield from f.chunk_iterator(CHUNK_POINTS)


def _box(header: Any, path: Path, placement: PlacementRequest, bounds: tuple[float, ...] | None) -> Any:
    """World bounds as a horizontal box in file coordinates, slightly too large where the CRS differ."""
    if bounds is None:
        return None
    corners = np.array([header.mins, header.maxs], np.float64)
    place = placement.place(_crs(header, path), corners)
    half = len(bounds) // 2
    (x0, y0), (x1, y1) = bounds[:2], bounds[half : half + 2]
    g = np.linspace(0, 1, 9)
    edge = np.array([(x0 + a * (x1 - x0), y0 + b * (y1 - y0)) for a in g for b in g])
    if place.transformer is not None:
        if not place.flat:
            return None
        edge = np.column_stack(place.transformer.transform(edge[:, 0], edge[:, 1], direction="INVERSE"))
    edge = (edge - place.offset[:2]) / place.scale[:2]
    slack = 0.0 if place.transformer is None else 0.01 * float(np.ptp(edge, axis=0).max())
    return laspy.Bounds(mins=edge.min(0) - slack, maxs=edge.max(0) + slack)


def _stream(
    path: Path, header: Any, chunks: Iterator[Any], total: int, request: ScanRequest
) -> tuple[PointColumns, Placement]:
    """Read all records into preallocated columns; the first chunk decides the placement."""
    at = 0
    store: dict[str, Array] = {}
    place: Placement | None = None
    notes: list[str] = []
    progress: Progress | None = request.progress
    for chunk in chunks:
        n = len(chunk)
        raw = np.column_stack([chunk.X, chunk.Y, chunk.Z]).astype(np.float64) * header.scales + header.offsets
        _require_plausible(path, header, raw)
        if place is None:
            place = request.placement.place(_crs(header, path), raw[:: max(1, n // _FEW_POINTS)])
            require_fine_steps(path, raw, place.to_local, notes, scales=header.scales)
        _put(store, "xyz", place.to_local(raw), at, total)
        for name, values in _fields(chunk):
            _put(store, name, values, at, total)
        at += n
        if progress is not None:
            progress(at / total)
    if place is None:
        raise FileError(path, "holds no points within the bounds", "check the bounds", code="I105")
    if at != total:
        raise FileError(path, f"truncated: {at} of {total} points", "export or copy it again", code="I103")
    columns = _columns(path, store)
    columns.notes.extend(notes)
    return columns, place


def _require_plausible(path: Path, header: Any, raw: Float) -> None:
    """Raise FileError for points (n, 3) outside the header's bounds by more than their diagonal.

    Damaged LAZ data decodes into such points without any error. A header without bounds is not judged.
    """
    low, high = np.asarray(header.mins, np.float64), np.asarray(header.maxs, np.float64)
    size = float(np.linalg.norm(high - low))
    if not np.isfinite(size) or size == 0 or (high < low).any():
        return
    if (raw.min(0) < low - size).any() or (raw.max(0) > high + size).any():
        raise FileError(
            path, "damaged: points lie far outside the bounds in its header", "copy it again", code="I103"
        )


def _fields(chunk: Any) -> Iterator[tuple[str, Array]]:
    """The attributes that are used; a record may hold others."""
    names = set(chunk.point_format.dimension_names)
    for name, column in _FIELDS.items():
        if name in names:
            yield column, np.asarray(chunk[name])
    if "red" in names:
        yield "rgb", np.column_stack([chunk.red, chunk.green, chunk.blue])


def _put(store: dict[str, Array], name: str, values: Array, at: int, total: int) -> None:
    """Copy one chunk of a column to its place."""
    if name not in store:
        store[name] = np.empty((total, *values.shape[1:]), values.dtype)
    store[name][at : at + len(values)] = values


def _columns(path: Path, store: dict[str, Array]) -> PointColumns:
    """The columns for `to_scan`; `origin_index` carries the source ids until the rays are known."""
    c = PointColumns(
        path.name,
        store["xyz"],
        store.get("intensity"),
        store.get("rgb"),
        store.get("time"),
        return_number=store.get("return_number"),
        return_count=store.get("return_count"),
    )
    c.origin_index = store.get("ray", store["source"])
    withheld = store.get("withheld")
    if withheld is not None and withheld.any():
        c.keep = ~withheld.astype(bool)
        c.notes.append(
            f"{path.name}: {int(withheld.astype(bool).sum())} points that are marked as withheld were dropped"
        )
    return c


def _rays(
    path: Path, c: PointColumns, place: Placement, stations: str | None, track: Trajectory | None
) -> tuple[Float | None, Array | None]:
    """Sensor positions (s, 3) m local and their index per point (n,), where a file states them."""
    source, c.origin_index = c.origin_index, None
    if track is not None:
        if c.time is None or not np.ptp(c.time):
            raise FileError(
                path,
                "has a trajectory, but its points have no gps_time",
                "export it with GPS time",
                code="I106",
            )
        return rays_from_trajectory(track, c.time, place, c.notes)
    found = _stations_file(path, stations)
    if found is None or source is None:
        return None, None
    return rays_from_stations(found, source, place, c.notes)
