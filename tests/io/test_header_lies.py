"""Counts in headers that the file cannot hold: one clear sentence at once, not a wait or a full memory."""

import os
import socket
import struct
import time
from pathlib import Path

import numpy as np
import pytest

from frontage.errors import FileError
from frontage.io.colmap import read_colmap
from frontage.io.files import reading, require_file, text_of
from frontage.io.scans.read import ScanSource, read_scans
from frontage.io.scans.trajectory import read_trajectory
from io_files import ptx_text, write_colmap_binary, write_laspy

XYZ = np.random.default_rng(0).uniform(0, 9, (1000, 3))


def refused(path: Path, what: str = "") -> str:
    """The sentence of the refusal, checked to come soon and to name the file."""
    began = time.monotonic()
    with pytest.raises(FileError) as e:
        read_scans(path)
    text = str(e.value)
    assert time.monotonic() - began < 5 and path.name in text and "\n" not in text and what in text
    return text


def spoil(path: Path, *changes: tuple[int, str, object]) -> Path:
    """The file with numbers changed: (position, struct format, value)."""
    data = bytearray(path.read_bytes())
    for at, form, value in changes:
        struct.pack_into(form, data, at, value)
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("suffix", [".las", ".laz"])
def test_las_records(tmp_path: Path, suffix: str) -> None:
    def good(kind: int = 6) -> Path:
        return write_laspy(tmp_path / f"a{suffix}", XYZ, kind)

    size = good().stat().st_size
    refused(spoil(good(), (100, "<I", 2**32 - 1)), "4294967295 variable length records")
    refused(spoil(good(), (235, "<Q", 375), (243, "<I", 2**32 - 1)), "4294967295 extended records")
    evlr = (235, "<Q", size - 99), (243, "<I", 1), (size - 79, "<Q", 2**60)
    refused(spoil(good(), *evlr), "an extended record")
    refused(spoil(good(), (96, "<I", 2**31)), "points at byte 2147483648")
    refused(spoil(good(3), (100, "<I", 2**20)), "variable length records")


@pytest.mark.parametrize("suffix", [".las", ".laz"])
@pytest.mark.parametrize("kind", [1, 6])
def test_las_point_counts(tmp_path: Path, suffix: str, kind: int) -> None:
    def lie(count: int) -> Path:
        path = write_laspy(tmp_path / f"a{suffix}", np.tile(XYZ, (60, 1)), kind)
        return spoil(path, (247, "<Q", count) if kind == 6 else (107, "<I", count))

    assert len(read_scans(lie(60_000))[0]) == 60_000
    refused(lie(4_000_000_000), "4000000000 points")
    refused(lie(150_000), "150000 points")
    refused(lie(49_000), "states 49000 points, but the file holds at least")
    if suffix == ".las" or kind == 6:
        refused(lie(59_000), "states 59000 points, but the file holds at least 60000")
        refused(lie(60_001), "60001 points")


@pytest.mark.parametrize("scale", [0.0, -0.001, np.nan, np.inf])
def test_las_scales(tmp_path: Path, scale: float) -> None:
    path = write_laspy(tmp_path / "a.las", XYZ)
    refused(spoil(path, (139, "<d", scale)), "scales and offsets")
    refused(spoil(write_laspy(path, XYZ), (155, "<d", np.inf)), "scales and offsets")


def test_zeros_behind_the_points_are_padding(tmp_path: Path) -> None:
    path = write_laspy(tmp_path / "a.las", XYZ, 1)
    path.write_bytes(path.read_bytes() + bytes(512))
    assert len(read_scans(path)[0]) == 1000


def test_a_program_with_an_umlaut_in_its_name(tmp_path: Path) -> None:
    path = spoil(write_laspy(tmp_path / "a.las", XYZ, 1), (58, "4s", "Gr\u00fcn".encode("latin-1")))
    assert len(read_scans(path)[0]) == 1000


PLY = "ply\nformat {0} 1.0\n{1}element vertex {2}\nproperty float x\nproperty float y\nproperty float z\n{3}end_header\n"  # noqa: E501


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("count", [-1, -(10**9), 10**9, 2**63, 10**30])
def test_ply_counts(tmp_path: Path, order: str, count: int) -> None:
    path, body = tmp_path / "a.ply", b"1 2 3\n4 5 6\n" * 100
    path.write_bytes(PLY.format(order, "", count, "").encode() + body)
    refused(path, "vertex")
    path.write_bytes(PLY.format(order, f"element camera {count}\nproperty int a\n", 2, "").encode() + body)
    refused(path, "camera")
    if count < 0:  # what follows the vertices is not read, but a header with it is damaged all the same
        path.write_bytes(PLY.format(order, "", 2, f"element face {count}\nproperty int a\n").encode() + body)
        refused(path, "face")


