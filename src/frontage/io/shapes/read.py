"""Any file with faces, as features to validate: the one entry for the validator."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from frontage.errors import OptionError
from frontage.io.files import reading, require_file
from frontage.io.shapes.formats import ADVICE, FaceFormat, face_format, solid_format
from frontage.model import Feature, Polygons, Shape

Primitive = Literal["Solid", "CompositeSurface", "MultiSurface"]


def read_shapes(
    path: str | Path, primitive: Primitive = "Solid", inner: Sequence[str | Path] = ()
) -> tuple[str, list[Feature]]:
    """Read the features of a file; returns them with the name of the format.

    CityJSON 1.0 to 2.0, CityJSONSeq, CityGML 1 to 3 and other GML, JSON-FG and tu3djson files state
    themselves what they hold. OBJ, OFF and POLY files hold faces only: `primitive` says what these are meant
    to be, and `inner` names further such files with the inner shells of the solid.

    Raises FileError (missing, empty, corrupt, unsupported), and OptionError when `inner` does not apply.
    """
    faces = face_format(Path(path))
    p = _require(path, faces)
    if faces is None and inner:
        raise OptionError(f"{p}: states its inner shells itself; leave --inner out")
    with reading(p, "model", ADVICE):
        if faces is None:
            return solid_format(p).read(p)
        objects = faces.read(p)
    voids = tuple(_one_shell(q) for q in inner)
    if voids and primitive != "Solid":
        raise OptionError(f"a {primitive} has no inner shells; leave --inner out")
    kind = p.suffix[1:].upper()
    shapes = [(label or p.stem, Shape(primitive, ((surfaces, *voids),))) for label, surfaces in objects]
    return kind, [Feature(name, kind, (shape,)) for name, shape in shapes]


def _require(path: str | Path, faces: FaceFormat | None) -> Path:
    """The path of a file, checked; one without a header may hold nothing. Raises FileError."""
    p = Path(path)
    if faces is not None and not faces.headed and p.is_file() and p.stat().st_size == 0:
        return p
    return require_file(p)


def _one_shell(path: str | Path) -> Polygons:
    """The shell of a file that holds exactly one."""
    p = require_file(path)
    with reading(p, "model", "name an OBJ, OFF or POLY file"):
        found = face_format(p)
        objects = [] if found is None else found.read(p)
        if len(objects) != 1:
            raise ValueError("an inner shell must be a single OBJ, OFF or POLY object")
        return objects[0][1]
