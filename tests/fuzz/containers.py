"""Changes inside containers whose checksums would otherwise be all that is tested.

E57 pages, PNG chunks and npz archives get right checksums again after the change.
"""

import io
import random
import sqlite3
import struct
import zipfile
import zlib
from collections.abc import Callable

import numpy as np
import shapely

Mutation = Callable[[random.Random, bytes], bytes]
Arrays = dict[str, np.ndarray]

_PAGE, _DATA = 1024, 1020  # bytes of an E57 page, and of them before its CRC-32C
_EXTREMES = (0, 1, -1, 2**31 - 1, -(2**31), 1e308, float("nan"), float("inf"), 1e12)


def _crc_table() -> list[int]:
    table = []
    for n in range(256):
        c = n
        for _ in range(8):
            c = c >> 1 ^ (0x82F63B78 if c & 1 else 0)
        table.append(c)
    return table


_CRC = _crc_table()


def crc32c(data: bytes) -> int:
    """The checksum of E57 pages (CRC-32C, Castagnoli)."""
    c = 0xFFFFFFFF
    for byte in data:
        c = _CRC[(c ^ byte) & 0xFF] ^ c >> 8
    return c ^ 0xFFFFFFFF


def _stream(data: bytes) -> bytearray:
    """The contents of an E57 file without its checksums."""
    return bytearray(b"".join(data[k : k + _DATA] for k in range(0, len(data), _PAGE)))


def _paged(stream: bytes) -> bytes:
    """The inverse of `_stream`, with right checksums."""
    stream = stream + b"\0" * (-len(stream) % _DATA)
    pages = (stream[k : k + _DATA] for k in range(0, len(stream), _DATA))
    return b"".join(page + struct.pack(">I", crc32c(page)) for page in pages)


def in_e57_stream(change: Mutation) -> Mutation:
    """The change, made to the contents of an E57 file under right checksums."""

    def mutate(r: random.Random, data: bytes) -> bytes:
        return _paged(change(r, bytes(_stream(data))))

    mutate.__name__ = f"e57_stream_{change.__name__}"
    return mutate


def in_e57_xml(change: Mutation) -> Mutation:
    """The change, made to the XML section of an E57 file, whose place and length are stated rightly."""

    def mutate(r: random.Random, data: bytes) -> bytes:
        stream = _stream(data)
        physical, length = struct.unpack_from("<QQ", stream, 24)
        at = physical // _PAGE * _DATA + physical % _PAGE
        xml = change(r, bytes(stream[at : at + length]))
        stream[at:] = xml
        struct.pack_into("<Q", stream, 32, len(xml))
        struct.pack_into("<Q", stream, 16, -(-len(stream) // _DATA) * _PAGE)
        return _paged(bytes(stream))

    mutate.__name__ = f"e57_xml_{change.__name__}"
    return mutate


def _npz_changed(data: bytes, change: Callable[[Arrays], None]) -> bytes:
    with np.load(io.BytesIO(data)) as file:
        arrays = {name: file[name] for name in file.files}
    change(arrays)
    out = io.BytesIO()
    np.savez(out, allow_pickle=False, **arrays)
    return out.getvalue()


def npz_values(r: random.Random, data: bytes) -> bytes:
    """Some values of an array are extreme."""

    def change(arrays: Arrays) -> None:
        name = r.choice(list(arrays))
        array = np.array(arrays[name])
        if array.size and array.dtype.kind in "fiu":
            flat = array.reshape(-1)
            with np.errstate(all="ignore"):
                low = np.iinfo(array.dtype).max if array.dtype.kind in "iu" else r.choice(_EXTREMES)
                flat[r.randrange(len(flat)) :: r.choice((1, 7, 10**9))] = low
        arrays[name] = array

    return _npz_changed(data, change)


def npz_shape(r: random.Random, data: bytes) -> bytes:
    """An array is lost, shorter, transposed, of another type, or renamed."""

    def change(arrays: Arrays) -> None:
        name = r.choice(list(arrays))
        array, what = arrays.pop(name), r.randrange(6)
        if what == 0:
            return
        changed = (array, array[:-1] if array.ndim else array, array.T, array.reshape(-1)[:0],
                   array.astype("U5"), array.astype(np.complex128))  # fmt: skip
        arrays["x" if what == 5 and r.random() < 0.3 else name] = changed[what]

    return _npz_changed(data, change)


def npz_header(r: random.Random, data: bytes) -> bytes:
    """The shape in the header of an array is a lie, in an archive with right checksums."""
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as file, zipfile.ZipFile(out, "w") as changed:
        names = file.namelist()
        chosen = r.choice(names)
        for name in names:
            content = file.read(name)
            if name == chosen:
                at, end = content.find(b"(", 60) + 1, content.find(b"\n")
                shape = r.choice((b"99999999999,", b"-1,", b"0,", b"2,2,2,2,", b"1e9,", b"(" * 90))
                head = content[:at] + shape + b"), }"
                content = head[:end].ljust(end) + content[end:] if len(head) < end else head + content[end:]
            changed.writestr(name, content)
    return out.getvalue()


def npz_bomb(r: random.Random, data: bytes) -> bytes:
    """An array that claims 25 GB, of which two megabytes are there."""
    out = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(data)) as file,
        zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as changed,
    ):
        names = file.namelist()
        for name in names[1:]:
            changed.writestr(name, file.read(name))
        shape = b"{'descr': '<f8', 'fortran_order': False, 'shape': (3200000000,), }"
        head = b"\x93NUMPY\x01\x00" + struct.pack("<H", 118) + shape.ljust(117) + b"\n"
        changed.writestr(names[0], head + b"\0" * 2_000_000)
    return out.getvalue()


