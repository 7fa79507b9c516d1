"""A writer of COPC files for tests; laspy only reads them."""

import struct
from pathlib import Path

import laspy
import lazrs
import numpy as np

from frontage.geometry.arrays import Float

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
