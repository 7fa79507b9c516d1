"""The list of the files that reading photos opens: what is not in it could change without being noticed."""

import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from frontage.errors import FileError
from frontage.io.photos.imagefile import upright
from frontage.io.photos.read import PhotoSource, photo_inputs, read_photos
from frontage.io.scans.read import ScanSource
from frontage.model import WorldRef
from frontage.pipeline.project import make_project
from io_files import picture, write_colmap_binary, write_colmap_text, write_photos

LOCAL = WorldRef(np.zeros(3), None)
_watched: list[str] | None = None


def _listen(event: str, arguments: tuple[Any, ...]) -> None:
    if _watched is not None and event == "open" and isinstance(arguments[0], str):
        _watched.append(arguments[0])


sys.addaudithook(_listen)


@pytest.fixture
def opened() -> Iterator[list[str]]:
    """The names of the files that are opened while a test runs."""
    global _watched
    _watched = []
    yield _watched
    _watched = None


@pytest.mark.parametrize("write", [write_colmap_text, write_colmap_binary])
@pytest.mark.parametrize("inside", ["", "sparse/0", "sparse", "0"])
def test_every_file_that_is_opened_is_an_input(
    tmp_path: Path, opened: list[str], write: Any, inside: str
) -> None:
    model, pictures = tmp_path / "colmap", write_photos(tmp_path / "pictures")
    write(model / inside)
    (model / "offset.txt").write_text("1 2 3\n")
    (pictures / "notes.txt").write_text("not a picture")
    opened.clear()  # of the files that were written
    table = {"path": str(pictures), "cameras": str(model)}
    project = make_project({"photos": table, "scans": [{"path": "scan.las"}]}, tmp_path)
    source = project.photos
    assert source is not None and source.offset == (1.0, 2.0, 3.0)
    found = read_photos(source, LOCAL)
    for photo in found.photos:
        found.image(photo.id)
    read = {Path(name) for name in opened if name.startswith(str(tmp_path))}
    assert len(read) == 5, "two pictures, cameras, images, offset"
    assert read == set(photo_inputs(source))


def test_the_inputs_of_an_embedded_photo_are_the_file_that_holds_it(tmp_path: Path) -> None:
    file = tmp_path / "scan.e57"
    file.write_bytes(b"ASTM-E57")
    assert photo_inputs(PhotoSource(path=str(file))) == (file,)
    assert photo_inputs(PhotoSource(path=str(file), cameras=str(tmp_path / "unused"))) == (file,)


def test_inputs_that_are_missing_are_told(tmp_path: Path) -> None:
    pictures = write_photos(tmp_path / "pictures")
    with pytest.raises(FileError, match="no photos"):
        photo_inputs(PhotoSource(path=str(tmp_path / "none")))
    with pytest.raises(FileError, match="holds no COLMAP model"):
        photo_inputs(PhotoSource(path=str(pictures), cameras=str(tmp_path / "none")))
    model = write_colmap_text(tmp_path / "model")
    (model / "images.txt").unlink()
    with pytest.raises(FileError, match=r"images\.txt: no such file"):
        photo_inputs(PhotoSource(path=str(pictures), cameras=str(model)))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_refused(bad: float) -> None:
    for name in ("offset", "sigma_position", "sigma_angle"):
        with pytest.raises(ValidationError, match="finite"):
            PhotoSource(path="photos", **{name: (0.0, bad, 0.0) if name == "offset" else bad})
    for name in ("offset", "sigma_position", "sigma_heading", "sigma_level", "sigma_range"):
        with pytest.raises(ValidationError, match="finite"):
            ScanSource(path="scan.las", **{name: (0.0, bad, 0.0) if name == "offset" else bad})


def test_half_a_turn_that_the_size_does_not_tell_is_doubtful(tmp_path: Path) -> None:
    model, pictures = write_colmap_text(tmp_path / "model"), write_photos(tmp_path / "pictures")
    source = PhotoSource(path=str(pictures), cameras=str(model))
    assert read_photos(source, LOCAL).turns == {}
    for orientation in range(1, 9):
        turned = orientation >= 5
        size = (40, 60) if turned else (60, 40)
        (pictures / "a.jpg").write_bytes(picture(*size, orientation))
        found = read_photos(source, LOCAL)
        assert set(found.turns) == ({"a.jpg"} if orientation in (2, 3, 4) else set())
        assert found.image("a.jpg").shape == (40, 60, 3)
        for name, turn in found.turns.items():
            assert np.array_equal(turn(found.image(name)), upright(found.image(name), orientation))
    (model / "cameras.txt").write_text("7 PINHOLE 50 50 50 50 25 25\n")
    (pictures / "sub" / "b.jpg").write_bytes(picture(50, 50))
    (pictures / "a.jpg").write_bytes(picture(50, 50, 6))
    assert set(read_photos(source, LOCAL).turns) == {"a.jpg"}, "the size of a square tells nothing"
