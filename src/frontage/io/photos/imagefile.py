"""Picture files: size and EXIF orientation without decoding, pixels as stored."""

import struct
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array
from frontage.io.files import reading, require_file

_SIZE_MARKERS = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}  # start of frame, of any JPEG process
_PNG = b"\x89PNG\r\n\x1a\n"
_TIFF = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_ORIENTATION = 0x0112  # EXIF tag


@dataclass(frozen=True)
class ImageHeader:
    """Stored width and height in pixels, EXIF orientation 1..8 (1 = upright as stored)."""

    width: int
    height: int
    orientation: int = 1


def image_header(path: str | Path) -> ImageHeader:
    """Size and orientation of a JPEG, PNG or TIFF picture, read from its first bytes; the size as stored.

    Raises FileError (missing, empty, not a picture, truncated).
    """
    p = require_file(path)
    with reading(p, "picture", "use a whole JPEG, PNG or TIFF"):
        data = p.read_bytes()
        return parse_header(data, p)


def parse_header(data: bytes, name: object) -> ImageHeader:
    """`image_header` of bytes. Raises FileError or ValueError."""
    if data[:2] == b"\xff\xd8":
        return _jpeg(data, name)
    if data[:8] == _PNG:
        if b"IEND" not in data[-16:]:
            raise FileError(name, "truncated PNG picture", "copy it again", code="I103")
        return ImageHeader(*struct.unpack_from(">II", data, 16))
    if data[:4] in _TIFF:
        import io

        import tifffile

        with tifffile.TiffFile(io.BytesIO(data)) as tif:
            page = tif.pages[0]
            tag = page.tags.get(_ORIENTATION)
            return ImageHeader(int(page.imagewidth), int(page.imagelength), int(tag.value) if tag else 1)
    raise ValueError("neither JPEG, PNG nor TIFF")


def _jpeg(data: bytes, name: object) -> ImageHeader:
    """Walk the segments up to the picture data; the end marker must follow it (0xFF is stuffed inside)."""
    at, size, orientation = 2, None, 1
    while at + 4 <= len(data):
        if data[at] != 0xFF:
            raise ValueError("damaged JPEG segments")
        marker, length = data[at + 1], struct.unpack_from(">H", data, at + 2)[0]
        if marker == 0xFF:
            at += 1
            continue
        if marker in _SIZE_MARKERS:
            height, width = struct.unpack_from(">HH", data, at + 5)
            size = (width, height)
        elif marker == 0xE1 and data[at + 4 : at + 10] == b"Exif\0\0":
            orientation = _exif_orientation(data[at + 10 : at + 2 + length])
        elif marker == 0xDA:
            break
        at += 2 + length
    if size is None:
        raise ValueError("a JPEG without a size")
    if b"\xff\xd9" not in data[at:]:
        raise FileError(name, "truncated JPEG picture", "copy it again", code="I103")
    return ImageHeader(*size, orientation)


def _exif_orientation(tiff: bytes) -> int:
    """Orientation of an EXIF block; 1 where it has none or is damaged."""
    order = {b"II": "<", b"MM": ">"}.get(tiff[:2])
    try:
        if order is None:
            return 1
        (at,) = struct.unpack_from(order + "I", tiff, 4)
        (count,) = struct.unpack_from(order + "H", tiff, at)
        for k in range(count):
            tag, _, _, value = struct.unpack_from(order + "HHIH", tiff, at + 2 + 12 * k)
            if tag == _ORIENTATION:
                return int(value) if 1 <= value <= 8 else 1
    except struct.error:
        pass
    return 1


def decode(data: bytes, name: object) -> Array:
    """Pixels (h, w, 3) uint8 RGB as stored, EXIF orientation not applied; 16-bit pictures become 8-bit.

    Raises FileError when the picture cannot be decoded.
    """
    flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    bgr = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
    if bgr is None:
        raise FileError(name, "the picture cannot be decoded", "use a whole JPEG, PNG or TIFF", code="I103")
    rgb: Array = cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB)
    return rgb


def upright(rgb: Array, orientation: int) -> Array:
    """Apply an EXIF orientation 1..8 to pixels (h, w, 3)."""
    k = {3: 2, 4: 2, 5: 3, 6: 3, 7: 3, 8: 1}.get(orientation, 0)  # quarter turns counter-clockwise
    turned = np.rot90(rgb, k)
    if orientation in (2, 4, 5, 7):
        turned = turned[:, ::-1]
    return np.ascontiguousarray(turned)
