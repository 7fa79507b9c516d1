"""Files written whole or not at all, JSON, and fingerprints."""

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from frontage.geometry.arrays import Array
from frontage.io.files import whole_file

_BLOCK = 1 << 20  # bytes read at a time


def write_bytes(path: Path, data: bytes) -> None:
    """Write under a temporary name beside `path`, then rename: a reader never sees half a file."""
    write_with(path, lambda temporary: temporary.write_bytes(data))


def write_with(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` make the file under a temporary name, then rename it to `path`. Creates the folder."""
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
    """Read JSON. Raises OSError if the file cannot be read, ValueError if it is not JSON."""
    try:
        return json.loads(path.read_text("utf-8"))
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def fingerprint(*parts: Any) -> str:
    """Return sixteen hex digits that change when any of the JSON-able parts changes."""
    text = json.dumps(parts, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def file_hash(path: Path) -> str:
    """Return the SHA-256 of a file's bytes, as hex digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def checksum(path: Path) -> str:
    """Return a fast checksum (BLAKE2b, 128 bits) of a file's bytes, as hex digits."""
    digest = hashlib.blake2b(digest_size=16)
    with path.open("rb") as file:
        while block := file.read(_BLOCK):
            digest.update(block)
    return digest.hexdigest()


def flush(paths: Iterable[Path]) -> None:
    """Make files, and the entries of their folders, durable: they survive a loss of power after this."""
    files = list(paths)
    folders = (folder for path in files for folder in (path.parent, path.parent.parent))
    for path in (*files, *dict.fromkeys(folders)):
        handle = os.open(path, os.O_RDONLY)
        try:
            os.fsync(handle)
        except OSError:  # some network file systems refuse to flush folders
            if path.is_file():
                raise
        finally:
            os.close(handle)
