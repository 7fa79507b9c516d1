"""Photos embedded in E57 files (`images2D` with a pinhole representation).

ASTM E2807: the camera looks along its -z axis, x right, y up; here it becomes x right, y down, z forward.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import FileError
from frontage.geometry.rigid import Rigid3, rotation_from_quaternion
from frontage.io.photos.imagefile import parse_header
from frontage.io.scans.e57 import opened
from frontage.model import Camera

_DOWN_FORWARD = np.diag([1.0, -1.0, -1.0])
_BLOBS = ("jpegImage", "pngImage")


@dataclass(frozen=True, eq=False)
class EmbeddedPhoto:
    """number in images2D, id, PINHOLE camera, pose in file coordinates."""

    number: int
    id: str
    camera: Camera
    file_from_camera: Rigid3


def embedded_photos(path: str | Path) -> tuple[list[EmbeddedPhoto], list[str]]:
    """The pinhole photos with a pose, and notes on those left out. Raises FileError, MissingExtra."""
    found: list[EmbeddedPhoto] = []
    notes: list[str] = []
    with opened(path) as e57:
        root = e57.root
        images = root["images2D"] if root.isDefined("images2D") else []
        for k in range(len(images)):
            node = images[k]
            name = (
                node["name"].value() if node.isDefined("name") and node["name"].value() else f"image{k + 1}"
            )
            if not node.isDefined("pinholeRepresentation") or not node.isDefined("pose"):
                notes.append(
                    f"{Path(path).name}: embedded photo {name} is no pinhole photo with a pose: left out"
                )
                continue
            photo_id = name if all(name != f.id for f in found) else f"{name}#{k + 1}"
            found.append(
                EmbeddedPhoto(k, photo_id, _camera(node["pinholeRepresentation"]), _pose(node["pose"]))
            )
    return found, notes


def embedded_bytes(path: str | Path, number: int) -> bytes:
    """The JPEG or PNG bytes of photo `number`. Raises FileError, MissingExtra."""
    with opened(path) as e57:
        view = e57.root["images2D"][number]["pinholeRepresentation"]
        kind = next((b for b in _BLOBS if view.isDefined(b)), None)
        if kind is None:
            raise FileError(
                path, f"embedded photo {number + 1} has no picture", "export it again", code="I103"
            )
        blob = view[kind]
        data = np.zeros(blob.byteCount(), np.uint8)
        blob.read(data, 0, len(data))
    parse_header(data.tobytes(), path)
    return data.tobytes()


def _camera(view: Any) -> Camera:
    """Focal length and pixel size in metres, principal point in pixels from the upper left corner."""
    value = {
        k: float(view[k].value())
        for k in (
            "imageWidth",
            "imageHeight",
            "focalLength",
            "pixelWidth",
            "pixelHeight",
            "principalPointX",
            "principalPointY",
        )
    }
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
    q = [float(node["rotation"][k].value()) for k in "wxyz"]
    t = [float(node["translation"][k].value()) for k in "xyz"]
    return Rigid3("file", "camera", rotation_from_quaternion(np.array(q)) @ _DOWN_FORWARD, np.array(t))
