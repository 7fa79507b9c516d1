"""Photos that E57 files embed (`images2D` with a pinhole representation).

ASTM E2807: the camera looks along its -z axis, with x right and y up; here x is right, y down and z forward.
"""

from typing import Any

import numpy as np

from frontage.errors import FileError
from frontage.geometry.rigid import Rigid3, rotation_from_quaternion
from frontage.io.crs import LARGEST_M
from frontage.io.photos.photoset import PhotoSet, PixelSource
from frontage.io.photos.request import PhotoRequest
from frontage.io.scans.e57 import opened
from frontage.model import Camera, Photo

_DOWN_FORWARD = np.diag([1.0, -1.0, -1.0])
_PINHOLE = (
    "imageWidth",
    "imageHeight",
    "focalLength",
    "pixelWidth",
    "pixelHeight",
    "principalPointX",
    "principalPointY",
)


def read_e57_photos(request: PhotoRequest) -> PhotoSet:
    """The pinhole photos of an E57 file that have a pose; the others are left out with a note.

    The ids are the names in the file, numbered where a name occurs twice.

    Raises FileError when the file is damaged or holds no such photo, and MissingExtra without pye57.
    """
    path = request.files[0]
    photos: list[Photo] = []
    pixels: dict[str, PixelSource] = {}
    notes: list[str] = []
    with opened(path) as e57:
        root = e57.root
        images = root["images2D"] if root.isDefined("images2D") else []
        for k in range(len(images)):
            node = images[k]
            name = _name(node) or f"image{k + 1}"
            if not node.isDefined("pinholeRepresentation") or not node.isDefined("pose"):
                notes.append(
                    f"{path.name}: embedded photo {name} was left out: it is not a pinhole photo with a pose"
                )
                continue
            photo_id = name if name not in pixels else f"{name}#{k + 1}"
            photos.append(
                request.photo(photo_id, _camera(node["pinholeRepresentation"]), _pose(node["pose"]))
            )
            pixels[photo_id] = PixelSource(str(path), embedded=k)
    if not photos:
        raise FileError(path, "holds no pinhole photos", "name picture files and their cameras", code="I105")
    return PhotoSet(tuple(photos), pixels, tuple(notes))


def _name(node: Any) -> str:
    return str(node["name"].value()) if node.isDefined("name") else ""


def _camera(view: Any) -> Camera:
    """The camera of a pinhole representation.

    The file states the focal length and the pixel size in metres, and the principal point in pixels from the
    upper left corner. Raises ValueError without a focal length.
    """
    value = {k: float(view[k].value()) for k in _PINHOLE}
    params = [
        value["focalLength"] / value["pixelWidth"],
        value["focalLength"] / value["pixelHeight"],
        value["principalPointX"],
        value["principalPointY"],
    ]
    if not np.isfinite(params).all() or min(params[:2]) <= 0:
        raise ValueError("an embedded photo has no focal length")
    return Camera("PINHOLE", int(value["imageWidth"]), int(value["imageHeight"]), np.array(params))


def _pose(node: Any) -> Rigid3:
    """The pose of the camera in the coordinates of the file."""
    q = [float(node["rotation"][k].value()) for k in "wxyz"]
    t = [float(node["translation"][k].value()) for k in "xyz"]
    if not (np.abs([*q, *t]) < LARGEST_M).all():  # NaN is not, either
        raise ValueError("an embedded photo has no usable pose")
    return Rigid3("file", "camera", rotation_from_quaternion(np.array(q)) @ _DOWN_FORWARD, np.array(t))
