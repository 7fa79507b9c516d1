"""The files of a COLMAP model: where they are, and how their text and their binary records begin."""

import struct
from pathlib import Path

from frontage.errors import FileError
from frontage.io.files import require_file, require_length


def model_folder(folder: str | Path) -> Path:
    """The folder that holds the files of a model: this one or one inside it. Raises FileError without any."""
    base = Path(folder)
    for place in (base, base / "sparse" / "0", base / "sparse", base / "0"):
        if any(
            (place / f"{name}.{kind}").is_file()
            for name in ("cameras", "points3D")
            for kind in ("bin", "txt")
        ):
            return place
    raise FileError(
        base,
        "holds no COLMAP model (cameras.txt or cameras.bin)",
        "name the folder that holds one",
        code="I101",
    )


def part_of(folder: Path, name: str) -> Path:
    """The binary file of a part of the model where there is one, else the text file. Raises FileError."""
    return require_file(found_part(folder, name) or folder / f"{name}.txt")


def found_part(folder: Path, name: str) -> Path | None:
    """The file of a part of the model, binary where there are both; None where there is neither."""
    files = [folder / f"{name}.{kind}" for kind in ("bin", "txt")]
    return next((f for f in files if f.is_file()), None)


def lines_of(path: Path) -> list[str]:
    """Lines without comments; blank lines stay, because they stand for an image without points."""
    return [line for line in path.read_text("utf-8").splitlines() if not line.startswith("#")]


def count_of(path: Path, data: bytes, what: str, least: int) -> int:
    """The number of records that the file begins with, checked; a record needs `least` bytes or more."""
    (count,) = struct.unpack_from("<Q", data)
    require_length(path, f"{count} {what}", count * least, len(data) - 8)
    return int(count)
