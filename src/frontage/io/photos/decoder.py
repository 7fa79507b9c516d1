"""The pixels of picture files, decoded by OpenCV; a damaged picture is refused instead of filled with grey.

A decoder that meets damaged data goes on: it fills what is missing with grey and prints a warning to the
standard error of the process, where nobody reads it. OpenCV does not hand these warnings on, and Pillow
suppresses them, so they are read where they are printed.
"""

import contextlib
import os
import re
import tempfile
import threading
import zlib
from collections.abc import Iterator

import cv2
import numpy as np
from PIL.TiffImagePlugin import TiffImageFile

from frontage.errors import FileError
from frontage.geometry.arrays import Array
from frontage.io.photos.imagefile import USE_WHOLE, opened, tiff_parts

_STDERR = 2  # the file descriptor that libjpeg, libpng and libtiff write to
_ONE_AT_A_TIME = threading.Lock()  # a process has one standard error

_COMPRESSION, _DEFLATE = 259, (8, 32946)  # TIFF tag, and its values for deflate

_NATIVE = re.compile(
    r"Corrupt JPEG data|Premature end|Inconsistent progression|libpng |TIFF_(Error|Warning)|^\[ *(WARN|ERROR)"
)
_DAMAGE = re.compile(
    r"Corrupt JPEG data: .*|Premature end of JPEG file.*|Inconsistent progression sequence.*"
    r"|libpng error: .*|TIFF_Error .*|TIFF_Warning (JPEGLib|PackBitsDecode|LZWDecode|ZIPDecode).*"
)
"""What libjpeg (its jerror.h), libpng and libtiff print about damaged data.

Other warnings, such as those about tags that libtiff does not know, concern pictures in order.
"""

_PADDING = re.compile(r"Corrupt JPEG data: (\d+) extraneous bytes before marker 0x(\w\w)")
_HEADERS = re.compile(r"e.|fe|db|dd|c0|c1|c2")
"""JPEG markers that stand before the compressed data: bytes between them damage no pixel."""


def decode(data: bytes, path: object) -> Array:
    """Decode a picture to (h, w, 3) uint8 RGB as stored: the EXIF orientation is not applied.

    Pictures of 16 bits become 8-bit. Raises FileError when the picture cannot be decoded, or when its decoder
    told that the data is damaged.
    """
    flags = cv2.IMREAD_COLOR_RGB | cv2.IMREAD_IGNORE_ORIENTATION
    with _printed() as lines:
        rgb: Array | None = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
    found = next((problem for line in lines if (problem := _damage(line, data))), _deflate_error(data))
    if found is not None:
        raise FileError(path, f"the picture is damaged ({found})", "copy it again", code="I103")
    if rgb is None:
        raise FileError(path, "the picture cannot be decoded", USE_WHOLE, code="I103")
    return rgb


def _damage(line: str, data: bytes) -> str | None:
    """What a line that a decoder printed says about damage; None for anything else."""
    found = _DAMAGE.search(line)
    if found is None:
        return None
    surplus = _PADDING.search(line)
    if surplus is not None:
        count, marker = int(surplus[1]), surplus[2]
        padding = marker == "d9" and _padded(data, count)
        if padding or _HEADERS.fullmatch(marker):
            return None
    return found[0].strip()


def _deflate_error(data: bytes) -> str | None:
    """What is wrong with the strips of a TIFF picture packed by deflate, whose checksums libtiff ignores."""
    with contextlib.suppress(ValueError, SyntaxError):
        picture = opened(data)
        if isinstance(picture, TiffImageFile) and picture.tag_v2.get(_COMPRESSION) in _DEFLATE:
            try:
                for start, size in tiff_parts(picture):
                    zlib.decompress(data[start : start + size])
            except zlib.error as problem:
                return str(problem)
    return None


def _padded(data: bytes, count: int) -> bool:
    """Whether zeros stand before the end of a JPEG picture: some cameras fill it up to a round size."""
    end = data.rfind(b"\xff\xd9")
    return not data[end - count : end].strip(b"\0")


@contextlib.contextmanager
def _printed() -> Iterator[list[str]]:
    """The lines that the block prints to the standard error of the process, filled when the block ends.

    They are held back, except for those of another origin, which are printed afterwards. A process without
    a standard error prints nothing.
    """
    lines: list[str] = []
    with _ONE_AT_A_TIME, contextlib.ExitStack() as stack:
        levels = cv2.utils.logging
        stack.callback(levels.setLogLevel, levels.setLogLevel(levels.LOG_LEVEL_WARNING))
        try:
            saved = os.dup(_STDERR)
        except OSError:
            yield lines
            return
        stack.callback(os.close, saved)
        caught = stack.enter_context(tempfile.TemporaryFile())
        os.dup2(caught.fileno(), _STDERR)
        try:
            yield lines
        finally:
            os.dup2(saved, _STDERR)
            caught.seek(0)
            told = caught.read().splitlines(keepends=True)
            lines += [line.decode("utf-8", "replace").strip() for line in told]
            others = b"".join(raw for raw, line in zip(told, lines, strict=True) if not _NATIVE.search(line))
            if others:
                os.write(_STDERR, others)
