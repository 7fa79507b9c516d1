"""The registry of scan formats. A new format is one module with a reader, and one entry here."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from frontage.errors import FileError
from frontage.io.scans.request import ScanRequest
from frontage.model import Scan

Reader = Callable[[Path, ScanRequest], list[Scan]]
Inputs = Callable[[Path, ScanRequest], tuple[Path, ...]]


@dataclass(frozen=True)
class ScanFormat:
    """A kind of scan file.

    name      as users know it
    suffixes  of its files, lower case
    holds     what a file of it can hold besides the coordinates of its points
    reader    "module:function", imported when it is first used
    opens     "module:function" that lists every file the reader opens; None = the file itself and no other
    stem      the only file name (without suffix) that the format uses; None = any
    measured  whether its origins are positions of a scanner that the file states, and are tested
    internal  whether only Frontage writes it, so that messages do not recommend it
    """

    name: str
    suffixes: tuple[str, ...]
    holds: str
    reader: str
    opens: str | None = None
    stem: str | None = None
    measured: bool = True
    internal: bool = False

    def read(self, path: Path, request: ScanRequest) -> list[Scan]:
        """The scans of a file of this format."""
        reader: Reader = _function(self.reader)
        return reader(path, request)

    def inputs(self, path: Path, request: ScanRequest) -> tuple[Path, ...]:
        """Every file that `read` opens for this path, the files that stand beside it included.

        Files that the request names are listed even when they do not exist.

        Raises FileError for a folder without the files of this format.
        """
        if self.opens is None:
            return (path,)
        opened: Inputs = _function(self.opens)
        return opened(path, request)

    def fits(self, path: Path) -> bool:
        """Whether a file belongs to this format, by its name."""
        named = self.stem is None or path.stem.lower() == self.stem
        return named and path.suffix.lower() in self.suffixes


def _function(name: str) -> Any:
    """The function "module:function"."""
    module, function = name.split(":")
    return getattr(import_module(module), function)


_SCANS = "frontage.io.scans"

FORMATS = (
    ScanFormat(
        "LAS",
        (".las", ".laz"),
        "one cloud of any LAS version, LAZ or COPC: intensity, colour, GPS time, returns, source ids, CRS",
        f"{_SCANS}.las:read_las",
        opens=f"{_SCANS}.las:las_files",
    ),
    ScanFormat(
        "E57",
        (".e57",),
        "several scans: pose, scan grid with beams that did not return, intensity, colour, time, CRS",
        f"{_SCANS}.e57:read_e57",
    ),
    ScanFormat(
        "PTX",
        (".ptx",),
        "several scans: pose, scan grid with beams that did not return, intensity, colour",
        f"{_SCANS}.ptx:read_ptx",
    ),
    ScanFormat(
        "PLY",
        (".ply",),
        "one cloud, ascii or binary: intensity, colour, time, sensor position per point",
        f"{_SCANS}.ply:read_ply",
    ),
    ScanFormat(
        "PCD",
        (".pcd",),
        "one cloud, ascii, binary or compressed: intensity, colour, time, viewpoint",
        f"{_SCANS}.pcd:read_pcd",
    ),
    ScanFormat(
        "COLMAP points3D",
        (".txt", ".bin"),
        "the sparse points of a COLMAP model: colour, and the first photo of each track as its origin",
        "frontage.io.colmap:read_colmap_points",
        opens="frontage.io.colmap:colmap_point_files",
        stem="points3d",
        measured=False,
    ),
    ScanFormat(
        "point table",
        (".xyz", ".csv", ".txt", ".asc", ".pts"),
        "one cloud as text: intensity, colour, time",
        f"{_SCANS}.xyz:read_xyz",
    ),
    ScanFormat(
        "Frontage scan",
        (".npz",),
        "one scan of a run folder with everything that Frontage knows of it",
        f"{_SCANS}.npz:read_npz",
        measured=False,
        internal=True,
    ),
)
"""Every format, in the order in which they are tried."""

COLMAP_FOLDER = next(f for f in FORMATS if f.stem is not None)
"""The format that a folder is read with."""

SUFFIXES = tuple(dict.fromkeys(suffix for f in FORMATS for suffix in f.suffixes))
"""The suffixes of all scan files."""


def scan_format(path: Path) -> ScanFormat:
    """The format of a scan file, by its name; a folder must be a COLMAP model.

    Raises FileError when the file does not exist or belongs to no format.
    """
    if os.path.isdir(path):  # False, too, for a path that the system does not accept
        return COLMAP_FOLDER
    found = next((f for f in FORMATS if f.fits(path)), None)
    if found is not None:
        return found
    known = dict.fromkeys(suffix for f in FORMATS if not f.internal for suffix in f.suffixes)
    raise FileError(
        path,
        f"the suffix {path.suffix!r} is not one of a scan format" if os.path.exists(path) else "no such file",
        "Frontage reads " + ", ".join(known),
        code="I101",
    )
