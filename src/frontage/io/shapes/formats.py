"""The registry of formats that can be validated: a new format is one module and one entry here."""

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from frontage.errors import UnsupportedFormat
from frontage.model import Feature, Polygons

ADVICE = "name a CityJSON, CityGML, OBJ, OFF or POLY file"
_HEAD_BYTES = 4096  # that are examined to tell a format
_IGNORED = b"\xef\xbb\xbf \t\r\n"  # byte order mark and blanks


@dataclass(frozen=True)
class FaceFormat:
    """Files of faces that do not state whether these form a solid.

    name    as users know it
    suffix  of its files, lower case
    reader  "module:function" that returns the named objects of a file, imported when it is first used
    headed  whether its files begin with a header, so that a file of no bytes is damaged, not empty
    """

    name: str
    suffix: str
    reader: str
    headed: bool = True

    def read(self, path: Path) -> list[tuple[str, Polygons]]:
        """The objects of a file, each with its name ("" without one)."""
        objects: list[tuple[str, Polygons]] = _function(self.reader)(path)
        return objects


@dataclass(frozen=True)
class SolidFormat:
    """Files that state which faces form solids, and which objects these belong to.

    name      as users know it
    suffixes  that tell the format where the content does not
    begins    what such a file may begin with
    reader    "module:function" that returns the format's full name and the features of a file
    """

    name: str
    suffixes: tuple[str, ...]
    begins: tuple[bytes, ...]
    reader: str

    def read(self, path: Path) -> tuple[str, list[Feature]]:
        """The name of the format, with its version where the file states one, and the features of a file."""
        found: tuple[str, list[Feature]] = _function(self.reader)(path)
        return found


def _function(reader: str) -> Any:
    module, function = reader.split(":")
    return getattr(import_module(module), function)


_SHAPES = "frontage.io.shapes"

FACE_FORMATS = (
    FaceFormat("OBJ", ".obj", f"{_SHAPES}.facefiles:read_obj", headed=False),
    FaceFormat("OFF", ".off", f"{_SHAPES}.facefiles:read_off"),
    FaceFormat("POLY", ".poly", f"{_SHAPES}.polyfile:read_poly"),
)

SOLID_FORMATS = (
    SolidFormat("CityGML, GML or IndoorGML", (), (b"<",), f"{_SHAPES}.gmlfile:read_gml"),
    SolidFormat(
        "CityJSON, CityJSONSeq, JSON-FG or tu3djson",
        (".json", ".jsonl"),
        (b"{", b"["),
        f"{_SHAPES}.jsonfile:read_json",
    ),
)


def face_format(path: Path) -> FaceFormat | None:
    """The format of a file of faces, by its suffix; None for every other file."""
    return next((f for f in FACE_FORMATS if f.suffix == path.suffix.lower()), None)


def solid_format(path: Path) -> SolidFormat:
    """The format of a file with solids, by its content and then by its suffix.

    Raises UnsupportedFormat when it is none of the registry's.
    """
    with open(path, "rb") as f:
        head = f.read(_HEAD_BYTES).lstrip(_IGNORED)
    for found in SOLID_FORMATS:
        if head.startswith(found.begins) or path.suffix.lower() in found.suffixes:
            return found
    raise UnsupportedFormat(path, "is of no format that can be validated", ADVICE)
