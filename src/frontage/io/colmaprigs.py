"""Reading the rigs of a COLMAP model (rigs and frames, text and binary, since COLMAP 3.12).

A rig states `sensor_from_rig` of its sensors; its reference sensor is the rig itself. A frame is one exposure
of a rig, with the images that its sensors took. Every camera on its own is a rig, too: these are left out.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3, rotation_from_quaternion
from frontage.io.colmap import ColmapModel
from frontage.io.colmapfiles import count_of, found_part, lines_of
from frontage.io.crs import LARGEST_M
from frontage.io.files import reading
from frontage.io.poses import given_pose
from frontage.model import Exposure, MountedCamera, Rig

_CAMERA = 0  # SensorType (src/colmap/sensor/sensor.h); others, such as IMUs, take no photos
_TYPES = {"CAMERA": _CAMERA, "IMU": 1}
_POSE = 7  # quaternion w x y z, translation


@dataclass(frozen=True)
class _Rig:
    """A rig as stated: its cameras by their ids, with `sensor_from_rig`; None where it is unknown."""

    id: int
    cameras: dict[int, Rigid3 | None]


@dataclass(frozen=True)
class _Frame:
    """A frame as stated: which cameras of which rig took which images."""

    id: int
    rig: int
    images: dict[int, int]


def read_colmap_rigs(model: ColmapModel) -> tuple[Rig, ...]:
    """The rigs of a model that took several photos at a time; none where it states no rigs.

    Relative poses are exact where the model states them, and unknown otherwise. Raises FileError.
    """
    files = colmap_rig_files(model.folder)
    if not files:
        return ()
    names = {image.id: image.name for image in model.images}
    with reading(files[0], "COLMAP rigs"):
        rigs = list(_rigs(files[0]))
    with reading(files[1], "COLMAP frames"):
        frames = list(_frames(files[1]))
        known = {rig.id: rig.cameras for rig in rigs}
        for frame in frames:
            if frame.rig not in known or not frame.images.keys() <= known[frame.rig].keys():
                raise ValueError(f"frame {frame.id} has a rig or a camera that is not there")
        found = [_rig(rig, [f for f in frames if f.rig == rig.id], names) for rig in rigs]
    return tuple(rig for rig in found if any(len(e.photos) > 1 for e in rig.exposures))


def colmap_rig_files(folder: Path) -> tuple[Path, ...]:
    """The two files with rigs and frames in the folder of a model, where it has both; else none."""
    files = [found_part(folder, name) for name in ("rigs", "frames")]
    there = tuple(file for file in files if file is not None)
    return there if len(there) == 2 else ()


def _rig(stated: _Rig, frames: list[_Frame], names: dict[int, str]) -> Rig:
    numbers = {camera: k for k, camera in enumerate(stated.cameras)}
    cameras = tuple(
        MountedCamera(f"camera {camera}", None if pose is None else given_pose(pose.inverse))
        for camera, pose in stated.cameras.items()
    )
    exposures = []
    for frame in frames:
        there = {camera: names[image] for camera, image in frame.images.items() if image in names}
        if there:
            photos, on = tuple(there.values()), tuple(numbers[camera] for camera in there)
            exposures.append(Exposure(f"frame {frame.id}", photos, on))
    return Rig(f"rig {stated.id}", cameras, tuple(exposures))


def _pose(values: Float) -> Rigid3:
    if not (np.abs(values) < LARGEST_M).all() or not values[:4].any():  # NaN is not, either
        raise ValueError("the pose of a sensor is no pose: it is zero, not finite, or too far away")
    return Rigid3("camera", "body", rotation_from_quaternion(values[:4]), values[4:])


def _rigs(path: Path) -> Iterator[_Rig]:
    if path.suffix == ".bin":
        yield from _rigs_binary(path, path.read_bytes())
        return
    yield from (_rig_of_line(line) for line in lines_of(path) if line.strip())


def _rig_of_line(line: str) -> _Rig:
    words = iter(line.split())
    number, sensors = int(next(words)), int(next(words))
    cameras: dict[int, Rigid3 | None] = {}
    for k in range(sensors):
        kind, sensor = _TYPES[next(words)], int(next(words))
        stated = k > 0 and bool(int(next(words)))
        pose = _pose(np.array([float(next(words)) for _ in range(_POSE)])) if stated else None
        if kind == _CAMERA:
            cameras[sensor] = Rigid3.identity("camera", "body") if k == 0 else pose
    if next(words, None) is not None:
        raise ValueError(f"rig {number} has more words than its {sensors} sensors need")
    return _Rig(number, cameras)


def _rigs_binary(path: Path, data: bytes) -> Iterator[_Rig]:
    at = 8
    for _ in range(count_of(path, data, "rigs", 8)):
        number, sensors = struct.unpack_from("<II", data, at)
        at += 8
        cameras: dict[int, Rigid3 | None] = {}
        for k in range(sensors):
            kind, sensor = struct.unpack_from("<iI", data, at)
            at += 8
            pose: Rigid3 | None = Rigid3.identity("camera", "body")
            if k > 0:
                stated = data[at]
                at += 1
                pose = _pose(np.array(struct.unpack_from("<7d", data, at))) if stated else None
                at += 8 * _POSE if stated else 0
            if kind == _CAMERA:
                cameras[sensor] = pose
        yield _Rig(number, cameras)


def _frames(path: Path) -> Iterator[_Frame]:
    if path.suffix == ".bin":
        yield from _frames_binary(path, path.read_bytes())
        return
    for line in lines_of(path):
        words = line.split()
        if words:
            count, data = int(words[2 + _POSE]), words[3 + _POSE :]
            if len(data) != 3 * count:
                raise ValueError(f"frame {words[0]} has {len(data)} words for {count} images")
            rows = zip(data[0::3], data[1::3], data[2::3], strict=True)
            images = {int(sensor): int(image) for kind, sensor, image in rows if _TYPES[kind] == _CAMERA}
            yield _Frame(int(words[0]), int(words[1]), images)


def _frames_binary(path: Path, data: bytes) -> Iterator[_Frame]:
    at = 8
    for _ in range(count_of(path, data, "frames", 68)):
        number, rig = struct.unpack_from("<II", data, at)
        (count,) = struct.unpack_from("<I", data, at + 8 + 8 * _POSE)
        at += 12 + 8 * _POSE
        rows = list(struct.iter_unpack("<iIQ", data[at : at + 16 * count]))
        if len(rows) != count:
            raise ValueError(f"it ends within frame {number}")
        at += 16 * count
        yield _Frame(number, rig, {sensor: image for kind, sensor, image in rows if kind == _CAMERA})
