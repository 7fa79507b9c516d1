"""LAS and LAZ of every point format, COPC with queries: streamed in chunks into local float64 metres."""

from collections.abc import Callable, Iterator
from datetime import date
from pathlib import Path
from typing import Any

import laspy
import numpy as np
from pyproj import CRS

from frontage.errors import FileError
from frontage.geometry.arrays import Array, Float
from frontage.io.columns import Columns, to_scan
from frontage.io.crs import parse_crs
from frontage.io.files import reading, require_file, whole_file
from frontage.io.placement import Placement, Wanted
from frontage.io.scans import stations as sidecar
from frontage.io.scans.trajectory import Trajectory, rays_from_trajectory
from frontage.model import Scan

CHUNK = 1_000_000  # points: about 60 MB of working memory
_OWN = "frontage"  # generating software of our files: their intensity is 0..65535 for 0..1
_STEP = 0.0001  # m: coordinates are stored in tenths of a millimetre
_RAY = "origin_index"  # extra dimension for clouds with more sensor positions than point_source_id can count
Progress = Callable[[float], None]


def read_las(
    path: str | Path,
    wanted: Wanted,
    stations: str | Path | None = None,
    trajectory: Trajectory | None = None,
    bounds: tuple[float, ...] | None = None,
    resolution: float | None = None,
    progress: Progress | None = None,
) -> Scan:
    """A LAS, LAZ or COPC file as one scan.

    stations    JSON of `point_source_id` -> position; by default "<file>.stations.json" beside it, if there
    trajectory  of the vehicle: every point gets the position at its gps_time
    bounds      (x0, y0, x1, y1) m world; a COPC file reads only the nodes that it needs
    resolution  m: a COPC file stops at the octree level that is this dense; the caller thins others

    Raises FileError (missing, empty, truncated, corrupt), CrsError.
    """
    p = require_file(path)
    with reading(p, "LAS/LAZ"):
        header, chunks, total = _open(p, wanted, bounds, resolution)
        columns, placement = _stream(p, header, chunks, total, wanted, progress)
    own = header.generating_software.startswith(_OWN)
    if own and columns.intensity is not None:
        columns.intensity = columns.intensity.astype(np.float32) / 65535.0
    columns.origins, columns.origin_index = _rays(p, columns, placement, stations, trajectory)
    return to_scan(p, columns, placement)


def las_info(path: str | Path) -> dict[str, Any]:
    """Header facts of a LAS file without reading its points: format, count, bounds, crs, dimensions."""
    p = require_file(path)
    with reading(p, "LAS/LAZ"), laspy.open(p) as f:
        h = f.header
        crs = _crs(h, p)
        return {
            "format": f"LAS {h.version} point format {h.point_format.id}",
            "points": int(h.point_count),
            "minimum": [float(v) for v in h.mins],
            "maximum": [float(v) for v in h.maxs],
            "crs": None if crs is None else crs.name,
            "dimensions": list(h.point_format.dimension_names),
        }


def _crs(header: Any, path: Path) -> CRS | None:
    """The CRS of the header's WKT or GeoTIFF keys; None when there is none."""
    with reading(path, "LAS/LAZ"):
        found = header.parse_crs()
    return None if found is None else parse_crs(found.to_wkt(), str(path))


def _open(
    path: Path,
    wanted: Wanted,
    bounds: tuple[float, ...] | None,
    resolution: float | None,
) -> tuple[Any, Iterator[Any], int]:
    """The header, point records and their number; a COPC query when it is asked and possible."""
    f = laspy.open(path)
    if f.header.point_count == 0:
        f.close()
        raise FileError(path, "holds no points", "export or copy it again", code="I105")
    is_copc = any(v.user_id == "copc" and v.record_id == 1 for v in f.header.vlrs)
    if not is_copc or (bounds is None and resolution is None):
        return f.header, _all_points(f), int(f.header.point_count)
    f.close()
    with laspy.CopcReader.open(path) as copc:
        points = copc.query(_box(copc.header, path, wanted, bounds), resolution=resolution)
        return copc.header, iter([points] if len(points) else []), len(points)


def _all_points(f: Any) -> Iterator[Any]:
    with f:
        yield from f.chunk_iterator(CHUNK)


