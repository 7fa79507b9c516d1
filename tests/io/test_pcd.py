"""PCD files of every kind give the same points; broken ones are refused with one sentence."""

import struct
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from frontage.errors import FileError
from frontage.geometry.arrays import Array
from frontage.io.scans.read import read_scans

N = 700
RNG = np.random.default_rng(3)
POINTS = RNG.uniform(-20, 20, (N, 3)).astype(np.float32)
POINTS[::50] = np.nan
COLOURS = RNG.integers(0, 256, (N, 3)).astype(np.uint32)
PACKED = ((COLOURS[:, 0] << 16) | (COLOURS[:, 1] << 8) | COLOURS[:, 2]).astype(np.uint32)
INTENSITY = np.linspace(0, 1, N, dtype=np.float32)
COLUMNS = (*POINTS.T, np.zeros(N, np.float32), PACKED.view(np.float32), INTENSITY)


def head(data: str, viewpoint: str = "1 2 3 1 0 0 0", count: int = N) -> str:
    return (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z _ rgb intensity\n"
        "SIZE 4 4 4 4 4 4\nTYPE F F F F F F\nCOUNT 1 1 1 1 1 1\n"
        f"WIDTH {count}\nHEIGHT 1\nVIEWPOINT {viewpoint}\nPOINTS {count}\nDATA {data}\n"
    )


def packed(data: bytes) -> bytes:
    """LZF with literals, and copies wherever the last 30 bytes say the same."""
    out, at, literal = bytearray(), 0, bytearray()

    def flush() -> None:
        for k in range(0, len(literal), 32):
            out.extend([len(literal[k : k + 32]) - 1, *literal[k : k + 32]])
        literal.clear()

    while at < len(data):
        window = data[max(0, at - 30) : at]
        size = next((n for n in (200, 40, 8, 3) if len(data) - at >= n and _found(window, data, at, n)), 0)
        if not size:
            literal.append(data[at])
            at += 1
            continue
        flush()
        back = _back(window, data, at, size) - 1
        length = size - 2
        out.extend([(min(length, 7) << 5) | (back >> 8), *([length - 7] if length >= 7 else []), back & 255])
        at += size
    flush()
    return bytes(out)


def _back(window: bytes, data: bytes, at: int, size: int) -> int:
    """How far back a copy of `size` bytes can begin; it may run into itself. 0 = nowhere."""
    backs = range(1, len(window) + 1)
    return next((b for b in backs if all(data[at + k] == data[at + k - b] for k in range(size))), 0)


def _found(window: bytes, data: bytes, at: int, size: int) -> bool:
    return _back(window, data, at, size) > 0


@cache
def content(kind: str) -> bytes:
    if kind == "ascii":
        rows = np.column_stack([POINTS, np.zeros(N)])
        bits = PACKED.view(np.float32)
        lines = (f"{' '.join(repr(float(v)) for v in row)} {bits[k]:.9g} {INTENSITY[k]!s}" for k, row in
                 enumerate(rows))  # fmt: skip
        return "\n".join(lines).encode()
    if kind == "binary":
        return np.rec.fromarrays(COLUMNS).tobytes()
    data = b"".join(np.ascontiguousarray(c).tobytes() for c in COLUMNS)
    small = packed(data)
    assert len(small) < len(data)
    return struct.pack("<II", len(small), len(data)) + small


@pytest.mark.parametrize("kind", ["ascii", "binary", "binary_compressed"])
def test_every_kind_gives_the_same_points(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "a.pcd"
    path.write_bytes(head(kind).encode() + content(kind))
    (scan,) = read_scans(path)
    known = np.isfinite(POINTS).all(1)
    np.testing.assert_allclose(scan.world.to_world(scan.xyz), POINTS[known], atol=1e-5)
    assert scan.rgb is not None and scan.intensity is not None
    np.testing.assert_array_equal(scan.rgb, COLOURS[known])
    np.testing.assert_allclose(scan.intensity, INTENSITY[known], atol=1e-6)
    np.testing.assert_allclose(scan.world.to_world(scan.origins), [[1, 2, 3]])
    assert (scan.origin_index == 0).all()


def test_the_default_viewpoint_is_none(tmp_path: Path) -> None:
    path = tmp_path / "a.pcd"
    path.write_bytes(head("binary", "0 0 0 1 0 0 0").encode() + content("binary"))
    (scan,) = read_scans(path)
    assert (scan.origin_index == -1).all()


def broken() -> dict[str, bytes]:
    whole = content("binary_compressed")
    damaged: Array = np.frombuffer(whole, np.uint8).copy()
    damaged[8] = 255  # a copy of what is not there yet
    return {
        "truncated": head("binary").encode() + content("binary")[:-100],
        "short text": head("ascii").encode() + b"1 2 3 0 0 0\n" * 10,
        "truncated copy": head("binary_compressed").encode() + whole[:-20],
        "damaged copy": head("binary_compressed").encode() + damaged.tobytes(),
        "another number of points": head("binary_compressed", count=N + 1).encode() + whole,
        "bomb": head("binary_compressed", count=10**8).encode()
        + struct.pack("<II", 3, 24 * 10**8)
        + b"\0" * 3,
        "no data": b"VERSION 0.7\nFIELDS x y z\n",
        "no coordinates": head("ascii").replace("x y z", "a b c").encode(),
        "odd size": head("ascii").replace("SIZE 4", "SIZE 3").encode(),
        "two heights": head("binary").replace("COUNT 1 1 1", "COUNT 1 1 2").encode() + content("binary") * 2,
        "unknown kind": head("zipped").encode(),
        "another file": b"PK\x03\x04 a zip" + bytes(range(256)) * 8,
        "nothing but gaps": head("ascii", count=2).encode() + b"nan nan nan 0 0 0\n" * 2,
    }


@pytest.mark.parametrize("name", broken())
def test_broken_files_are_refused_with_a_sentence(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.pcd"
    path.write_bytes(broken()[name])
    with pytest.raises(FileError) as error:
        read_scans(path)
    assert str(path) in str(error.value) and "\n" not in str(error.value)
