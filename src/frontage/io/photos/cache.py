"""Decoded pictures of this process, kept while there is room: several steps ask for the same photo."""

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable

from frontage.geometry.arrays import Array

_MOST_BYTES = 256 * 2**20


class PixelCache:
    """The pictures that were used last, up to a number of bytes; a larger one is not kept."""

    def __init__(self, most_bytes: int = _MOST_BYTES) -> None:
        self._most_bytes = most_bytes
        self._kept: OrderedDict[Hashable, Array] = OrderedDict()
        self._alone = threading.Lock()

    def get(self, key: Hashable, decode: Callable[[], Array]) -> Array:
        """Return the picture of `key`, decoded now or earlier; callers must not write to it."""
        with self._alone:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key]
        image = decode()
        with self._alone:
            self._kept[key] = image
            while self._kept and sum(kept.nbytes for kept in self._kept.values()) > self._most_bytes:
                self._kept.popitem(last=False)
        return image


PIXELS = PixelCache()
"""The cache of this process."""
