"""Writing a COLMAP text model: cameras and poses with all their digits, and the offset to the world."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import quaternion_from_rotation
from frontage.io.files import whole_file
from frontage.model import Camera, Photo


def write_colmap(folder: str | Path, photos: Sequence[Photo], offset: Float) -> Path:
    """Write cameras.txt, images.txt, an empty points3D.txt and offset.txt for oriented photos.

    Poses stay in local coordinates; adding `offset` (3,) m takes them to the world (`[photos] offset` in the
    project file). Equal cameras are written once.

    Raises ValueError for a photo without a pose, and FileError when the files cannot be written.
    """
    where = Path(folder)
    cameras: dict[str, int] = {}
    lines = []
    for number, photo in enumerate(photos, 1):
        camera = cameras.setdefault(_camera(photo.camera), len(cameras) + 1)
        pose = photo.pose.inverse
        numbers = (*quaternion_from_rotation(pose.R), *pose.t)
        lines.append(f"{number} {' '.join(repr(float(v)) for v in numbers)} {camera} {photo.id}\n\n")
    _put(where / "cameras.txt", "".join(f"{number} {text}\n" for text, number in cameras.items()))
    _put(where / "images.txt", "".join(lines))
    _put(where / "points3D.txt", "# no points\n")
    _put(where / "offset.txt", " ".join(repr(float(v)) for v in np.asarray(offset)) + "\n")
    return where


def _camera(camera: Camera) -> str:
    params = " ".join(repr(float(p)) for p in camera.params)
    return f"{camera.model} {camera.width} {camera.height} {params}"


def _put(path: Path, text: str) -> None:
    with whole_file(path) as temporary:
        temporary.write_text(text, "utf-8")
