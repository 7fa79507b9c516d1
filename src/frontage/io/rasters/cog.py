"""The order of a cloud-optimised GeoTIFF (OGC 21-026): directories, then tiles, those of overviews first.

A program that opens such a file over a network learns everything about it from the first kilobytes, and finds
a quick picture right behind them.
"""

import struct
from dataclasses import dataclass
from typing import IO, Any

import tifffile

_OFFSETS = 324  # of tiles
_LONG, _LONG8 = 4, 16  # types of numbers
_NOTE = (
    b"LAYOUT=IFDS_BEFORE_DATA\nBLOCK_ORDER=ROW_MAJOR\nBLOCK_LEADER=SIZE_AS_UINT4\n"
    b"BLOCK_TRAILER=LAST_4_BYTES_REPEATED\nKNOWN_INCOMPATIBLE_EDITION=NO\n "
)
_GHOST = b"GDAL_STRUCTURAL_METADATA_SIZE=%06d bytes\n" % len(_NOTE) + _NOTE
"""What GDAL writes and looks for between the header and the first directory."""
_AROUND = 4  # bytes before a tile, its size, and after it, its last four again: what the note promises


@dataclass(frozen=True)
class _Width:
    """How a TIFF or BigTIFF writes numbers: header, count of entries, count of values, offset."""

    header: bytes
    entries: str
    values: str
    offset: int

    def number(self, value: int) -> bytes:
        return struct.pack("<" + self.values, value)


_CLASSIC = _Width(struct.pack("<2sH", b"II", 42), "H", "I", _LONG)
_BIG = _Width(struct.pack("<2sHHH", b"II", 43, 8, 0), "Q", "Q", _LONG8)

_Tag = tuple[int, int, int, bytes]
"""Code, type, count of values, the values."""


def write_ordered(plain: IO[bytes], target: IO[bytes]) -> None:
    """Copy a little-endian tiled TIFF, from its largest to its smallest picture, in the order of a COG.

    The tiles are copied as they are: nothing is decoded.
    """
    with tifffile.TiffFile(plain) as tif:
        pages: list[Any] = list(tif.pages)
        width = _BIG if tif.is_bigtiff else _CLASSIC
        tags = [_tags(page, width) for page in pages]
        at = _even(len(width.header) + len(width.number(0)) + len(_GHOST))
        starts = [at]
        for own in tags:
            starts.append(starts[-1] + len(_directory(own, width, 0, 0)))
        data = starts.pop()
        for page, own in zip(reversed(pages), reversed(tags), strict=True):
            data = _place(page, own, width, data)
        target.write((width.header + width.number(starts[0]) + _GHOST).ljust(at, b"\0"))
        for own, start, after in zip(tags, starts, (*starts[1:], 0), strict=True):
            target.write(_directory(own, width, start, after))
        for page in reversed(pages):
            for offset, size in zip(page.dataoffsets, page.databytecounts, strict=True):
                plain.seek(offset)
                tile = plain.read(size)
                target.write(struct.pack("<I", size) + tile + tile[-_AROUND:])


def _tags(page: Any, width: _Width) -> list[_Tag]:
    """Return the tags of a page with their values as bytes; offsets are still to be filled in."""
    file, found = page.parent.filehandle, list[_Tag]()
    for tag in sorted(page.tags.values(), key=lambda tag: int(tag.code)):
        file.seek(tag.valueoffset)
        found.append((tag.code, int(tag.dtype), tag.count, file.read(tag.valuebytecount)))
    kept = [tag for tag in found if tag[0] != _OFFSETS]
    count = len(page.dataoffsets)
    kept.append((_OFFSETS, width.offset, count, bytes(count * len(width.number(0)))))
    return sorted(kept)


def _place(page: Any, own: list[_Tag], width: _Width, at: int) -> int:
    """Fill in the offsets of a page whose tiles begin `at`; returns where they end."""
    offsets = []
    for size in page.databytecounts:
        offsets.append(at + _AROUND)
        at += size + 2 * _AROUND
    number = next(k for k, tag in enumerate(own) if tag[0] == _OFFSETS)
    own[number] = (_OFFSETS, width.offset, len(offsets), b"".join(width.number(v) for v in offsets))
    return at


def _directory(own: list[_Tag], width: _Width, start: int, after: int) -> bytes:
    """Return a directory that begins at `start`, with the values that do not fit into its entries."""
    slot = len(width.number(0))
    entries = struct.pack("<" + width.entries, len(own))
    outside = start + len(entries) + len(own) * (4 + 2 * slot) + slot
    more = b""
    for code, kind, count, values in own:
        inline = len(values) <= slot
        entries += struct.pack("<HH", code, kind) + width.number(count)
        entries += values.ljust(slot, b"\0") if inline else width.number(outside + len(more))
        more += b"" if inline else values.ljust(_even(len(values)), b"\0")
    whole = entries + width.number(after) + more
    return whole.ljust(_even(len(whole)), b"\0")


def _even(size: int) -> int:
    return size + size % 2
