"""Damaged pictures are refused by name; a decoder would fill them with grey without a word."""

import io
import os
import re
import struct
import threading
import zlib
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from frontage.errors import FileError
from frontage.io.photos.decoder import decode
from frontage.io.photos.imagefile import parse_header
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.model import WorldRef
from io_files import write_colmap_text, write_photos

END = b"\xff\xd9"


def scene(height: int = 480, width: int = 640) -> np.ndarray:
    """A picture with the texture of a photo, RGB."""
    random = np.random.default_rng(7)
    noise = cv2.GaussianBlur(random.normal(0, 60, (height, width, 3)), (0, 0), 1.5) * 4
    return np.clip(128 + noise, 0, 255).astype(np.uint8)


def encoded(kind: str) -> bytes:
    stream = io.BytesIO()
    name, _, way = kind.partition(" ")
    options = {"progressive": way == "progressive"} if name == "jpeg" else {}
    if name == "tiff":
        options = {"compression": way or None}
    if way == "stored":
        options = {"compress_level": 0}
    Image.fromarray(scene()).save(stream, name.upper(), **options)
    return stream.getvalue()


def cut_and_closed(data: bytearray) -> bytes:
    return bytes(data[: len(data) // 3]) + END


def flipped(data: bytearray) -> bytes:
    for at in np.linspace(0.35, 0.9, 8):
        data[int(len(data) * at)] ^= 0xFF
    return bytes(data)


def zeroed(data: bytearray) -> bytes:
    data[len(data) // 2 : len(data) // 2 + 4096] = bytes(4096)
    return bytes(data)


def scrambled(data: bytearray) -> bytes:
    data[len(data) // 2 : len(data) // 2 + 4096] = np.random.default_rng(3).bytes(4096)
    return bytes(data)


def shortened(data: bytearray) -> bytes:
    del data[len(data) // 2 : len(data) // 2 + 4096]
    return bytes(data)


def without_chunks(data: bytearray) -> bytes:
    """A PNG with only the first part of its compressed data, but closed, and with right checksums."""
    at = data.index(b"IDAT") - 4
    (length,) = struct.unpack_from(">I", data, at)
    body = b"IDAT" + bytes(data[at + 8 : at + 8 + length // 3])
    chunk = struct.pack(">I", len(body) - 4) + body + struct.pack(">I", zlib.crc32(body))
    return bytes(data[:at]) + chunk + struct.pack(">I", 0) + b"IEND" + struct.pack(">I", zlib.crc32(b"IEND"))


ANY = (flipped, zeroed, scrambled, shortened)
CASES: list[tuple[str, Callable[[bytearray], bytes]]] = [
    *(("jpeg", change) for change in (cut_and_closed, *ANY)),
    *(("jpeg progressive", change) for change in (cut_and_closed, *ANY)),
    *(("png", change) for change in (without_chunks, *ANY)),
    *(("png stored", change) for change in (without_chunks, *ANY)),
    *(("tiff tiff_lzw", change) for change in ANY),
    *(("tiff tiff_adobe_deflate", change) for change in ANY),
    *(("tiff jpeg", change) for change in (zeroed, scrambled, shortened)),
]


@pytest.mark.parametrize(("kind", "change"), CASES)
def test_damage_is_told(
    kind: str, change: Callable[[bytearray], bytes], capfd: pytest.CaptureFixture
) -> None:
    good = encoded(kind)
    assert decode(good, "photo").shape == (480, 640, 3)
    with pytest.raises(FileError, match=r"^street/a\.jpg: the picture (is damaged|cannot be decoded)") as e:
        decode(change(bytearray(good)), "street/a.jpg")
    assert "\n" not in str(e.value) and len(str(e.value)) < 300
    assert capfd.readouterr().err == "", "the decoder's own words stay out of the terminal"


def test_the_pixels_are_those_that_the_file_holds() -> None:
    assert np.array_equal(decode(encoded("png"), "a"), scene())
    with Image.open(io.BytesIO(encoded("jpeg"))) as picture:
        assert np.array_equal(decode(encoded("jpeg"), "a"), np.asarray(picture))


def test_a_damaged_photo_of_a_project_is_named(tmp_path: Path) -> None:
    model, folder = write_colmap_text(tmp_path / "model"), write_photos(tmp_path / "pictures")
    photo = folder / "sub" / "b.jpg"
    ok, jpeg = cv2.imencode(".jpg", scene(40, 60), [cv2.IMWRITE_JPEG_QUALITY, 100])
    assert ok
    photo.write_bytes(cut_and_closed(bytearray(jpeg)))
    found = read_photos(PhotoSource(path=str(folder), cameras=str(model)), WorldRef(np.zeros(3), None))
    assert found.image("a.jpg").shape == (40, 60, 3)
    with pytest.raises(FileError, match=re.escape(f"{photo}: ")):
        found.image("sub/b.jpg")


def test_a_tiff_without_its_last_strips_is_truncated() -> None:
    """Uncompressed, it has no checksum: only its size can tell."""
    good = encoded("tiff")
    assert parse_header(good, "a.tif").width == 640
    with pytest.raises(FileError, match=r"a\.tif: the TIFF picture is truncated"):
        parse_header(shortened(bytearray(good)), "a.tif")


def test_zeros_before_the_end_are_padding_and_no_damage() -> None:
    good = encoded("jpeg")
    padded = good[:-2] + bytes(500) + END
    assert np.array_equal(decode(padded, "a"), decode(good, "a"))
    with pytest.raises(FileError, match="is damaged"):
        decode(good[:-2] + b"\x17" * 500 + END, "a")


def test_what_others_print_meanwhile_is_not_lost(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    real = cv2.imdecode

    def interrupted(data: np.ndarray, flags: int) -> np.ndarray:
        os.write(2, b"another thread writes\n")
        return real(data, flags)

    monkeypatch.setattr(cv2, "imdecode", interrupted)
    decode(encoded("png"), "a")
    assert capfd.readouterr().err == "another thread writes\n"


def test_threads_do_not_mix_up_their_warnings() -> None:
    good, bad = encoded("jpeg"), cut_and_closed(bytearray(encoded("jpeg")))
    verdicts: dict[int, bool] = {}

    def check(number: int) -> None:
        try:
            decode(bad if number % 2 else good, str(number))
            verdicts[number] = True
        except FileError:
            verdicts[number] = False

    threads = [threading.Thread(target=check, args=(n,)) for n in range(12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert verdicts == {n: n % 2 == 0 for n in range(12)}
