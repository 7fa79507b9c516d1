"""Any file with faces, as features to validate; told by its content, then by its name."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from frontage.errors import OptionError, UnsupportedFormat
from frontage.io.files import reading, require_file
from frontage.io.shapes.facefiles import read_obj, read_off
from frontage.io.shapes.gml import read_gml
from frontage.io.shapes.json import read_json
from frontage.io.shapes.polyfile import read_poly
from frontage.model import Feature, Polygons, Shape

Primitive = Literal["Solid", "CompositeSurface", "MultiSurface"]
_ADVICE = "name a CityJSON, CityGML, OBJ, OFF or POLY file"


def read_shapes(
    path: str | Path, primitive: Primitive = "Solid", inner: Sequence[str | Path] = ()
) -> tuple[str, list[Feature]]:
    """The format's name and the features of a file.

    CityJSON 1.0 to 2.0, CityJSONSeq, CityGML 1 to 3 and other GML, JSON-FG, tu3djson say themselves what
    they hold. OBJ, OFF and POLY hold faces: `primitive` says what they are meant to be, `inner` names further
    such files with the inner shells of the solid.

    Raises FileError (missing, empty, corrupt, unsupported), OptionError (`inner` with another format).
    """
    p = require_file(path)
    with reading(p, "model", _ADVICE):
        objects = _faces(p)
        if objects is None and not inner:
            return _structured(p)
    if objects is None:
        raise OptionError(f"{p}: says itself what its inner shells are; leave --inner away")
    voids = tuple(_one_shell(q) for q in inner)
    if voids and primitive != "Solid":
        raise OptionError(f"a {primitive} has no inner shells; leave --inner away")
    kind = p.suffix[1:].upper()
    shapes = [(label or p.stem, Shape(primitive, ((surfaces, *voids),))) for label, surfaces in objects]
    return kind, [Feature(name, kind, (shape,)) for name, shape in shapes]


def _one_shell(path: str | Path) -> Polygons:
    """A file with one shell in it."""
    p = require_file(path)
    with reading(p, "model", "name an OBJ, OFF or POLY file"):
        objects = _faces(p)
        if objects is None or len(objects) != 1:
            raise ValueError("an inner shell must be one OBJ, OFF or POLY object")
        return objects[0][1]


def _faces(path: Path) -> list[tuple[str, Polygons]] | None:
    """The objects of a file of faces; None for the formats that know solids."""
    suffix = path.suffix.lower()
    if suffix == ".obj":
        return read_obj(path)
    if suffix == ".off":
        return [("", read_off(path))]
    return [("", read_poly(path))] if suffix == ".poly" else None


def _structured(path: Path) -> tuple[str, list[Feature]]:
    with open(path, "rb") as f:
        head = f.read(4096).lstrip(b"\xef\xbb\xbf \t\r\n")
    if head[:1] == b"<":
        return read_gml(path)
    if head[:1] in (b"{", b"[") or path.suffix.lower() in (".json", ".jsonl"):
        return read_json(path)
    raise UnsupportedFormat(path, "is of no format that can be validated", _ADVICE)
