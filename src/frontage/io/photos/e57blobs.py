"""The bytes of a picture that an E57 file embeds."""

from pathlib import Path

import numpy as np

from frontage.errors import FileError
from frontage.io.photos.imagefile import parse_header
from frontage.io.scans.e57 import opened

_BLOBS = ("jpegImage", "pngImage")


def embedded_bytes(path: str | Path, number: int) -> bytes:
    """The JPEG or PNG bytes of picture `number` (from 0) in images2D.

    Raises FileError when the file or the picture is damaged, and MissingExtra without pye57.
    """
    with opened(path) as e57:
        view = e57.root["images2D"][number]["pinholeRepresentation"]
        kind = next((b for b in _BLOBS if view.isDefined(b)), None)
        if kind is None:
            raise FileError(
                path, f"embedded photo {number + 1} has no picture", "export it again", code="I103"
            )
        blob = view[kind]
        data = np.zeros(blob.byteCount(), np.uint8)
        blob.read(data, 0, len(data))
    parse_header(data.tobytes(), path)
    return data.tobytes()
