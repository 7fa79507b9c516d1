"""Tiles of rasters, and bands that may be larger than the memory."""

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike

from frontage.geometry.arrays import Array

IN_MEMORY = 1 << 29  # bytes; larger bands are memory maps of an unlinked temporary file


@dataclass(frozen=True)
class Tile:
    """A window of a raster: rows r0..r1, columns c0..c1 (ends excluded)."""

    r0: int
    r1: int
    c0: int
    c1: int

    @property
    def window(self) -> tuple[slice, slice]:
        """The window as slices into the raster."""
        return slice(self.r0, self.r1), slice(self.c0, self.c1)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.r1 - self.r0, self.c1 - self.c0


def tiles(height: int, width: int, size: int, columns: int | None = None) -> Iterator[Tile]:
    """Yields tiles of at most `size` rows and as many (or `columns`) columns that cover a raster by rows."""
    wide = columns or size
    for r in range(0, height, size):
        for c in range(0, width, wide):
            yield Tile(r, min(r + size, height), c, min(c + wide, width))


def allocate(shape: tuple[int, ...], dtype: DTypeLike, fill: float = 0) -> Array:
    """Returns a band filled with `fill`: an array, or above `IN_MEMORY` bytes a memory-mapped file."""
    size = int(np.prod(shape, dtype=np.int64)) * np.dtype(dtype).itemsize
    if size <= IN_MEMORY:
        return np.full(shape, fill, dtype)
    with tempfile.TemporaryFile(prefix="frontage-band-") as scratch:
        band: Array = np.memmap(scratch, dtype, "w+", shape=shape)
    if fill != 0:
        for row in range(0, shape[0], 1024):
            band[row : row + 1024] = fill
    return band
