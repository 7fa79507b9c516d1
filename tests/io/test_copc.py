"""COPC: queries by bounds and by resolution read only the needed nodes and agree with the whole file."""

import struct
from pathlib import Path

import laspy
import lazrs
import numpy as np
import pytest

from frontage.geometry.arrays import Float
from frontage.io.scans.read import read_scans

HALF, SPACING = 32.0, 4.0  # m: the root cube's half size and point spacing
ORIGIN = np.array([678_000.0, 5_403_000.0, 400.0])


def write_copc(path: Path, nodes: dict[tuple[int, int, int, int], Float]) -> Path:
    """A COPC 1.0 file: LAZ 1.4 with variable chunks, the info VLR first, the octree's nodes in one page."""
    points = np.vstack(list(nodes.values()))
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.scales, header.offsets = np.full(3, 0.001), ORIGIN
    vlr = lazrs.LazVlr.new_for_compression(6, 0, True)
    record = bytes(vlr.record_data())
    start = 375 + 54 + 160 + 54 + len(record)
    head = _header(header, points, start)
    with open(path, "wb") as f:
        f.write(b"\0" * start)
        compressor = lazrs.LasZipCompressor(f, vlr)
        entries, last = b"", 0
        f.flush()
        last = start + 8
        for key, xyz in nodes.items():
            compressor.compress_chunks([_records(header, xyz)])
            end = f.tell()
            entries += struct.pack("<4iQii", *key, last, end - last, len(xyz))
            last = end
        compressor.done()
        f.seek(0, 2)
        evlr = f.tell()
        f.write(struct.pack("<H16sHQ32s", 0, b"copc", 1000, len(entries), b"") + entries)
        info = (
            struct.pack("<5dQQ2d", *(ORIGIN + HALF), HALF, SPACING, evlr + 60, len(entries), 0, 0)
            + b"\0" * 88
        )
        f.seek(0)
        f.write(head[:235] + struct.pack("<QI", evlr, 1) + head[247:])
        f.write(struct.pack("<H16sHH32s", 0, b"copc", 1, 160, b"") + info)
        f.write(struct.pack("<H16sHH32s", 0, b"laszip encoded", 22204, len(record), b"") + record)
    return path


def _records(header: laspy.LasHeader, xyz: Float) -> bytes:
    r = laspy.ScaleAwarePointRecord.zeros(len(xyz), header=header)
    r.X, r.Y, r.Z = np.rint((xyz - ORIGIN) / 0.001).astype(np.int32).T
    return bytes(r.array.tobytes())


def _header(header: laspy.LasHeader, xyz: Float, start: int) -> bytes:
    """The 375 bytes of a LAS 1.4 header, compressed bit set, two VLRs."""
    low, high = xyz.min(0), xyz.max(0)
    bounds = [v for k in range(3) for v in (high[k], low[k])]
    return struct.pack(
        "<4sHHIHH8sBB32s32sHHHIIBHI5I3d3d6dQQIQ15Q", b"LASF", 0, 16, 0, 0, 0, b"", 1, 4, b"", b"", 1, 2000, 375,  # noqa: E501
        start, 2, 6 | 128, 30, 0, 0, 0, 0, 0, 0, *header.scales, *header.offsets, *bounds, 0, 0, 0, len(xyz),
        *[0] * 15,
    )  # fmt: skip


@pytest.fixture
def copc(tmp_path: Path) -> tuple[Path, Float, Float]:
    r = np.random.default_rng(0)
    root = np.round(r.uniform(0, 64, (300, 3)), 3) + ORIGIN
    low = np.round(r.uniform(0, 32, (500, 3)), 3) + ORIGIN
    high = np.round(r.uniform(32, 64, (700, 3)), 3) + ORIGIN
    nodes = {(0, 0, 0, 0): root, (1, 0, 0, 0): low, (1, 1, 1, 1): high}
    return write_copc(tmp_path / "a.copc.laz", nodes), root, np.vstack([root, low, high])


def world(scan: object) -> Float:
    return np.round(scan.world.to_world(scan.xyz), 3)  # type: ignore[attr-defined,no-any-return]


def test_the_whole_file(copc: tuple[Path, Float, Float]) -> None:
    np.testing.assert_allclose(world(read_scans(copc[0])[0]), copc[2], atol=1e-6)


def test_bounds(copc: tuple[Path, Float, Float]) -> None:
    x, y = ORIGIN[:2] + 5
    got = world(read_scans(copc[0], bounds=(x, y, x + 20, y + 20))[0])
    inside = ((copc[2][:, :2] >= [x, y]) & (copc[2][:, :2] <= [x + 20, y + 20])).all(1)
    np.testing.assert_allclose(np.sort(got, 0), np.sort(copc[2][inside], 0), atol=1e-6)


def test_resolution_stops_at_the_level(copc: tuple[Path, Float, Float]) -> None:
    got = world(read_scans(copc[0], resolution=SPACING)[0])
    assert 200 < len(got) <= 300
    assert set(map(tuple, got.round(3))) <= set(map(tuple, copc[1].round(3)))
