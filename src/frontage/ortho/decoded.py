"""The decoded photos of one facade: every photo is decoded once, and memory is bounded.

Several steps look at the same photo: the comparison with other pictures, its depth, its light, and at last
the painting. Up to half a gigabyte of pixels stays in memory; further photos go to scratch files, from which
only the parts that a step looks at are read.
"""

import tempfile

import numpy as np

from frontage.geometry.arrays import Array
from frontage.ortho.surface import ImageOf
from frontage.raster.tiles import IN_MEMORY


class DecodedPhotos:
    """Pictures by the id of their photo, (h, w, 3) uint8, each decoded when it is first asked for."""

    def __init__(self, decode: ImageOf, most_bytes: int = IN_MEMORY) -> None:
        self._decode = decode
        self._left = most_bytes
        self._kept: dict[str, Array] = {}

    def __call__(self, photo: str) -> Array:
        """Return the picture of a photo; callers must not write to it."""
        if photo in self._kept:
            return self._kept[photo]
        image = self._decode(photo)
        self._left -= image.nbytes
        self._kept[photo] = image if self._left >= 0 else _on_disk(image)
        return image


def _on_disk(image: Array) -> Array:
    """Writes a picture to a scratch file and maps it anew, so that only what is read again takes memory."""
    with tempfile.TemporaryFile(prefix="frontage-photo-") as scratch:
        written: Array = np.memmap(scratch, image.dtype, "w+", shape=image.shape)
        written[:] = image
        del written
        band: Array = np.memmap(scratch, image.dtype, "r", shape=image.shape)
    return band
