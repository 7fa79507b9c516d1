"""Checks of a LAS header against the size of its file, before any count in it is believed.

Offsets are those of the LAS 1.4 R15 specification (ASPRS), table 3, and of LASzip's chunk table.
"""

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import lazrs
import numpy as np

from frontage.errors import FileError
from frontage.io.files import require_length

_OLD_HEADER = 227  # bytes of a header before version 1.3, the shortest one
_NEW_HEADER = 375  # bytes of a header of version 1.4
_VLR, _EVLR = 54, 60  # bytes in front of the data of a variable length record
_COMPRESSED = 0x80  # bit of the point format that LASzip sets
_LASZIP = (b"laszip encoded", 22204)
_LEAST_LAYERED = 6  # point formats from here on are compressed in layers, which count their points


@dataclass(frozen=True)
class _Header:
    """What the checks need: sizes in bytes, positions from the start of the file."""

    size: int
    version: tuple[int, int]
    vlrs: int
    points_at: int
    format: int
    record: int
    count: int
    evlrs: int
    evlrs_at: int
    waveforms_at: int


def check_las(path: Path) -> None:
    """Check the header, the records and the number of points of a LAS or LAZ file.

    Raises FileError when the header states more than the file holds, fewer points than it holds, or a scale
    that is not a positive number. Raises ValueError when it is not LAS.
    """
    has = path.stat().st_size
    with open(path, "rb") as f:
        head = f.read(_NEW_HEADER)
        if head[:4] != b"LASF" or len(head) < _OLD_HEADER:
            raise ValueError("it does not begin with a LAS header")
        h = _parsed(head)
        _check_scales(path, head)
        if h.size < _OLD_HEADER:
            raise ValueError(f"its header has {h.size} bytes, fewer than any version of LAS")
        require_length(path, f"points at byte {h.points_at}", h.points_at, has)
        laszip = _check_vlrs(f, path, h)
        _check_evlrs(f, path, h, has)
        if h.format & _COMPRESSED:
            _check_chunks(f, path, h, laszip, has)
        else:
            _check_count(f, path, h, has)


def _parsed(head: bytes) -> _Header:
    points_at, vlrs, kind, record, count = struct.unpack_from("<IIBHI", head, 96)
    version = (head[24], head[25])
    evlrs = evlrs_at = waveforms_at = 0
    if version >= (1, 3) and len(head) >= _OLD_HEADER + 8:
        (waveforms_at,) = struct.unpack_from("<Q", head, 227)
    if version >= (1, 4) and len(head) >= _NEW_HEADER:
        evlrs_at, evlrs, count = struct.unpack_from("<QIQ", head, 235)
    (size,) = struct.unpack_from("<H", head, 94)
    return _Header(size, version, vlrs, points_at, kind, record, count, evlrs, evlrs_at, waveforms_at)


def _check_scales(path: Path, head: bytes) -> None:
    numbers = np.frombuffer(head, "<f8", 6, 131)
    scales, offsets = numbers[:3], numbers[3:]
    if not (np.isfinite(numbers).all() and (scales > 0).all()):
        shown = ", ".join(f"{v:g}" for v in (*scales, *offsets))
        raise FileError(
            path,
            f"damaged: the scales and offsets in its header ({shown}) are not usable numbers",
            "export it again; scales are positive, such as 0.001",
            code="I103",
        )


def _check_vlrs(f: BinaryIO, path: Path, h: _Header) -> bytes:
    """Check that the records lie in front of the points; returns LASzip's, empty where there is none."""
    laszip, at = b"", h.size
    require_length(path, f"{h.vlrs} variable length records", h.vlrs * _VLR, h.points_at - h.size)
    for _ in range(h.vlrs):
        f.seek(at)
        user, number, length = struct.unpack_from("<16sHH", f.read(_VLR), 2)
        if (user.rstrip(b"\0"), number) == _LASZIP:
            laszip = f.read(length)
        at += _VLR + length
        require_length(path, "a variable length record", at, h.points_at)
    return laszip


def _check_evlrs(f: BinaryIO, path: Path, h: _Header, has: int) -> None:
    at = h.evlrs_at
    if h.evlrs:
        require_length(path, f"{h.evlrs} extended records", at + h.evlrs * _EVLR, has)
    for _ in range(h.evlrs):
        f.seek(at)
        (length,) = struct.unpack_from("<Q", f.read(_EVLR).ljust(_EVLR, b"\0"), 20)
        at += _EVLR + length
        require_length(path, "an extended record", at, has)


def _check_count(f: BinaryIO, path: Path, h: _Header, has: int) -> None:
    """Compare the number of points with the room for them; zeros behind the points are padding."""
    ends = [p for p in (h.evlrs_at if h.evlrs else 0, h.waveforms_at) if h.points_at < p <= has]
    end = min([*ends, has])
    require_length(path, f"{h.count} points", h.count * h.record, end - h.points_at)
    room = (end - h.points_at) // max(h.record, 1)
    if room > h.count > 0:
        f.seek(h.points_at + h.count * h.record)
        if f.read(h.record).strip(b"\0"):
            raise _fewer(path, h.count, room)


def _check_chunks(f: BinaryIO, path: Path, h: _Header, laszip: bytes, has: int) -> None:
    """Compare the number of points with LASzip's chunk table; without a table there is nothing to compare."""
    f.seek(h.points_at)
    (table_at,) = struct.unpack("<q", f.read(8).ljust(8, b"\xff"))
    if not laszip or not h.points_at < table_at <= has - 8:
        return
    f.seek(table_at)
    _, chunks = struct.unpack("<II", f.read(8))
    require_length(path, f"{chunks} chunks of points", chunks, table_at - h.points_at)
    f.seek(h.points_at)
    vlr = lazrs.LazVlr(laszip)
    table = lazrs.read_chunk_table(f, vlr)
    if not table:
        return
    most = sum(points for points, _ in table)
    last, position = table[-1][0], h.points_at + 8 + sum(size for _, size in table[:-1])
    if vlr.uses_variable_size_chunks():
        last = 1
    elif h.format & 0x3F >= _LEAST_LAYERED:  # such a chunk begins with one whole point and its count
        f.seek(position + h.record)
        (held,) = struct.unpack("<I", f.read(4).ljust(4, b"\0"))
        most, last = most - last + held, 1
    require_length(path, f"{h.count} points", h.count, most)
    if 0 < h.count <= most - last:
        raise _fewer(path, h.count, most - last + 1)


def _fewer(path: Path, stated: int, held: int) -> FileError:
    return FileError(
        path,
        f"damaged: its header states {stated} points, but the file holds at least {held}",
        "export or copy it again",
        code="I103",
    )
