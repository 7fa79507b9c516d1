"""Tables of positions and of the angles omega, phi, kappa: Pix4D, Metashape, MicMac and others.

Convention (Pix4D support, "How are the internal and external camera parameters defined?"; ArcGIS Reality
Studio, "Coordinate system conventions"; MicMac, OriExport): ``R = Rx(omega) Ry(phi) Rz(kappa)``, counter-
clockwise and about the turned axes, leads from the camera to the world; the camera has x right, y up and z
backwards, so that zero angles mean a photo that looks down with its top to the north.

Angles are in degrees unless the names of the columns (`omega[gon]`) or a line above them ("angles: gon") say
gon or rad. Columns in the order phi, omega, kappa stand for another sequence of turns and are refused.
"""

import re
from pathlib import Path

import numpy as np

from frontage.errors import FileError, UnsupportedFormat
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.io.crs import parse_crs
from frontage.io.files import reading, require_file
from frontage.io.photos.interchange.georeference import recognised, to_world
from frontage.io.photos.interchange.pix4d import camera_file, cameras_beside
from frontage.io.photos.interchange.tables import Names, Table, has_header, numbers, read_table
from frontage.io.photos.match import Posed, matched_files, photo_set, stored_size
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.request import PhotoRequest

_NAMES: Names = {
    "name": ("imagename", "image name", "image_name", "image", "name", "label", "photo", "photoid",
             "filename", "file name", "file", "picture", "id"),
    "x": ("x", "easting", "east", "e", "x0"),
    "y": ("y", "northing", "north", "n", "y0"),
    "z": ("z", "alt", "altitude", "height", "elevation", "h", "z0"),
    "omega": ("omega", "ω"),
    "phi": ("phi", "φ"),
    "kappa": ("kappa", "κ"),
    "camera": ("camera", "camera_id", "cameraid", "camera id"),
}  # fmt: skip
_POSITION, _ANGLES = ("x", "y", "z"), ("omega", "phi", "kappa")
_NEEDED = ("name", *_POSITION, *_ANGLES)
_RADIANS = {"deg": np.pi / 180, "gon": np.pi / 200, "rad": 1.0}
_FULL_TURN = {"deg": 360.0, "gon": 400.0, "rad": 2 * np.pi}
_SAID = re.compile(r"\bangles?\b.*?\b(gon|grad|deg|rad)", re.IGNORECASE)
_SYSTEM = re.compile(r"#?\s*CoordinateSystem:\s*(.+)", re.IGNORECASE)
_UP_BACK = np.diag([1.0, -1.0, -1.0])  # between y up, z backwards and y down, z forward
_KIND = "table of omega, phi, kappa"


def read_opk(request: PhotoRequest) -> PhotoSet:
    """The photos of a table, with the names in it as ids, in the coordinates of the run.

    The cameras come from Pix4D's or COLMAP's files beside it. A table that states its CRS (Metashape) is
    taken to that of the run.

    Raises FileError (missing, damaged, no cameras beside it, unknown order of the angles) and CrsError.
    """
    path = require_file(str(request.cameras))
    with reading(path, _KIND):
        table = read_table(path, _NAMES, _NEEDED)
        if not table.rows:
            raise FileError(path, "lists no photos", "export the table again", code="I105")
        poses = [_pose(row, _unit(path, table)) for row in table.rows]
        poses, notes = _in_world(path, table, poses, request)
    camera_of = cameras_beside(path)
    names = [row["name"] for row in table.rows]
    matched = matched_files(names, request.files, path)
    posed: list[Posed] = []
    for row, pose in zip(table.rows, poses, strict=True):
        name = row["name"]
        posed.append((name, camera_of(name, row.get("camera"), stored_size(matched[name])), pose))
    return photo_set(request, posed, notes)