change_npz: tuple[Mutation, ...] = (npz_values, npz_values, npz_shape, npz_shape, npz_header, npz_bomb)


def _png_chunks(data: bytes) -> list[tuple[bytes, bytes]]:
    at, found = 8, []
    while at + 8 <= len(data):
        (length,), kind = struct.unpack_from(">I", data, at), data[at + 4 : at + 8]
        found.append((kind, data[at + 8 : at + 8 + length]))
        at += 12 + length
    return found


def _png(chunks: list[tuple[bytes, bytes]]) -> bytes:
    made = (
        struct.pack(">I", len(c)) + kind + c + struct.pack(">I", zlib.crc32(kind + c)) for kind, c in chunks
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(made)


def png_header(r: random.Random, data: bytes) -> bytes:
    """The size, depth or colour type of a PNG is a lie."""
    (kind, head), *rest = _png_chunks(data)
    out = bytearray(head)
    if r.random() < 0.6:
        sizes = (0, 1, 65_535, 30_000, 2**31 - 1, 2**32 - 1)
        struct.pack_into(">I", out, r.choice((0, 4)), r.choice(sizes))
    else:
        out[r.randrange(8, 13)] = r.randrange(256)
    return _png([(kind, bytes(out)), *rest])


def png_pixels(r: random.Random, data: bytes) -> bytes:
    """The compressed pixels of a PNG are damaged or end early, under right checksums."""
    chunks = _png_chunks(data)
    k = next(i for i, (kind, _) in enumerate(chunks) if kind == b"IDAT")
    pixels = bytearray(chunks[k][1])
    if r.random() < 0.5:
        pixels[r.randrange(len(pixels))] ^= 0x55
    else:
        del pixels[r.randrange(len(pixels)) :]
    chunks[k] = (b"IDAT", bytes(pixels))
    return _png(chunks)


def png_bomb(r: random.Random, data: bytes) -> bytes:
    """A picture of 30,000 x 30,000 px that is packed into less than a megabyte."""
    head = struct.pack(">IIBBBBB", 30_000, 30_000, 1, 0, 0, 0, 0)
    row = b"\0" * (1 + 30_000 // 8)
    return _png([(b"IHDR", head), (b"IDAT", zlib.compress(row * 30_000)), (b"IEND", b"")])


change_png: tuple[Mutation, ...] = (png_header, png_header, png_header, png_pixels, png_pixels, png_bomb)


def _blobs(r: random.Random) -> tuple[object, ...]:
    """Geometries that a GeoPackage should not hold."""

    def head(order: bytes = b"\x01") -> bytes:
        return b"GP\0" + order + struct.pack("<i", 25832)

    polygon = struct.pack("<BII", 1, 3, 1)
    depth = r.choice((50, 2000, 50_000))
    nested = struct.pack("<BII", 1, 7, 1) * depth + struct.pack("<BIdd", 1, 1, 0.0, 0.0)
    wild = shapely.to_wkb(shapely.Polygon([(0, 0), (1e300, 0), (1e308, 1e308), (0, 1)]))
    bow = shapely.to_wkb(shapely.Polygon([(0, 0), (9, 9), (9, 0), (0, 9)]))
    empty = shapely.to_wkb(shapely.Polygon())
    whole = (nested, wild, bow, empty, polygon + struct.pack("<I", 2**32 - 1), b"\x07" * 40, b"")
    nan = polygon + struct.pack("<I8d", 4, *[float("nan")] * 8)
    return (*(head() + w for w in (*whole, nan)), b"GP", b"", None, "text", 7, 1.5, head(b"\xff") + bow)


def gpkg_geometry(r: random.Random, data: bytes) -> bytes:
    """The geometry of a row is none, damaged, nested or not finite."""
    return _sql(data, "UPDATE prints SET geom = ?", r.choice(_blobs(r)))


def gpkg_table(r: random.Random, data: bytes) -> bytes:
    """The tables that describe a GeoPackage are lost or lie."""
    return _sql(data, r.choice((
        "UPDATE gpkg_geometry_columns SET srs_id = ?", "UPDATE gpkg_geometry_columns SET table_name = ?",
        "UPDATE gpkg_geometry_columns SET column_name = ?", "UPDATE prints SET height = ?",
        "UPDATE gpkg_spatial_ref_sys SET organization_coordsys_id = ?", "UPDATE prints SET street = ?",
        "UPDATE gpkg_spatial_ref_sys SET organization = ?",
        "UPDATE gpkg_geometry_columns SET table_name = 'sqlite_master', column_name = ?",
        "DELETE FROM gpkg_spatial_ref_sys WHERE ? IS NOT 3",
        "DELETE FROM prints WHERE ? IS NOT 3",
    )), r.choice((None, -1, 2**62, 1e308, "x", 'a"b;--', b"\0\xff", "\x1b[31m", float("nan"))))  # fmt: skip


def _sql(data: bytes, statement: str, value: object) -> bytes:
    with sqlite3.connect(":memory:") as db:
        db.deserialize(data)
        db.execute(statement, (value,))
        db.commit()
        out: bytes = db.serialize()
    db.close()
    return out


change_geopackage: tuple[Mutation, ...] = (gpkg_geometry, gpkg_geometry, gpkg_table)
