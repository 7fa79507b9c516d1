"""Rasters of a facade in blocks and levels, so that a browser loads only what it shows.

Level 0 has the pixels of the ortho-image. Every next level has half as many along each side, until one block
holds the whole picture. Bands are integers in units that keep what was measured; a block holds the
differences of neighbours along a row, the lowest bytes of all first, deflated (RFC 1950).
"""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from frontage.geometry.arrays import Array
from frontage.io.rasters.geotiff import read_geotiff
from frontage.raster.tiles import Tile

BLOCK_PX = 1024
_READ_PX = 2048  # of level 0 that are read at a time; a multiple of the step of every level
_JPEG_QUALITY = 90
_NO_DATA_GREY = 255


@dataclass(frozen=True)
class Band:
    """How a raster becomes integers: the file, m per unit (0 = they are integers already), and their type."""

    file: str
    unit: float
    dtype: str
    missing: int


BANDS = {
    "depth": Band("depth.tif", 1e-5, "<i4", -(2**31)),
    "sources": Band("sources.tif", 0.0, "<u2", 65535),
    "resolution": Band("gsd.tif", 1e-4, "<u2", 65535),
}


@dataclass(frozen=True)
class Block:
    """A block: its level, its column and row among the blocks of the level."""

    level: int
    column: int
    row: int

    def name(self, raster: str) -> str:
        """The file stem of a raster's block."""
        return f"{raster}_{self.level}_{self.column}_{self.row}"


class Blocks:
    """The blocks of the rasters in a facade's folder."""

    def __init__(self, folder: Path, size: tuple[int, int]) -> None:
        """`size` is width and height of level 0 in px."""
        self._folder, self._size = folder, size

    @property
    def levels(self) -> int:
        """The number of levels."""
        count = 1
        while max(self._size) > BLOCK_PX << (count - 1):
            count += 1
        return count

    def all(self) -> Iterator[Block]:
        """All blocks, from the finest level to the coarsest."""
        for level in range(self.levels):
            columns, rows = (-(-side // (BLOCK_PX << level)) for side in self._size)
            yield from (Block(level, c, r) for r in range(rows) for c in range(columns))

    def picture(self, block: Block) -> bytes:
        """Return a block of the picture as JPEG; pixels without data are white."""
        rgba = self._read("ortho.tif", block, cv2.INTER_AREA)
        rgb = np.where(rgba[..., 3:] > 0, rgba[..., :3], _NO_DATA_GREY).astype(np.uint8)
        made: bytes = cv2.imencode(".jpg", rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])[
            1
        ].tobytes()
        return made

    def band(self, name: str, block: Block) -> bytes:
        """Return a block of a band."""
        band = BANDS[name]
        return encoded(self._read(band.file, block, cv2.INTER_NEAREST), band)

    def _read(self, file: str, block: Block, how: int) -> Array:
        """Read a block of a raster, reduced to its level piece by piece."""
        size, step = BLOCK_PX << block.level, 1 << block.level
        c0, r0 = block.column * size, block.row * size
        c1, r1 = min(c0 + size, self._size[0]), min(r0 + size, self._size[1])
        rows = []
        for r in range(r0, r1, _READ_PX):
            windows = [
                Tile(r, min(r + _READ_PX, r1), c, min(c + _READ_PX, c1)) for c in range(c0, c1, _READ_PX)
            ]
            rows.append(np.concatenate([_reduced(self._window(file, w), step, how) for w in windows], axis=1))
        return np.concatenate(rows)

    def _window(self, file: str, window: Tile) -> Array:
        return np.asarray(read_geotiff(self._folder / file, window)[0])


def encoded(values: Array, band: Band) -> bytes:
    """Return a band (h, w) as the bytes that the viewer decodes."""
    if band.unit:
        known = np.isfinite(values)
        whole = np.where(known, np.rint(np.where(known, values, 0.0) / band.unit), band.missing)
        limits = np.iinfo(np.dtype(band.dtype))
        whole = np.clip(whole, limits.min, limits.max)
    else:
        whole = values
    rows = whole.astype(band.dtype)
    steps = rows.copy()
    steps[:, 1:] -= rows[:, :-1]  # wraps around, and the sum wraps back
    octets = np.ascontiguousarray(steps).view(np.uint8).reshape(-1, steps.itemsize)
    return zlib.compress(np.ascontiguousarray(octets.T).tobytes(), 6)


def described() -> dict[str, Any]:
    """Return what the viewer has to know to decode the bands."""
    return {
        name: {"unit": band.unit or 1, "bytes": np.dtype(band.dtype).itemsize, "missing": band.missing}
        for name, band in BANDS.items()
    }


def _reduced(image: Array, step: int, how: int) -> Array:
    """Return every `step`-th pixel of a band, or the means of a picture."""
    if step == 1:
        return image
    h, w = image.shape[:2]
    if how == cv2.INTER_NEAREST:
        r, c = (np.minimum(np.arange(0, side, step) + step // 2, side - 1) for side in (h, w))
        return np.asarray(image[np.ix_(r, c)])
    return np.asarray(cv2.resize(image, (-(-w // step), -(-h // step)), interpolation=how))
