"""Reading COLMAP models, text and binary: cameras, poses of photos, sparse points.

Poses are `camera_from_world` (x right, y down, z forward) with pixel centres at 0.5, as everywhere in
Frontage.
"""

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3, rotation_from_quaternion
from frontage.io.colmapfiles import count_of, found_part, lines_of, model_folder, part_of
from frontage.io.columns import PointColumns, to_scan
from frontage.io.crs import LARGEST_M
from frontage.io.files import reading, require_file, require_length
from frontage.io.scans.request import ScanRequest
from frontage.model import Camera, Scan

# Order of COLMAP's model ids (src/colmap/sensor/models.h).
_MODELS = (
    "SIMPLE_PINHOLE",
    "PINHOLE",
    "SIMPLE_RADIAL",
    "RADIAL",
    "OPENCV",
    "OPENCV_FISHEYE",
    "FULL_OPENCV",
    "FOV",
    "SIMPLE_RADIAL_FISHEYE",
    "RADIAL_FISHEYE",
    "THIN_PRISM_FISHEYE",
)


@dataclass(frozen=True, eq=False)
class ColmapImage:
    """One oriented photo: id, name (which may hold folders), id of its camera, pose in the model's world."""

    id: int
    name: str
    camera: int
    camera_from_world: Rigid3


@dataclass(frozen=True, eq=False)
class ColmapModel:
    """The cameras by their ids, and the images in the order of their ids."""

    folder: Path
    cameras: dict[int, Camera]
    images: tuple[ColmapImage, ...]


def read_colmap(folder: str | Path) -> ColmapModel:
    """Read the cameras and poses of a model folder, binary or text; a model in its "sparse/0" is found.

    Raises FileError (missing, truncated, corrupt, unknown camera model, image of a missing camera).
    """
    where = model_folder(folder)
    cameras = _cameras(part_of(where, "cameras"))
    images = sorted(_images(part_of(where, "images")), key=lambda i: i.id)
    if not cameras or not images:
        raise FileError(
            where, "the COLMAP model holds no cameras or no images", "export it again", code="I105"
        )
    for image in images:
        if image.camera not in cameras:
            raise FileError(
                where,
                f"image {image.name} uses camera {image.camera}, which its cameras file does not hold",
                "export the model again",
                code="I110",
            )
    return ColmapModel(where, cameras, tuple(images))


def colmap_files(folder: str | Path) -> tuple[Path, ...]:
    """The files that `read_colmap` opens, in the folder where it finds the model.

    Raises FileError when there is no model, or only a part of one.
    """
    where = model_folder(folder)
    return part_of(where, "cameras"), part_of(where, "images")


def colmap_point_files(path: Path, request: ScanRequest) -> tuple[Path, ...]:
    """The points of a model, and its images and cameras where it has them: the rays come from the poses.

    Raises FileError when there is no model, or one without points.
    """
    points = _points_file(path)
    beside = [found_part(points.parent, name) for name in ("images", "cameras")]
    return points, *(p for p in beside if p is not None)


def read_colmap_points(path: str | Path, request: ScanRequest) -> list[Scan]:
    """Read the sparse points of a model (folder, points3D.txt or points3D.bin) as one scan.

    The origin of a point is the centre of the first photo of its track, where the model holds the poses.

    Raises FileError (missing, truncated, corrupt, no points), CrsError.
    """
    p = _points_file(Path(path))
    with reading(p, "COLMAP points3D"):
        xyz, rgb, seen_by = _points_binary(p, p.read_bytes()) if p.suffix == ".bin" else _points_text(p)
    if not len(xyz):
        raise FileError(p, "holds no points", "name a scan instead", code="I105")
    place = request.placement.place(None, xyz)
    c = PointColumns(p.name, place.to_local(xyz), rgb=rgb)
    poses = found_part(p.parent, "images")
    if poses is not None:
        images = _images(poses)
        c.origins, c.origin_index = _origins(images, seen_by)
        c.origins = place.to_local(c.origins)
    return [to_scan(p, c, place)]


def _origins(images: list[ColmapImage], seen_by: Array) -> tuple[Float, Array]:
    """The camera centres (s, 3) in the model's world, and the index of each point's (n,), -1 = unknown."""
    images = sorted(images, key=lambda i: i.id)
    ids = np.array([i.id for i in images], np.int64)
    centres = np.array([i.camera_from_world.inverse.t for i in images]).reshape(-1, 3)
    if not len(ids):
        return centres, np.full(len(seen_by), -1, np.int32)
    at = np.clip(np.searchsorted(ids, seen_by), 0, len(ids) - 1)
    return centres, np.where(ids[at] == seen_by, at, -1).astype(np.int32)