def rotation_of(omega: float, phi: float, kappa: float) -> Float:
    """The rotation (3, 3) from a camera with y down and z forward to the world, of angles in rad."""
    (so, sp, sk), (co, cp, ck) = np.sin([omega, phi, kappa]), np.cos([omega, phi, kappa])
    turned: Float = np.array(
        [
            [cp * ck, -cp * sk, sp],
            [co * sk + so * sp * ck, co * ck - so * sp * sk, -so * cp],
            [so * sk - co * sp * ck, so * ck + co * sp * sk, co * cp],
        ]
    )
    return turned @ _UP_BACK


def angles_of(R: Float) -> tuple[float, float, float]:
    """omega, phi, kappa in rad of a rotation (3, 3) as `rotation_of` makes it.

    Where the camera looks straight east or west only the sum or the difference of omega and kappa counts.
    Omega is taken first and the others from what it leaves, which loses no digits near there.
    """
    M = R @ _UP_BACK
    omega = float(np.arctan2(-M[1, 2], M[2, 2])) if np.hypot(M[1, 2], M[2, 2]) > 0 else 0.0
    s, c = np.sin(omega), np.cos(omega)
    rest = np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]]) @ M
    return omega, float(np.arctan2(rest[0, 2], rest[2, 2])), float(np.arctan2(rest[1, 0], rest[1, 1]))


def _unit(path: Path, table: Table) -> str:
    """The unit of the angles. Raises UnsupportedFormat for an order of angles that is not known."""
    order = tuple(n for n in table.order if n in _ANGLES)
    if order != _ANGLES:
        raise UnsupportedFormat(
            path,
            f"its angles stand in the order {', '.join(order)}, which can mean another sequence of turns",
            "export the angles omega, phi, kappa in this order",
        )
    said = [m[1].lower() for line in table.comments if (m := _SAID.search(line))]
    stated = {table.units[a] for a in _ANGLES if a in table.units} or {*said[:1]} or {"deg"}
    unit = stated.pop().replace("grad", "gon")
    if stated or unit not in _RADIANS:
        raise ValueError("its angles have no common unit among deg, gon and rad")
    return unit


def _pose(row: dict[str, str], unit: str) -> Rigid3:
    name = row["name"]
    if not name:
        raise ValueError("a row has no name of a photo")
    angles = numbers(row, _ANGLES, name)
    if max(map(abs, angles)) > _FULL_TURN[unit]:
        raise ValueError(f"an angle of {name} is beyond a full turn in {unit}; state the unit in the header")
    R = rotation_of(*(a * _RADIANS[unit] for a in angles))
    return Rigid3("file", "camera", R, np.array(numbers(row, _POSITION, name)))


def _in_world(
    path: Path, table: Table, poses: list[Rigid3], request: PhotoRequest
) -> tuple[list[Rigid3], tuple[str, ...]]:
    """The poses in the world of the run; those of a table without a CRS are in it already."""
    stated = next((m[1] for line in table.comments if (m := _SYSTEM.match(line))), "").strip()
    if not stated or stated.upper().startswith("LOCAL_CS"):
        return poses, ()
    source = recognised(parse_crs(stated, str(path)))
    if not source.is_projected and not source.is_compound:
        raise UnsupportedFormat(path, f"its positions are in {source.name}", "export them in a projected CRS")
    moved = to_world(path.name, source, source, poses, request.world)
    return list(moved.poses), moved.notes


def looks_like_opk(path: Path) -> bool:
    """Whether a file is a text table: it names the angles, or its suffix is that of a table."""
    table = path.suffix.lower() in (".csv", ".txt", ".opk", ".tsv", ".dat") and not path.is_dir()
    return table and (
        not path.is_file() or has_header(path, _NAMES, _ANGLES) or path.suffix.lower() != ".txt"
    )


def opk_files(path: Path) -> tuple[Path, ...]:
    """The files that `read_opk` opens. Raises FileError when there are no cameras beside the table."""
    return require_file(path), camera_file(path)
