"""Files written whole or not at all, and fingerprints of what they were made from."""

import hashlib
import json
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import frontage
from frontage.errors import FileError
from frontage.geometry.arrays import Array
from frontage.io.files import whole_file


def text_of(path: Path, hint: str) -> str:
    """The text of a file that a user names. Raises FileError with `hint` when there is none to read."""
    try:
        return path.read_text("utf-8")
    except FileNotFoundError:
        raise FileError(path, "no such file", hint) from None
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, f"cannot be read as text ({error})", hint) from None


def write_bytes(path: Path, data: bytes) -> None:
    """Write under a temporary name beside `path`, then rename: a reader never sees half a file."""
    write_with(path, lambda temporary: temporary.write_bytes(data))


def write_with(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` make the file under a temporary name, then rename it to `path`; its folder is made too."""
    with whole_file(path) as temporary:
        write(temporary)


def write_array(path: Path, array: Array) -> None:
    """Write one array as .npy (no pickle)."""

    def write(temporary: Path) -> None:
        with temporary.open("wb") as file:
            np.save(file, array, allow_pickle=False)

    write_with(path, write)


def write_arrays(path: Path, arrays: Mapping[str, Array]) -> None:
    """Write named arrays as .npz (uncompressed, no pickle)."""

    def write(temporary: Path) -> None:
        with temporary.open("wb") as file:
            np.savez(file, allow_pickle=False, **arrays)

    write_with(path, write)


def write_json(path: Path, value: Any) -> None:
    """Write JSON (UTF-8, indented, numbers with all their digits)."""
    write_bytes(path, (json.dumps(value, indent=1, ensure_ascii=False) + "\n").encode())


def read_json(path: Path) -> Any:
    """Read JSON; raises ValueError when it is none."""
    return json.loads(path.read_text("utf-8"))


def fingerprint(*parts: Any) -> str:
    """Sixteen hex digits that change when any of the JSON-able parts changes."""
    text = json.dumps(parts, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def file_hash(path: Path) -> str:
    """SHA-256 of a file's bytes, as hex digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@cache
def code_hash(packages: tuple[str, ...]) -> str:
    """Fingerprint of the source of sub-packages: results made by other code are not taken for current."""
    root = Path(frontage.__file__).parent
    digest = hashlib.sha256(frontage.__version__.encode())
    for package in sorted(packages):
        for source in sorted((root / package).rglob("*")):
            if source.suffix in (".py", ".html", ".css"):
                digest.update(source.read_bytes())
    return digest.hexdigest()[:16]
