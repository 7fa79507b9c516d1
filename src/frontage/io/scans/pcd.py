"""PCD 0.7, the point clouds of the Point Cloud Library: ascii, binary, and binary compressed with LZF."""

from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array, Float
from frontage.io.columns import PointColumns, to_scan
from frontage.io.files import reading, require_file, require_length
from frontage.io.scans.precision import require_fine_steps
from frontage.io.scans.request import ScanRequest
from frontage.model import Scan

_KINDS = {"F": "f", "I": "i", "U": "u"}
_SIZES = {"F": (4, 8), "I": (1, 2, 4, 8), "U": (1, 2, 4, 8)}
_HEAD_BYTES, _HEAD_LINES = 10_000, 50  # of a line and of a header; longer ones are damaged
_FEW_POINTS = 10_000  # enough to decide where a file lies
_NO_VIEWPOINT = (0.0, 0.0, 0.0)  # what writers state that know none
_SINGLE = frozenset({"x", "y", "z", "r", "g", "b", "rgb", "rgba"})  # fields that hold one number per point
_INTENSITY = ("intensity", "reflectivity", "reflectance", "remission", "i")
_TIME = ("gps_time", "timestamp", "time", "t")
_LONGEST_RATIO = 132  # a copy of LZF makes at most 264 bytes of two, so no file unpacks to more than that


@dataclass(frozen=True)
class _Header:
    """Record of a point, number of points, how they are stored, and where the scanner stood (3,) or None."""

    record: "np.dtype[np.void]"
    count: int
    data: str
    viewpoint: Float | None