def _points_file(path: Path) -> Path:
    """The file of the sparse points: this one, or that of the model in a folder."""
    return part_of(model_folder(path), "points3D") if path.is_dir() else require_file(path)


def _cameras(path: Path) -> dict[int, Camera]:
    with reading(path, "COLMAP cameras"):
        if path.suffix == ".bin":
            return _cameras_binary(path, path.read_bytes())
        rows = [line.split() for line in lines_of(path) if line.strip()]
        return {int(r[0]): Camera(r[1], int(r[2]), int(r[3]), np.array(r[4:], np.float64)) for r in rows}


def _cameras_binary(path: Path, data: bytes) -> dict[int, Camera]:
    from frontage.geometry.camera import parameter_count

    count, at = count_of(path, data, "cameras", 24), 8
    cameras = {}
    for _ in range(count):
        camera, model, width, height = struct.unpack_from("<iiQQ", data, at)
        if not 0 <= model < len(_MODELS):
            raise ValueError(f"camera model {model} is not supported")
        n = parameter_count(_MODELS[model])
        params = np.frombuffer(data, "<f8", n, at + 24)
        cameras[camera] = Camera(_MODELS[model], width, height, params)
        at += 24 + 8 * n
    return cameras


def _image(number: int, pose: Array, camera: int, name: str) -> ColmapImage:
    if not (np.abs(pose) < LARGEST_M).all() or not pose[:4].any():  # NaN is not, either
        raise ValueError(f"the pose of {name} is no pose: it is zero, not finite, or beyond {LARGEST_M:g} m")
    return ColmapImage(
        number, name, camera, Rigid3("camera", "world", rotation_from_quaternion(pose[:4]), pose[4:])
    )


def _images(path: Path) -> list[ColmapImage]:
    with reading(path, "COLMAP images"):
        if path.suffix == ".bin":
            return _images_binary(path, path.read_bytes())
        found, lines = [], lines_of(path)
        while lines and not lines[-1].strip():
            lines.pop()
        for line in lines[::2]:  # every second line lists the photo's points
            r = line.split(maxsplit=9)
            if len(r) != 10:
                raise ValueError(f"a line has {len(r)} words instead of 10: {line[:40]}")
            found.append(_image(int(r[0]), np.array(r[1:8], np.float64), int(r[8]), r[9].strip()))
        return found


def _images_binary(path: Path, data: bytes) -> list[ColmapImage]:
    count, at = count_of(path, data, "images", 73), 8
    found = []
    for _ in range(count):
        number, *pose, camera = struct.unpack_from("<I7dI", data, at)
        end = data.index(b"\0", at + 64)
        (points,) = struct.unpack_from("<Q", data, end + 1)
        found.append(_image(number, np.array(pose), camera, data[at + 64 : end].decode("utf-8")))
        require_length(path, f"{points} points of an image", 24 * points, len(data) - end - 9)
        at = end + 9 + 24 * points
    return found


def _points_text(path: Path) -> tuple[Float, Array, Array]:
    """xyz (n, 3), rgb (n, 3) and the first image of the track (n,), -1 = none."""
    rows = [line.split(maxsplit=9)[:9] for line in lines_of(path) if line.strip()]
    if not rows:
        return np.empty((0, 3)), np.empty((0, 3), np.uint8), np.empty(0, np.int64)
    table = np.array([r + ["-1"] * (9 - len(r)) for r in rows], np.float64)
    return table[:, 1:4].copy(), table[:, 4:7].astype(np.uint8), table[:, 8].astype(np.int64)


def _points_binary(path: Path, data: bytes) -> tuple[Float, Array, Array]:
    """The same from points3D.bin, whose tracks have any length: every record's start is looked up."""
    count, at = count_of(path, data, "points", 51), 8
    starts, lengths = np.empty(count, np.int64), np.empty(count, np.int64)
    for k in range(count):
        starts[k] = at
        (length,) = struct.unpack_from("<Q", data, at + 43)
        at += 51 + 8 * length
        require_length(path, f"a track of {length} images", at, len(data))
        lengths[k] = length
    raw = np.frombuffer(data, np.uint8)
    xyz = raw[starts[:, None] + 8 + np.arange(24)].view("<f8").reshape(-1, 3)
    rgb = raw[starts[:, None] + 32 + np.arange(3)]
    first = (
        raw[np.minimum(starts[:, None] + 51 + np.arange(4), len(raw) - 1)].view("<u4")[:, 0].astype(np.int64)
    )
    return xyz.astype(np.float64), rgb, np.where(lengths > 0, first, -1)
