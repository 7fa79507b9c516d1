"""Writing LAS 1.4 and LAZ: steps of 0.1 mm, the CRS as WKT, and the stations in a JSON file beside it."""

from datetime import date, datetime, timedelta
from pathlib import Path
from typing import Any

import laspy
import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Float
from frontage.io.crs import parse_crs
from frontage.io.files import whole_file
from frontage.io.scans.las import CHUNK_POINTS, ORIGIN_INDEX, OWN_SOFTWARE
from frontage.io.scans.stations import write_stations
from frontage.model import Scan

_STEP_M = 0.0001  # coordinates are stored in tenths of a millimetre
_MOST_SOURCES = 65535  # that a point_source_id can count


BUILDING_CLASS = 6
"""The class "building" of the American Society for Photogrammetry and Remote Sensing."""

_DATE_AT, _NO_DATE = 90, b"\0\0\0\0"  # day of the year and year in a LAS header
_WEEK_S = 604_800.0
_LAST_S = 3e9  # in the year 2106: larger numbers are no times in this system
_GPS_EPOCH, _STANDARD_SHIFT_S = datetime(1980, 1, 6), 1e9  # adjusted standard GPS time counts from later


def write_las(path: str | Path, scan: Scan, classification: int = 0) -> Path:
    """Write a scan as LAS 1.4, compressed when the suffix is .laz; equal scans give equal bytes.

    `point_source_id` is 1 + the index of the point's origin; with more than 65,535 origins an extra dimension
    holds the index. `<file>.stations.json` holds the origins, so that `read_las` gives the same rays back.

    classification  of all points; 0 = none. The date in the header is that of the last point if its times are
                    adjusted standard GPS times, which the header then says; else the header has no date.

    Raises FileError when the scan does not fit the format or the file cannot be written.
    """
    p = Path(path)
    header = laspy.LasHeader(point_format=6 if scan.rgb is None else 7, version="1.4")
    header.scales, header.offsets = np.full(3, _STEP_M), scan.world.origin.astype(np.float64)
    header.generating_software, header.system_identifier = OWN_SOFTWARE, ""
    measured = _date(scan.time)
    header.creation_date = measured or date(2000, 1, 1)  # not today's, which would change the bytes
    if measured is not None:
        header.global_encoding.gps_time_type = laspy.header.GpsTimeType.STANDARD
    if scan.world.crs is not None:
        header.add_crs(parse_crs(scan.world.crs, str(p)))
    wide = len(scan.origins) > _MOST_SOURCES
    if wide:
        header.add_extra_dim(laspy.ExtraBytesParams(ORIGIN_INDEX, np.int32))
    packed = p.suffix.lower() == ".laz"
    with whole_file(p) as temporary, open(temporary, "wb") as f:
        with laspy.open(f, mode="w", header=header, do_compress=packed, closefd=False) as out:
            for start in range(0, len(scan), CHUNK_POINTS):
                record = _record(header, scan, slice(start, start + CHUNK_POINTS), wide)
                record.classification[:] = classification
                out.write_points(record)
        if measured is None:
            f.seek(_DATE_AT)
            f.write(_NO_DATE)
    beside = p.with_name(p.name + ".stations.json")
    if scan.has_origins:
        write_stations(beside, scan, first=0 if wide else 1)
    else:
        beside.unlink(missing_ok=True)
    return p


def _date(times: Float | None) -> date | None:
    """The day of the last of some times, None where they are missing or may be seconds of a week."""
    known = np.empty(0) if times is None else times[np.isfinite(times)]
    if not len(known) or not _WEEK_S < known.max() <= _LAST_S:
        return None
    return (_GPS_EPOCH + timedelta(seconds=float(known.max()) + _STANDARD_SHIFT_S)).date()


def _record(header: Any, scan: Scan, rows: slice, wide: bool) -> Any:
    """One chunk of a scan as a LAS point record."""
    xyz = scan.xyz[rows]
    r = laspy.ScaleAwarePointRecord.zeros(len(xyz), header=header)
    steps = np.rint(xyz / _STEP_M).astype(np.int64)
    if np.abs(steps).max(initial=0) >= 2**31:
        raise FileError(
            scan.name, "spans more than 400 km and does not fit into a LAS file", "split it", code="I107"
        )
    r.X, r.Y, r.Z = steps.T.astype(np.int32)
    index = scan.origin_index[rows]
    if wide:
        r[ORIGIN_INDEX] = index
    else:
        r.point_source_id = (index + 1).astype(np.uint16)
    if scan.intensity is not None:
        r.intensity = np.rint(scan.intensity[rows] * 65535.0).astype(np.uint16)
    if scan.rgb is not None:
        r.red, r.green, r.blue = (scan.rgb[rows].astype(np.uint16) * 257).T
    if scan.time is not None:
        r.gps_time = scan.time[rows]
    ones = np.ones(len(xyz), np.uint8)
    r.return_number = ones if scan.return_number is None else scan.return_number[rows]
    r.number_of_returns = ones if scan.return_count is None else scan.return_count[rows]
    return r
