"""Rigs that the user states: COLMAP's rig_config.json, with standard errors where relative poses have any.

A list of rigs, each with its "cameras". A camera has an "image_prefix"; the photos whose names, with their
folders, begin with it are its own, and what follows the prefix, without suffix, names the exposure. One
camera has "ref_sensor": true. The others have "cam_from_rig_rotation" (quaternion w x y z) and
"cam_from_rig_translation" (m); without these their relative pose is unknown. "camera_model_name" and
"camera_params" state the calibration. Besides COLMAP's keys there are "name" of a rig or camera, and
"sigma_position" (m) and "sigma_angle" (degrees) of a relative pose that is to be estimated.
"""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3, rotation_from_quaternion
from frontage.io.files import reading, require_file
from frontage.io.photos.interchange.numbers import finite, vector
from frontage.io.poses import given_pose
from frontage.model import Estimate, Exposure, MountedCamera, Rig

_ROTATION, _TRANSLATION = "cam_from_rig_rotation", "cam_from_rig_translation"
_MODEL, _PARAMS = "camera_model_name", "camera_params"
_SIGMAS = ("sigma_position", "sigma_angle")
_KEYS = {"image_prefix", "ref_sensor", "name", _ROTATION, _TRANSLATION, _MODEL, _PARAMS, *_SIGMAS}


@dataclass(frozen=True, eq=False)
class StatedCamera:
    """A camera of a rig as stated: its prefix, how it is mounted, and its calibration where there is one."""

    prefix: str
    mounted: MountedCamera
    reference: bool
    model: str | None
    params: Float | None


@dataclass(frozen=True, eq=False)
class StatedRig:
    """A rig as stated, without its photos."""

    name: str
    cameras: tuple[StatedCamera, ...]

    def with_photos(self, paths: Mapping[str, str]) -> Rig:
        """The rig with the exposures of its photos; `paths` tells where the photos of all ids are.

        Photos of no camera are left out. Raises ValueError when a camera took two photos of one exposure.
        """
        taken: dict[str, dict[str, int]] = {}
        for photo, path in paths.items():
            match = self._camera_of(photo, path)
            if match is not None:
                camera, exposure = match
                taken.setdefault(exposure, {})[photo] = camera
        exposures = (Exposure(name, tuple(of), tuple(of.values())) for name, of in sorted(taken.items()))
        return Rig(self.name, tuple(c.mounted for c in self.cameras), tuple(exposures))

    def _camera_of(self, photo: str, path: str) -> tuple[int, str] | None:
        """The camera of a photo, by the longest prefix that fits, and the name of its exposure."""
        best: tuple[int, int, str] | None = None
        for k, camera in enumerate(self.cameras):
            rest = next((r for r in _rests(camera.prefix, photo, path) if r is not None), None)
            if rest is not None and (best is None or len(camera.prefix) > best[0]):
                best = (len(camera.prefix), k, rest)
        return None if best is None else (best[1], best[2].rsplit(".", 1)[0])


def _rests(prefix: str, photo: str, path: str) -> Iterable[str | None]:
    """What follows a prefix in the name of a photo, or else in the path of its file."""
    name = photo.replace("\\", "/")
    yield name.removeprefix(prefix) if name.startswith(prefix) else None
    _, found, rest = f"/{path}".replace("\\", "/").rpartition(f"/{prefix}")
    yield rest if found else None


def read_rig_file(path: str | Path) -> tuple[StatedRig, ...]:
    """The rigs of a rig_config.json. Raises FileError when it is missing, damaged or inconsistent."""
    file = require_file(path)
    with reading(file, "rig", "correct it; the key rig of [photos] describes the format"):
        stated = json.loads(file.read_text("utf-8-sig"))
        if not isinstance(stated, list) or not stated or not all(isinstance(r, dict) for r in stated):
            raise ValueError("it holds no list of rigs")
        return tuple(_rig(node, f"rig {k}") for k, node in enumerate(stated, 1))


def _rig(node: Mapping[str, Any], name: str) -> StatedRig:
    name = str(node.get("name", name))
    nodes = node["cameras"]
    cameras = tuple(_camera(camera, name) for camera in nodes)
    prefixes = [camera.prefix for camera in cameras]
    if len(set(prefixes)) < len(prefixes):
        raise ValueError(f"two cameras of {name} have the same image_prefix")
    if sum(camera.reference for camera in cameras) != 1:
        raise ValueError(f"{name} needs one camera with ref_sensor = true")
    return StatedRig(name, cameras)


def _camera(node: Mapping[str, Any], rig: str) -> StatedCamera:
    prefix = str(node["image_prefix"]).replace("\\", "/")
    name = str(node.get("name", prefix.strip("/_-. ") or "camera"))
    unknown = sorted(node.keys() - _KEYS)
    if unknown or not prefix:
        problem = f"the unknown key {unknown[0]!r}" if unknown else "an empty image_prefix"
        raise ValueError(f"camera {name} of {rig} has {problem}")
    reference = node.get("ref_sensor", False)
    if not isinstance(reference, bool) or (_ROTATION in node) != (_TRANSLATION in node):
        raise ValueError(
            f"camera {name} of {rig} states half a relative pose, or ref_sensor is no true or false"
        )
    if reference and _ROTATION in node:
        raise ValueError(f"camera {name} of {rig} is the reference, and has no relative pose")
    model, params = node.get(_MODEL), node.get(_PARAMS)
    if (model is None) != (params is None):
        raise ValueError(f"camera {name} of {rig} needs {_MODEL} and {_PARAMS}, or none of them")
    values = None if params is None else vector(params, len(params), f"{_PARAMS} of {name}")
    mounted = MountedCamera(name, given_pose(_identity()) if reference else _mount(node, name))
    return StatedCamera(prefix, mounted, reference, model, values)


def _identity() -> Rigid3:
    return Rigid3.identity("body", "camera")


def _mount(node: Mapping[str, Any], name: str) -> Estimate[Rigid3] | None:
    """How a camera sits on the body of its rig, with its standard errors; None where that is unknown."""
    if _ROTATION not in node:
        return None
    quaternion = vector(node[_ROTATION], 4, f"{_ROTATION} of {name}")
    if not quaternion.any():
        raise ValueError(f"{_ROTATION} of {name} is zero")
    shift = vector(node[_TRANSLATION], 3, f"{_TRANSLATION} of {name}")
    position, angle = (finite(node.get(key, 0.0), f"{key} of {name}") for key in _SIGMAS)
    if position < 0 or angle < 0:
        raise ValueError(f"a standard error of {name} is negative")
    pose = Rigid3("camera", "body", rotation_from_quaternion(quaternion), shift).inverse
    return given_pose(pose, (position,) * 3 + (float(np.radians(angle)),) * 3)


def nothing_found(path: str | Path) -> FileError:
    """The error for a rig file that belongs to other photos."""
    return FileError(
        path,
        "none of the photos has a name or a folder that begins with an image_prefix",
        "write the prefixes as the names of the photos begin, with their folders",
        code="I112",
    )