def test_ply_header_without_end(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    path.write_bytes(b"ply\nformat ascii 1.0\n" + b"comment x\n" * 2_000_000)
    refused(path, "header")


@pytest.mark.parametrize("head", ["40000\n30000", "1000000000\n1000000000", "-4\n-3", "0\n5", "99999999999999999999\n1"])  # fmt: skip  # noqa: E501
def test_ptx_counts(tmp_path: Path, head: str) -> None:
    text = ptx_text(4, 3)
    path = tmp_path / "a.ptx"
    path.write_text(head + text[text.index("\n", text.index("\n") + 1) :])
    refused(path, "scan grid")


@pytest.mark.parametrize("name", ["points3D", "images", "cameras"])
@pytest.mark.parametrize("count", [2**63, 2**40, 10**6])
def test_colmap_counts(tmp_path: Path, name: str, count: int) -> None:
    model = write_colmap_binary(tmp_path)
    spoil(model / f"{name}.bin", (0, "<Q", count))
    with pytest.raises(FileError, match=f"{name}.bin: truncated or damaged: its header states {count}"):
        read_scans(model) if name == "points3D" else read_colmap(model)


def test_colmap_track_and_observations(tmp_path: Path) -> None:
    model = write_colmap_binary(tmp_path)
    spoil(model / "points3D.bin", (8 + 43, "<Q", 2**62))
    with pytest.raises(FileError, match="truncated"):
        read_scans(model)
    data = (model / "images.bin").read_bytes()
    spoil(model / "images.bin", (data.index(b"\0", 8 + 64) + 1, "<Q", 2**62))
    with pytest.raises(FileError, match="truncated"):
        read_colmap(model)


def test_sbet_sizes(tmp_path: Path) -> None:
    (tmp_path / "t.sbet").write_bytes(bytes(136 * 3 + 1))
    with pytest.raises(FileError, match="multiple"):
        read_trajectory(tmp_path / "t.sbet")


def special(folder: Path, kind: str) -> Path:
    path = folder / f"{kind}.laz"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "socket":
        with socket.socket(socket.AF_UNIX) as s:
            here = os.getcwd()
            os.chdir(folder)  # the length of a socket's path is limited
            s.bind(path.name)
            os.chdir(here)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    else:
        path.mkdir()
    return path


@pytest.mark.parametrize("kind", ["pipe", "socket", "device", "folder"])
def test_only_regular_files_are_opened(tmp_path: Path, kind: str) -> None:
    path = special(tmp_path, kind)
    with pytest.raises(FileError, match="a folder" if kind == "folder" else "pipe, socket or device"):
        require_file(path)
    with pytest.raises(FileError, match="not a regular file"):
        text_of(path, "name a file")
    if kind != "folder":
        refused(path, "not a file")
    scan = write_laspy(tmp_path / "s.las", XYZ, 6)
    for about in ({"trajectory": str(path)}, {"stations": str(path)}):
        with pytest.raises(FileError, match=path.name):
            read_scans(ScanSource(path=str(scan), **about))


@pytest.mark.parametrize(
    "name", ["a\0b.laz", "a" * 300 + ".laz", "x/" * 3000 + "a.laz"], ids=["null", "name", "path"]
)
def test_paths_that_no_file_can_have(tmp_path: Path, name: str) -> None:
    with pytest.raises(FileError, match="path") as e:
        read_scans(f"{tmp_path}/{name}")
    assert "\0" not in str(e.value) and len(str(e.value)) < 600
    with pytest.raises(FileError):
        text_of(Path(f"{tmp_path}/{name}"), "name a file")


def test_memory_is_not_blamed_on_the_file(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    path.write_bytes(b"x" * 2_000_000)
    with (
        pytest.raises(FileError, match=r"does not fit into memory \(the file has 2.0 MB; 7.28 TiB more") as e,
        reading(path, "PLY"),
    ):
        np.empty(10**12)
    assert e.value.code == "I115"
