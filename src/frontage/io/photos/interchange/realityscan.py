"""RealityScan's (RealityCapture's) "Internal/External camera parameters", a CSV file.

Conventions: x, y, alt is the position in the coordinates of the export. The camera has x right, y up and z
backwards, and ``Rz(-heading) Rx(pitch) Ry(roll)``, in degrees, leads from it to the world: a photo with zero
angles looks down with its top to the north, and one with pitch 90 to the horizon. This gives the matrix that
the program writes into its XMP files (Unreal Engine forum, "Different rotation of cameras in XMP and CSV"),
and nerfstudio reads the angles so. f is the focal length on a film 36 mm wide, ``f max(w, h) / 36`` px;
px and py are the offset of the principal point from the centre of the picture in shares of max(w, h). k1..k4
and t1, t2 are the distortion of `Calibration`, with t1, t2 for p1, p2 as nerfstudio takes them.
"""

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.io.files import reading, require_file, whole_file
from frontage.io.photos.interchange.calibration import Calibration, of_camera, refused
from frontage.io.photos.interchange.tables import Names, has_header, numbers, read_table
from frontage.io.photos.match import Posed, matched_files, photo_set, stored_size
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.request import PhotoRequest
from frontage.model import Camera, Photo, WorldRef

_POSE = ("x", "y", "alt", "heading", "pitch", "roll")
_LENS = ("f", "px", "py", "k1", "k2", "k3", "k4", "t1", "t2")
_COLUMNS = ("name", *_POSE, *_LENS)
_NAMES: Names = {column: (column,) for column in _COLUMNS}
_FILM_MM = 36.0
_UP_BACK = np.diag([1.0, -1.0, -1.0])  # between y up, z backwards and y down, z forward
_SQUARE = 1e-9  # relative difference of focal lengths that is none
_NAME = "RealityScan CSV"


def read_realityscan(request: PhotoRequest) -> PhotoSet:
    """The photos of a RealityScan table, with the names in it as ids, in the coordinates of the run.

    The size of a photo, which the file does not state, is that of its picture.

    Raises FileError (missing, damaged, no photos, a distortion that cannot be represented).
    """
    path = require_file(str(request.cameras))
    with reading(path, _NAME):
        rows = read_table(path, _NAMES, ("name", *_POSE, "f")).rows
        if not rows:
            raise FileError(path, "lists no photos", "export the table again", code="I105")
        poses = [_pose(row) for row in rows]
        lenses = [numbers({c: row.get(c, "0") for c in _LENS}, _LENS, row["name"]) for row in rows]
    matched = matched_files([row["name"] for row in rows], request.files, path)
    posed: list[Posed] = []
    notes: dict[str, None] = {}
    for row, pose, lens in zip(rows, poses, lenses, strict=True):
        size = stored_size(matched[row["name"]])
        with reading(path, _NAME):
            camera, said = _camera(size, lens)
        notes |= {f"{path.name}: {sentence}": None for sentence in said}
        posed.append((row["name"], camera, pose))
    return photo_set(request, posed, notes)


def _pose(row: dict[str, str]) -> Rigid3:
    name = row["name"]
    if not name:
        raise ValueError("a row has no name of a photo")
    x, y, z, *angles = numbers(row, _POSE, name)
    return Rigid3("file", "camera", rotation_of(*np.radians(angles).tolist()), np.array([x, y, z]))


def rotation_of(heading: float, pitch: float, roll: float) -> Float:
    """The rotation (3, 3) from a camera with y down and z forward to the world, of angles in rad."""
    (sh, sp, sr), (ch, cp, cr) = np.sin([heading, pitch, roll]), np.cos([heading, pitch, roll])
    Rz = np.array([[ch, sh, 0.0], [-sh, ch, 0.0], [0.0, 0.0, 1.0]])  # by -heading
    Rx = np.array([[1.0, 0.0, 0.0], [0.0, cp, -sp], [0.0, sp, cp]])
    Ry = np.array([[cr, 0.0, sr], [0.0, 1.0, 0.0], [-sr, 0.0, cr]])
    turned: Float = Rz @ Rx @ Ry @ _UP_BACK
    return turned


def angles_of(R: Float) -> tuple[float, float, float]:
    """heading, pitch, roll in rad of a rotation (3, 3) as `rotation_of` makes it.

    At the horizon only the sum or the difference of heading and roll counts. Roll is taken first and the
    others from what it leaves, which loses no digits near there.
    """
    M = R @ _UP_BACK
    roll = float(np.arctan2(-M[2, 0], M[2, 2])) if np.hypot(M[2, 0], M[2, 2]) > 0 else 0.0
    s, c = np.sin(roll), np.cos(roll)
    rest = M @ np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
    return float(np.arctan2(-rest[1, 0], rest[0, 0])), float(np.arctan2(rest[2, 1], rest[2, 2])), roll


def _camera(size: tuple[int, int], lens: list[float]) -> tuple[Camera, tuple[str, ...]]:
    f, px, py, k1, k2, k3, k4, t1, t2 = lens
    (w, h), unit = size, max(size)
    focal, centre = f * unit / _FILM_MM, (w / 2 + px * unit, h / 2 + py * unit)
    return Calibration("frame", w, h, (focal, focal), centre, (k1, k2, k3, k4), (t1, t2)).camera()


def write_realityscan(path: Path, photos: Sequence[Photo], world: WorldRef) -> Path:
    """Write a RealityScan table in world coordinates.

    Raises InputError for a camera that is no frame camera with one focal length, and FileError when the file
    cannot be written.
    """
    out = io.StringIO()
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(("#name", *_COLUMNS[1:]))
    for photo in photos:
        c = of_camera(photo.camera, _NAME)
        if c.kind != "frame" or abs(c.focal[0] / c.focal[1] - 1) > _SQUARE:
            raise refused(photo.camera, _NAME, "is no frame camera with one focal length")
        unit = max(c.width, c.height)
        offset = ((c.centre[0] - c.width / 2) / unit, (c.centre[1] - c.height / 2) / unit)
        angles = np.degrees(angles_of(photo.pose.R)).tolist()
        place = world.to_world(photo.pose.t).tolist()
        values = (*place, *angles, c.focal[0] * _FILM_MM / unit, *offset, *c.radial, *c.tangential)
        rows.writerow((photo.id, *(repr(float(v)) for v in values)))
    with whole_file(path) as temporary:
        temporary.write_text(out.getvalue(), "utf-8")
    return path


def looks_like_realityscan(path: Path) -> bool:
    """Whether a file has the columns of this table."""
    return path.suffix.lower() in (".csv", ".txt") and has_header(path, _NAMES, ("name", *_POSE, "f"))


def realityscan_files(path: Path) -> tuple[Path, ...]:
    """The files that `read_realityscan` opens. Raises FileError when it is missing."""
    return (require_file(path),)
