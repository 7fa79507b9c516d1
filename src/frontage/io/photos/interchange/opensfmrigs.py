"""The rigs of OpenSfM and OpenDroneMap: in a reconstruction, or in the two files beside it.

`rotation` and `translation` of a rig camera lead from the rig to the camera, those of a rig instance from the
world to the rig: the pose of a shot in a rig is that of its rig camera after that of the rig instance. Every
shot on its own is an instance, too: these are left out.
"""

import json
from collections.abc import Mapping, Set
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial.transform import Rotation

from frontage.geometry.rigid import Rigid3
from frontage.io.files import reading
from frontage.io.photos.interchange.numbers import vector
from frontage.io.poses import given_pose
from frontage.model import Exposure, MountedCamera, Rig

_CAMERAS, _ASSIGNMENTS = RIG_FILES = ("rig_cameras.json", "rig_assignments.json")
"""The files beside a reconstruction that state rigs where it does not."""

_Taken = dict[str, dict[str, str]]
"""For every instance its shots, each with its rig camera."""


def table_of(of: Mapping[str, Any], key: str) -> dict[str, Any]:
    """The table under a key, empty where there is none. Raises ValueError for anything else."""
    value = of.get(key, {})
    if not isinstance(value, dict):
        raise ValueError(f"{key} is no table")
    return value


def pose_of(node: Mapping[str, Any], name: str) -> Rigid3:
    """The pose from the world (of the file or of a rig) to the camera. Raises ValueError."""
    turn = vector(node["rotation"], 3, f"the rotation of {name}")
    shift = vector(node.get("translation", [0.0, 0.0, 0.0]), 3, f"the translation of {name}")
    return Rigid3("camera", "file", Rotation.from_rotvec(turn).as_matrix(), shift)


def rig_poses(part: dict[str, Any]) -> dict[str, Rigid3]:
    """The poses of shots that only their rig states. Raises ValueError."""
    cameras = _mounted(table_of(part, "rig_cameras"))
    instances = {name: pose_of(node, name) for name, node in table_of(part, "rig_instances").items()}
    taken = _taken(part, cameras)
    return {
        shot: cameras[camera].after(instances[name])
        for name, shots in taken.items()
        for shot, camera in shots.items()
    }


def opensfm_rigs(path: Path, part: dict[str, Any], names: Set[str]) -> tuple[Rig, ...]:
    """The rigs that took several of the shots `names` at a time.

    They come from the reconstruction `part` of the file `path`; where it states none, from
    rig_cameras.json and rig_assignments.json beside it. Relative poses are exact. Raises FileError.
    """
    with reading(path, "OpenSfM reconstruction"):
        cameras = _mounted(table_of(part, "rig_cameras"))
        taken = _taken(part, cameras)
    files = [path.with_name(name) for name in RIG_FILES]
    if not any(len(shots) > 1 for shots in taken.values()) and all(f.is_file() for f in files):
        with reading(files[0], "OpenSfM rig cameras"):
            cameras = _mounted(json.loads(files[0].read_text("utf-8-sig")))
        with reading(files[1], "OpenSfM rig assignments"):
            taken = _assigned(json.loads(files[1].read_text("utf-8-sig")), cameras)
    there = {name: {s: c for s, c in shots.items() if s in names} for name, shots in taken.items()}
    with reading(path, "OpenSfM reconstruction"):
        return _rigs(cameras, {name: shots for name, shots in there.items() if shots})


def _mounted(table: dict[str, Any]) -> dict[str, Rigid3]:
    return {name: pose_of(node, name) for name, node in table.items()}


def _taken(part: dict[str, Any], cameras: dict[str, Rigid3]) -> _Taken:
    """The shots of the instances of a reconstruction."""
    instances = table_of(part, "rig_instances")
    taken = {name: table_of(node, "rig_camera_ids") for name, node in instances.items()}
    return _checked(taken, cameras)


def _assigned(stated: Any, cameras: dict[str, Rigid3]) -> _Taken:
    """The shots of the instances of rig_assignments.json; older files list them without names."""
    named = stated.items() if isinstance(stated, dict) else enumerate(stated)
    return _checked({str(name): dict(shots) for name, shots in named}, cameras)


def _checked(taken: _Taken, cameras: dict[str, Rigid3]) -> _Taken:
    for name, shots in taken.items():
        for camera in shots.values():
            if camera not in cameras:
                raise ValueError(f"rig {name} has the camera {camera!r}, which the file does not hold")
    return taken


def _rigs(cameras: dict[str, Rigid3], taken: _Taken) -> tuple[Rig, ...]:
    """One rig for all cameras that took shots together, directly or by way of others."""
    number = {name: k for k, name in enumerate(cameras)}
    pairs = [(number[a], number[next(iter(s.values()))]) for s in taken.values() for a in s.values()]
    rows = np.array(pairs, np.int64).reshape(-1, 2).T
    size = (len(cameras), len(cameras))
    part = connected_components(coo_array((np.ones(rows.shape[1]), (rows[0], rows[1])), shape=size))[1]
    found: list[Rig] = []
    for k in np.unique(part[rows[0]]):
        own = [name for name in cameras if part[number[name]] == k]
        exposures = tuple(
            Exposure(name, tuple(shots), tuple(own.index(camera) for camera in shots.values()))
            for name, shots in taken.items()
            if part[number[next(iter(shots.values()))]] == k
        )
        if any(len(e.photos) > 1 for e in exposures):
            mounted = tuple(MountedCamera(name, given_pose(_mount(cameras[name]))) for name in own)
            found.append(Rig(f"rig {len(found) + 1}", mounted, exposures))
    return tuple(found)


def _mount(camera_from_rig: Rigid3) -> Rigid3:
    back = camera_from_rig.inverse
    return Rigid3("body", "camera", back.R, back.t)
