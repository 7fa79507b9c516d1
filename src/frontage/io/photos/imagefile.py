"""Picture files: their size and EXIF orientation without decoding, and how pixels are turned upright.

Pillow reads the headers; `decoder` decodes the pixels.
"""

import struct
import warnings
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import ExifTags, Image
from PIL.JpegImagePlugin import JpegImageFile
from PIL.PngImagePlugin import PngImageFile
from PIL.TiffImagePlugin import TiffImageFile

from frontage.errors import FileError
from frontage.geometry.arrays import Array
from frontage.io.files import reading, require_file

SUFFIXES = (".jpg", ".jpeg", ".png", ".tif", ".tiff")
"""The suffixes of the picture files that can be read."""

USE_WHOLE = "use a complete JPEG, PNG or TIFF file"
"""What to do about a picture that cannot be used."""

_JPEG, _PNG = b"\xff\xd8", b"\x89PNG\r\n\x1a\n"
_TIFF = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")  # the last two are BigTIFF
_MOST_PIXELS = 2**30  # OpenCV decodes no larger picture (CV_IO_MAX_IMAGE_PIXELS)
_START_OF_SCAN, _END_OF_IMAGE = 0xDA, b"\xff\xd9"  # JPEG markers
_END_CHUNK = b"IEND"  # of a PNG
_STRIPS, _TILES = (273, 279), (324, 325)  # TIFF tags: offsets and byte counts


@dataclass(frozen=True)
class ImageHeader:
    """Width and height in pixels as stored, and the EXIF orientation 1..8 (1 = stored upright)."""

    width: int
    height: int
    orientation: int = 1


def image_header(path: str | Path) -> ImageHeader:
    """Read the size and orientation of a JPEG, PNG or TIFF picture without decoding it.

    Raises FileError when the file is missing, empty, truncated, too large to be decoded, or not a picture.
    """
    p = require_file(path)
    return parse_header(p.read_bytes(), p)


_DEFLATE_RATIO = 1032  # of the best compression that deflate allows (RFC 1951)
_BITS = 8  # pixels of one bit in a byte


def parse_header(data: bytes, path: str | Path) -> ImageHeader:
    """`image_header` of the bytes of a picture; `path` stands in the messages. Raises FileError."""
    with reading(path, "picture", USE_WHOLE):
        picture = opened(data)
        width, height = picture.size
        if width * height > _MOST_PIXELS:
            problem = f"claims {width} x {height} px; at most {_MOST_PIXELS} px can be decoded"
            raise FileError(path, problem, "use a smaller picture", code="I103")
        if picture.format == "PNG" and width * height > _DEFLATE_RATIO * _BITS * len(data):
            problem = f"claims {width} x {height} px, more than its {len(data)} bytes can hold"
            raise FileError(path, problem, "copy it again", code="I103")
        if not _is_complete(data, picture):
            problem = f"the {picture.format} picture is truncated"
            raise FileError(path, problem, "copy it again", code="I103")
        return ImageHeader(width, height, _orientation(picture))


def opened(data: bytes) -> Image.Image:
    """The picture with its header read. Raises what Pillow raises, and ValueError for other kinds of files.

    The plugins are called directly: `Image.open` would refuse more than twice `Image.MAX_IMAGE_PIXELS`, a
    limit of the whole process that stitched photos pass.
    """
    stream = BytesIO(data)
    if data.startswith(_JPEG):
        return JpegImageFile(stream)
    if data.startswith(_PNG):
        return PngImageFile(stream)
    if data.startswith(_TIFF):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # about tags; the pixels are judged when decoded
            return TiffImageFile(stream)
    raise ValueError("it is neither JPEG, PNG nor TIFF")


def _orientation(picture: Image.Image) -> int:
    """The EXIF orientation; 1 where the picture states none, or a wrong one."""
    try:
        value = picture.getexif().get(ExifTags.Base.Orientation, 1)
    except (SyntaxError, ValueError, OSError, struct.error):  # a damaged EXIF block does not matter here
        return 1
    return value if isinstance(value, int) and 1 <= value <= 8 else 1


def _is_complete(data: bytes, picture: Image.Image) -> bool:
    """Whether a JPEG or PNG has its end marker, and a TIFF all of its strips or tiles.

    Decoders would fill a truncated picture with grey. The pixel data of a JPEG never contains the marker,
    but a preview in its header may: the header is skipped.
    """
    if isinstance(picture, TiffImageFile):
        return all(start + size <= len(data) for start, size in tiff_parts(picture))
    if data.startswith(_PNG):
        return _END_CHUNK in data[-16:]
    at = 2
    while data[at + 1] != _START_OF_SCAN:
        is_fill_byte = data[at + 1] == 0xFF
        at += 1 if is_fill_byte else 2 + int(struct.unpack_from(">H", data, at + 2)[0])
    return _END_OF_IMAGE in data[at:]


def upright(rgb: Array, orientation: int) -> Array:
    """Apply an EXIF orientation 1..8 to pixels (h, w, 3)."""
    quarter_turns = {3: 2, 4: 2, 5: 3, 6: 3, 7: 3, 8: 1}.get(orientation, 0)  # counter-clockwise
    turned = np.rot90(rgb, quarter_turns)
    if orientation in (2, 4, 5, 7):
        turned = turned[:, ::-1]
    return np.ascontiguousarray(turned)


def tiff_parts(picture: TiffImageFile) -> list[tuple[int, int]]:
    """Where the strips or tiles of a TIFF picture begin in the file, and their sizes in bytes."""
    parts = [_STRIPS, _TILES][_TILES[0] in picture.tag_v2]
    starts, sizes = (picture.tag_v2.get(tag, ()) for tag in parts)
    return list(zip(starts, sizes, strict=True)) if len(starts) == len(sizes) else []