def read_pcd(path: str | Path, request: ScanRequest) -> list[Scan]:
    """Read a PCD file as one scan: x y z, and colour, intensity and time where named.

    The viewpoint of the file is the origin of all points, unless it is the default (0, 0, 0). Points without
    coordinates are left out.

    Raises FileError (missing, truncated, corrupt, no points), CrsError.
    """
    p = require_file(path)
    with reading(p, "PCD"), open(p, "rb") as f:
        header = _header(f)
        rows = _rows(f, header, p)
    names = {name.lower(): name for name in rows.dtype.names or ()}
    xyz = np.column_stack([rows[names[axis]].astype(np.float64) for axis in "xyz"])
    seen = xyz[np.isfinite(xyz).all(1)]
    if not len(seen):
        raise FileError(p, "holds no points", "export it again", code="I105")
    place = request.placement.place(None, seen[:: max(1, len(seen) // _FEW_POINTS)])
    c = PointColumns(p.name, place.to_local(xyz))
    single = any(rows.dtype[names[axis]] == np.float32 for axis in "xyz")
    require_fine_steps(p, seen, place.to_local, c.notes, single=single)
    for field, known in (("intensity", _INTENSITY), ("time", _TIME)):
        found = next((names[k] for k in known if k in names and rows.dtype[names[k]].shape == ()), None)
        setattr(c, field, None if found is None else np.ascontiguousarray(rows[found]))
    c.rgb = _colours(rows, names)
    if header.viewpoint is not None:
        c.origins = place.to_local(header.viewpoint[None])
        c.origin_index = np.zeros(len(xyz), np.int32)
    return [to_scan(p, c, place)]


def _header(f: BinaryIO) -> _Header:
    """Read the header. Raises ValueError when it is not that of a PCD file with x, y and z."""
    stated: dict[str, list[str]] = {}
    for _ in range(_HEAD_LINES):
        line = f.readline(_HEAD_BYTES).decode("ascii", "replace").split()
        if line and not line[0].startswith("#"):
            stated[line[0].upper()] = line[1:]
            if line[0].upper() == "DATA":
                break
    else:
        raise ValueError("its header has no line DATA")
    names = stated.get("FIELDS", stated.get("COLUMNS", []))
    if not {"x", "y", "z"} <= {name.lower() for name in names}:
        raise ValueError("its points have no x, y, z")
    counts = [int(v) for v in stated.get("COUNT", ["1"] * len(names))]
    columns = list(zip(names, stated["TYPE"], (int(v) for v in stated["SIZE"]), counts, strict=True))
    if any(size not in _SIZES[kind] or count < 0 for _, kind, size, count in columns):
        raise ValueError("its fields have sizes that no number has")
    if any(count != 1 and name.lower() in _SINGLE for name, _, _, count in columns):
        raise ValueError("its points have fields of several numbers where one is meant")
    unique = [f"{n}#{k}" if n == "_" or n in names[:k] else n for k, n in enumerate(names)]
    record = [
        (name, f"<{_KINDS[kind]}{size}", () if number == 1 else (number,))
        for name, (_, kind, size, number) in zip(unique, columns, strict=True)
    ]
    count = (
        int(stated["POINTS"][0]) if "POINTS" in stated else int(stated["WIDTH"][0]) * int(stated["HEIGHT"][0])
    )
    where = tuple(float(v) for v in stated.get("VIEWPOINT", [])[:3])
    known = len(where) == 3 and where != _NO_VIEWPOINT and bool(np.isfinite(where).all())
    return _Header(np.dtype(record), count, stated["DATA"][0].lower(), np.array(where) if known else None)


def _rows(f: BinaryIO, header: _Header, path: Path) -> Array:
    """Read the points. Raises FileError and ValueError for a file that does not hold what it states."""
    has, size = path.stat().st_size - f.tell(), header.record.itemsize
    if header.data == "ascii":
        require_length(path, f"{header.count} points", 2 * header.count, has + 1)
        return _ascii(f, header)
    if header.data == "binary":
        require_length(path, f"{header.count} points", header.count * size, has)
        return np.fromfile(f, header.record, header.count)
    if header.data != "binary_compressed":
        raise ValueError(f"its data are {header.data!r}, which no version of PCD has")
    packed, whole = np.fromfile(f, "<u4", 2).tolist()
    require_length(path, f"{packed} compressed bytes", packed, has - 8)
    require_length(path, f"{whole} bytes", whole, packed * _LONGEST_RATIO)
    if whole != header.count * size:
        raise ValueError(f"{whole} bytes do not hold {header.count} points")
    data, rows = _unpacked(f.read(packed), whole), np.empty(header.count, header.record)
    begin = 0
    for name in header.record.names or ():  # one field after the other
        column = header.record[name]
        end = begin + header.count * column.itemsize
        rows[name] = np.frombuffer(data[begin:end], column.base).reshape(header.count, *column.shape)
        begin = end
    return rows


def _ascii(f: BinaryIO, header: _Header) -> Array:
    columns = [(name, header.record[name]) for name in header.record.names or ()]
    width = sum(int(np.prod(kind.shape)) for _, kind in columns)
    table: Array = (
        np.loadtxt(f, np.float64, max_rows=header.count, ndmin=2) if header.count else np.empty((0, width))
    )
    if table.shape != (header.count, width):
        raise ValueError(f"it states {header.count} points with {width} numbers each and holds {table.shape}")
    rows, first = np.empty(header.count, header.record), 0
    for name, kind in columns:
        last = first + int(np.prod(kind.shape))
        rows[name] = table[:, first:last].reshape(header.count, *kind.shape)
        first = last
    return rows


def _unpacked(packed: bytes, size: int) -> bytes:
    """Unpack LZF: runs of literal bytes, and copies of what was unpacked before. Raises ValueError."""
    out, at = bytearray(), 0
    while at < len(packed) and len(out) <= size:
        control, at = packed[at], at + 1
        if control < 32:
            out += packed[at : at + control + 1]
            at += control + 1
            continue
        length = control >> 5
        if length == 7:
            length, at = length + packed[at], at + 1
        back, at, length = ((control & 31) << 8) + packed[at] + 1, at + 1, length + 2
        if back > len(out):
            raise ValueError("its compressed data are damaged")
        piece = out[-back:][:length]
        out += (piece * (length // len(piece) + 1))[:length]
    if len(out) != size:
        raise ValueError("its compressed data are damaged")
    return bytes(out)


def _colours(rows: Array, names: dict[str, str]) -> Array | None:
    """Return colours (n, 3): three fields, or one number that packs them as 0xRRGGBB."""
    if {"r", "g", "b"} <= set(names):
        return np.column_stack([rows[names[k]] for k in "rgb"])
    packed = next((names[k] for k in ("rgb", "rgba") if k in names), None)
    if packed is None or rows.dtype[packed].itemsize != 4:
        return None
    bits = np.ascontiguousarray(rows[packed]).view("<u4")
    return np.column_stack([(bits >> shift & 255).astype(np.uint8) for shift in (16, 8, 0)])