def _box(header: Any, path: Path, wanted: Wanted, bounds: tuple[float, ...] | None) -> Any:
    """World bounds (x0, y0, x1, y1) as a box in file coordinates, a little large where the CRS differ."""
    if bounds is None:
        return None
    corners = np.array([header.mins, header.maxs], np.float64)
    place = wanted.place(_crs(header, path), corners)
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
    path: Path, header: Any, chunks: Iterator[Any], total: int, wanted: Wanted, progress: Progress | None
) -> tuple[Columns, Placement]:
    """All records into preallocated columns; the first chunk decides the placement."""
    at = 0
    store: dict[str, Array] = {}
    place: Placement | None = None
    for chunk in chunks:
        n = len(chunk)
        raw = np.column_stack([chunk.X, chunk.Y, chunk.Z]).astype(np.float64) * header.scales + header.offsets
        _plausible(path, header, raw)
        if place is None:
            place = wanted.place(_crs(header, path), raw[:: max(1, n // 10_000)])
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
    return _columns(path, store), place


def _plausible(path: Path, header: Any, raw: Float) -> None:
    """Refuse points (n, 3) further outside the header's bounds than these are large: damaged LAZ data decodes
    into such points without any error. Headers without bounds are not judged."""
    low, high = np.asarray(header.mins, np.float64), np.asarray(header.maxs, np.float64)
    size = float(np.linalg.norm(high - low))
    if not np.isfinite(size) or size == 0 or (high < low).any():
        return
    if (raw.min(0) < low - size).any() or (raw.max(0) > high + size).any():
        raise FileError(
            path, "damaged: points lie far outside the bounds in its header", "copy it again", code="I103"
        )


def _fields(chunk: Any) -> Iterator[tuple[str, Array]]:
    """The attributes that are used, whatever else a record holds."""
    names = set(chunk.point_format.dimension_names)
    renamed = {
        "intensity": "intensity",
        "gps_time": "time",
        "point_source_id": "source",
        "return_number": "return_number",
        "number_of_returns": "return_count",
        "withheld": "withheld",
        _RAY: "ray",
    }
    for name, column in renamed.items():
        if name in names:
            yield column, np.asarray(chunk[name])
    if "red" in names:
        yield "rgb", np.column_stack([chunk.red, chunk.green, chunk.blue])


def _put(store: dict[str, Array], name: str, values: Array, at: int, total: int) -> None:
    """Copy one chunk's column into its place."""
    if name not in store:
        store[name] = np.empty((total, *values.shape[1:]), values.dtype)
    store[name][at : at + len(values)] = values


def _columns(path: Path, store: dict[str, Array]) -> Columns:
    """Columns as `to_scan` takes them; `origin_index` carries the source ids until the rays are known."""
    c = Columns(
        path.name,
        store["xyz"],
        store.get("intensity"),
        store.get("rgb"),
        store.get("time"),
        store.get("return_number"),
        store.get("return_count"),
    )
    c.origin_index = store.get("ray", store["source"])
    withheld = store.get("withheld")
    if withheld is not None and withheld.any():
        c.keep = ~withheld.astype(bool)
        c.notes.append(f"{path.name}: {int(withheld.astype(bool).sum())} points marked withheld dropped")
    return c


def _rays(
    path: Path,
    c: Columns,
    place: Placement,
    stations: str | Path | None,
    trajectory: Trajectory | None,
) -> tuple[Float | None, Array | None]:
    """Sensor positions from a trajectory, else from the stations file, else none."""
    source, c.origin_index = c.origin_index, None
    if trajectory is not None:
        if c.time is None or not np.ptp(c.time):
            raise FileError(
                path,
                "has a trajectory but its points have no gps_time",
                "export it with GPS time",
                code="I106",
            )
        return rays_from_trajectory(trajectory, c.time, place, c.notes)
    found = Path(stations) if stations is not None else path.with_name(path.name + ".stations.json")
    if (stations is None and not found.exists()) or source is None:
        return None, None
    return sidecar.rays_from_stations(found, source, place, c.notes)


def write_las(path: str | Path, scan: Scan) -> Path:
    """Write a scan as LAS 1.4 (LAZ by its suffix), 0.1 mm steps, CRS as WKT; rays beside it as stations.json.

    `point_source_id` is 1 + the origin's index (an extra dimension where there are more than 65,535), so that
    `read_las` gives the same rays back. The bytes depend on the scan alone.
    """
    p = Path(path)
    header = laspy.LasHeader(point_format=6 if scan.rgb is None else 7, version="1.4")
    header.scales, header.offsets = np.full(3, _STEP), scan.world.origin.astype(np.float64)
    header.generating_software, header.system_identifier = _OWN, ""
    header.creation_date = date(2000, 1, 1)
    if scan.world.crs is not None:
        header.add_crs(parse_crs(scan.world.crs, str(p)))
    wide = len(scan.origins) > 65535
    if wide:
        header.add_extra_dim(laspy.ExtraBytesParams(_RAY, np.int32))
    with (
        whole_file(p) as temporary,
        open(temporary, "wb") as f,
        laspy.open(f, mode="w", header=header, do_compress=p.suffix.lower() == ".laz", closefd=False) as out,
    ):
        for start in range(0, len(scan), CHUNK):
            out.write_points(_record(header, scan, slice(start, start + CHUNK), wide))
    beside = p.with_name(p.name + ".stations.json")
    if scan.has_origins:
        sidecar.write_stations(beside, scan, first=0 if wide else 1)
    else:
        beside.unlink(missing_ok=True)
    return p


def _record(header: Any, scan: Scan, rows: slice, wide: bool) -> Any:
    """One chunk of a scan as a LAS point record."""
    xyz = scan.xyz[rows]
    r = laspy.ScaleAwarePointRecord.zeros(len(xyz), header=header)
    steps = np.rint(xyz / _STEP).astype(np.int64)
    if np.abs(steps).max(initial=0) >= 2**31:
        raise FileError(
            scan.name, "spans more than 400 km and does not fit a LAS file", "split it", code="I107"
        )
    r.X, r.Y, r.Z = steps.T.astype(np.int32)
    index = scan.origin_index[rows]
    if wide:
        r[_RAY] = index
    else:
        r.point_source_id = (index + 1).astype(np.uint16)
    if scan.intensity is not None:
        r.intensity = np.rint(scan.intensity[rows] * 65535.0).astype(np.uint16)
    if scan.rgb is not None:
        r.red, r.green, r.blue = (scan.rgb[rows].astype(np.uint16) * 257).T
    if scan.time is not None:
        r.gps_time = scan.time[rows]
    r.return_number = np.ones(len(xyz), np.uint8) if scan.return_number is None else scan.return_number[rows]
    r.number_of_returns = (
        np.ones(len(xyz), np.uint8) if scan.return_count is None else scan.return_count[rows]
    )
    return r
