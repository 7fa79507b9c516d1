"""JPEG files with an EXIF block: focal length, place and viewing direction (EXIF 2.32, TIFF 6.0)."""

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array
from frontage.io.files import whole_file

_SIZE = {2: 1, 3: 2, 4: 4, 5: 8, 1: 1, 7: 1}  # bytes per value of a TIFF type
_EXIF, _GPS = 0x8769, 0x8825  # pointers to the sub-directories
_HEADER = 8  # bytes of a TIFF header

Entry = tuple[int, int, bytes]
"""Tag, TIFF type, packed values."""


@dataclass(frozen=True)
class Exif:
    """What a camera knows of a shot. Angles in degrees, heights in m; None = not written.

    focal_length mm and its equivalent on 35 mm film; heading clockwise from true north;
    position (latitude, longitude, height above sea)
    """

    make: str
    model: str
    focal_length: float
    focal_length_35mm: int
    position: tuple[float, float, float] | None = None
    heading: float | None = None
    position_error: float | None = None


def write_jpeg(path: str | Path, rgb: Array, exif: Exif, quality: int = 90) -> Path:
    """Write pixels (h, w, 3) uint8 RGB as JPEG with an EXIF block; the bytes depend on both alone.

    Raises FileError (cannot be encoded or written).
    """
    p = Path(path)
    options = [cv2.IMWRITE_JPEG_QUALITY, quality]
    done, data = cv2.imencode(".jpg", np.ascontiguousarray(rgb[..., ::-1]), options)
    if not done:
        raise FileError(p, f"a picture of {rgb.shape[1]} x {rgb.shape[0]} px cannot be a JPEG")
    body = b"Exif\0\0" + exif_block(exif)
    jpeg = data.tobytes()
    with whole_file(p) as temporary:
        temporary.write_bytes(jpeg[:2] + b"\xff\xe1" + struct.pack(">H", len(body) + 2) + body + jpeg[2:])
    return p


def exif_block(exif: Exif) -> bytes:
    """The little-endian TIFF structure of an EXIF segment."""
    main: list[Entry] = [
        _text(0x010F, exif.make),
        _text(0x0110, exif.model),
        _short(0x0112, 1),
        (_EXIF, 4, b"\0" * 4),
    ]
    shot: list[Entry] = [
        (0x9000, 7, b"0232"),
        _rationals(0x920A, exif.focal_length),
        _short(0xA405, exif.focal_length_35mm),
    ]
    gps = _gps(exif)
    if gps:
        main.append((_GPS, 4, b"\0" * 4))
    start = _HEADER + _length(main)
    pointers = {_EXIF: start, _GPS: start + _length(shot)}
    main = [(t, k, struct.pack("<I", pointers[t]) if t in pointers else v) for t, k, v in main]
    parts = [_directory(main, _HEADER), _directory(shot, pointers[_EXIF])]
    if gps:
        parts.append(_directory(gps, pointers[_GPS]))
    return b"II*\0" + struct.pack("<I", _HEADER) + b"".join(parts)


def _gps(exif: Exif) -> list[Entry]:
    """The GPS directory; empty when neither place nor direction is known."""
    out: list[Entry] = []
    if exif.position is not None:
        latitude, longitude, height = exif.position
        out += [
            _text(1, "N" if latitude >= 0 else "S"),
            _rationals(2, *_sexagesimal(latitude)),
            _text(3, "E" if longitude >= 0 else "W"),
            _rationals(4, *_sexagesimal(longitude)),
            (5, 1, bytes([int(height < 0)])),
            _rationals(6, abs(height)),
        ]
    if exif.heading is not None:
        out += [_text(0x10, "T"), _rationals(0x11, exif.heading % 360.0)]
    if exif.position_error is not None:
        out.append(_rationals(0x1F, exif.position_error))
    return [(0, 1, bytes([2, 3, 0, 0])), *out] if out else []


def _sexagesimal(angle: float) -> tuple[float, float, float]:
    """Degrees, minutes and seconds of the absolute angle in degrees."""
    minutes, seconds = divmod(abs(angle) * 3600.0, 60.0)
    degrees, minutes = divmod(minutes, 60.0)
    return degrees, minutes, seconds


def _text(tag: int, value: str) -> Entry:
    return tag, 2, value.encode("ascii") + b"\0"


def _short(tag: int, value: int) -> Entry:
    return tag, 3, struct.pack("<H", value)


def _rationals(tag: int, *values: float) -> Entry:
    """Fractions with a denominator of 100000: seconds of arc to 0.3 mm on the ground."""
    return tag, 5, b"".join(struct.pack("<II", round(v * 100_000), 100_000) for v in values)


def _length(entries: Sequence[Entry]) -> int:
    """Bytes of a directory with the values that lie behind it."""
    return 6 + 12 * len(entries) + sum(_padded(v) for _, _, v in entries if len(v) > 4)


def _padded(value: bytes) -> int:
    return len(value) + len(value) % 2


def _directory(entries: Sequence[Entry], start: int) -> bytes:
    """A directory at byte `start` of the block: sorted entries, no next one, then the long values."""
    at = start + 6 + 12 * len(entries)
    table, values = struct.pack("<H", len(entries)), b""
    for tag, kind, value in sorted(entries):
        count = len(value) // _SIZE[kind]
        table += struct.pack("<HHI", tag, kind, count)
        if len(value) <= 4:
            table += value.ljust(4, b"\0")
        else:
            table += struct.pack("<I", at + len(values))
            values += value.ljust(_padded(value), b"\0")
    return table + struct.pack("<I", 0) + values
