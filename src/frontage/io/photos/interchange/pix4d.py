"""The cameras beside a table of omega, phi, kappa: Pix4D's files, or the cameras.txt of a COLMAP model.

Pix4D (support, "How are the internal and external camera parameters defined?") has the distortion of OpenCV
with R1, R2, R3 and T1, T2 for k1, k2, k3 and p1, p2. `*_calibrated_camera_parameters.txt` states the matrix K
of every photo in pixels, `*_pix4d_calibrated_internal_camera_parameters.cam` one camera in millimetres on a
sensor whose width it states. Pix4D does not publish whether the first pixel has its corner or its centre at
the origin of K; it is taken to be the corner, where the principal point of an ideal camera is half the size.
"""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from frontage.errors import FileError
from frontage.geometry.camera import parameter_count
from frontage.io.files import reading, require_file
from frontage.io.photos.interchange.calibration import Calibration
from frontage.io.photos.interchange.numbers import finite, pixels, vector
from frontage.model import Camera

_TABLE = "calibrated_external_camera_parameters.txt"
_PER_PHOTO = "calibrated_camera_parameters.txt"
_INTERNAL = "pix4d_calibrated_internal_camera_parameters.cam"
_COLMAP = "cameras.txt"
_SENSOR = re.compile(r"sensor width of\s*([\d.eE+-]+)x([\d.eE+-]+)\s*mm", re.IGNORECASE)
_BLOCK = 10  # lines of a photo: name and size, K (3), radial, tangential, position, rotation (3)

CameraOf = Callable[[str, str | None, tuple[int, int]], Camera]
"""The camera of a photo, from its name, the camera that its row names, and the size of its picture in px."""


def cameras_beside(table: Path) -> CameraOf:
    """Where the cameras of the photos of a table come from.

    Raises FileError when no file beside the table states them, or it is damaged. So does the function, for a
    photo without a camera.
    """
    file = camera_file(table)
    kind = "Pix4D camera" if file.name != _COLMAP else "COLMAP cameras"
    with reading(file, kind):
        if file.suffix == ".cam":
            return _internal(file)
        return _colmap(file) if file.name == _COLMAP else _per_photo(file)


def camera_file(table: Path) -> Path:
    """The file beside a table that states the cameras. Raises FileError when there is none, or several."""
    prefix = table.name.removesuffix(_TABLE) if table.name.endswith(_TABLE) else None
    for ending in (_PER_PHOTO, _INTERNAL):
        if prefix is not None and (table.parent / f"{prefix}{ending}").is_file():
            return require_file(table.parent / f"{prefix}{ending}")
        found = sorted(p for p in table.parent.glob(f"*{ending}") if p != table)
        if len(found) > 1:
            raise FileError(
                table, f"several files beside it state cameras: {found[0].name}, {found[1].name}", "leave one"
            )
        if found:
            return require_file(found[0])
    if (table.parent / _COLMAP).is_file() and table.name != _COLMAP:
        return require_file(table.parent / _COLMAP)
    raise FileError(
        table,
        "states no cameras",
        f"put Pix4D's *_{_PER_PHOTO} or *_{_INTERNAL}, or a COLMAP {_COLMAP}, beside it",
        code="I110",
    )


def _missing(file: Path, name: str) -> FileError:
    return FileError(
        file, f"states no camera for photo {name}", "export the cameras of all photos", code="I110"
    )


