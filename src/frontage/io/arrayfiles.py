"""Arrays in .npy and .npz files (NumPy's format), whose headers are checked before they are believed.

Frontage writes arrays uncompressed, so no honest file needs more memory than it has bytes. Headers that state
other sizes, compressed members and pickled objects are refused.
"""

import math
import zipfile
from pathlib import Path
from typing import IO

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array
from frontage.io.files import brief

_HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}


def read_arrays(path: Path, advice: str) -> dict[str, Array]:
    """Return the arrays of a .npz file. Raises FileError with `advice` if it is missing or damaged."""
    try:
        with zipfile.ZipFile(path) as archive:
            return {
                info.filename.removesuffix(".npy"): _member(archive, info)
                for info in archive.infolist()
                if not info.is_dir()
            }
    except FileNotFoundError:
        raise FileError(path, "no such file", advice) from None
    except Exception as error:  # zipfile, zlib and numpy have errors of their own
        raise FileError(path, f"is damaged ({brief(error)})", advice) from None


def read_array(path: Path, advice: str) -> Array:
    """Return the array of a .npy file. Raises FileError with `advice` if it is missing or damaged."""
    try:
        size = path.stat().st_size
        with path.open("rb") as file:
            return _array(file, size)
    except FileNotFoundError:
        raise FileError(path, "no such file", advice) from None
    except Exception as error:
        raise FileError(path, f"is damaged ({brief(error)})", advice) from None


def _member(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Array:
    if info.compress_type != zipfile.ZIP_STORED:
        raise ValueError(f"{info.filename} is compressed")
    with archive.open(info) as file:
        return _array(file, info.file_size)


def _array(file: IO[bytes], size: int) -> Array:
    """Read an array from a file of `size` bytes. Raises ValueError unless header and size agree."""
    version = np.lib.format.read_magic(file)
    if version not in _HEADERS:
        raise ValueError(f"version {version} of the array format is not known")
    shape, _, dtype = _HEADERS[version](file)
    if dtype.hasobject:
        raise ValueError("it holds pickled objects")
    count, body = math.prod(shape), size - file.tell()
    if min(shape, default=0) < 0 or count * dtype.itemsize != body:
        raise ValueError(f"{body} bytes are no {dtype} array of shape {shape}")
    file.seek(0)
    return np.asarray(np.lib.format.read_array(file, allow_pickle=False))