def _per_photo(file: Path) -> CameraOf:
    """The cameras of `*_calibrated_camera_parameters.txt`, one for every photo."""
    lines = [line.strip() for line in file.read_text("utf-8-sig").splitlines()]
    start = next((k for k, line in enumerate(lines) if line.startswith("camera model m")), None)
    if start is None:
        raise ValueError('it has no header that ends with "camera model m = K [R|-Rt] X"')
    rest = [line for line in lines[start + 1 :] if line]
    if not rest or len(rest) % _BLOCK:
        raise ValueError(f"its photos have not {_BLOCK} lines each; fisheye cameras are not read")
    cameras: dict[str, Camera] = {}
    for k in range(0, len(rest), _BLOCK):
        name, width, height = [*rest[k].rsplit(None, 2), "", ""][:3]
        K = vector(" ".join(rest[k + 1 : k + 4]), 9, f"the matrix of {name}").reshape(3, 3)
        if K[0, 1] or K[1, 0] or K[2].tolist() != [0.0, 0.0, 1.0]:
            raise ValueError(f"the matrix of {name} is no camera matrix without skew")
        k1, k2, k3 = vector(rest[k + 4], 3, f"the radial distortion of {name}")
        t1, t2 = vector(rest[k + 5], 2, f"the tangential distortion of {name}")
        size = pixels(width, f"the width of {name}"), pixels(height, f"the height of {name}")
        focal, centre = (float(K[0, 0]), float(K[1, 1])), (float(K[0, 2]), float(K[1, 2]))
        cameras[name] = Calibration("frame", *size, focal, centre, (k1, k2, k3, 0.0), (t1, t2)).camera()[0]

    def camera_of(name: str, _: str | None, size: tuple[int, int]) -> Camera:
        if name not in cameras:
            raise _missing(file, name)
        return cameras[name]

    return camera_of


def _internal(file: Path) -> CameraOf:
    """The one camera of `*_pix4d_calibrated_internal_camera_parameters.cam`, for pictures of any size."""
    text = file.read_text("utf-8-sig")
    sensor = _SENSOR.search(text)
    if sensor is None:
        raise ValueError('no line says "assuming a sensor width of ... mm"; fisheye cameras are not read')
    if len(re.findall(r"^\s*F\s", text, re.MULTILINE)) != 1:
        raise ValueError("it does not state one camera")
    wide, high = finite(sensor[1], "the sensor width"), finite(sensor[2], "the sensor height")
    pairs = [line.split() for line in text.splitlines() if line.strip() and not line.startswith("#")]
    value = {p[0]: finite(p[1], p[0]) for p in pairs if len(p) == 2}
    missing = [n for n in ("F", "Px", "Py", "K1", "K2", "K3", "T1", "T2") if n not in value]
    if missing or not (wide > 0 and high > 0 and value["F"] > 0):
        raise ValueError(
            f"it states no {', '.join(missing) or 'positive sizes'}; fisheye cameras are not read"
        )

    def camera_of(name: str, _: str | None, size: tuple[int, int]) -> Camera:
        across, down = size[0] / wide, size[1] / high  # px per mm
        if abs(across / down - 1) > 1e-3:
            raise FileError(
                file, f"its sensor has not the shape of photo {name}", "use the camera of the photos"
            )
        return Calibration(
            "frame",
            *size,
            (value["F"] * across, value["F"] * across),
            (value["Px"] * across, value["Py"] * across),
            (value["K1"], value["K2"], value["K3"], 0.0),
            (value["T1"], value["T2"]),
        ).camera()[0]

    return camera_of


def _colmap(file: Path) -> CameraOf:
    """The cameras of a COLMAP cameras.txt: the one that the row names, else the only one of this size."""
    cameras: dict[str, Camera] = {}
    for line in file.read_text("utf-8-sig").splitlines():
        if line.strip() and not line.startswith("#"):
            number, model, width, height, *params = line.split()
            size = (
                pixels(width, f"the width of camera {number}"),
                pixels(height, f"the height of camera {number}"),
            )
            if len(params) != parameter_count(model):
                raise ValueError(f"camera {number} has {len(params)} parameters")
            cameras[number] = Camera(model, *size, np.array([finite(p, f"camera {number}") for p in params]))
    if not cameras:
        raise ValueError("it states no cameras")

    def camera_of(name: str, stated: str | None, size: tuple[int, int]) -> Camera:
        if stated:
            if stated not in cameras:
                raise _missing(file, f"{name} (camera {stated})")
            return cameras[stated]
        fitting = [c for c in cameras.values() if (c.width, c.height) == size]
        pick = list(cameras.values()) if len(cameras) == 1 else fitting
        if len(pick) != 1:
            raise FileError(
                file,
                f"holds {len(pick)} cameras of the size of photo {name}",
                "name the camera of every photo in a column `camera` of the table",
                code="I110",
            )
        return pick[0]

    return camera_of
