"""OpenSfM's and OpenDroneMap's reconstruction.json.

Conventions (OpenSfM, doc/source/geometry.rst and opensfm/io.py): `rotation` (axis times angle, rad) and
`translation` of a shot lead from the world to the camera, which has x right, y down and z forward. Pixels are
normalised: the origin is the centre of the picture and the unit the longer side. p1 and p2 have OpenCV's
order. `reference_lla` is the origin of the world, whose axes are east, north and up there, on the WGS 84
ellipsoid; without it the coordinates are local.
"""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from pyproj import CRS, Transformer

from frontage.errors import FileError, UnsupportedFormat
from frontage.io.colmapfiles import model_folder
from frontage.io.files import reading, require_file
from frontage.io.photos.interchange.calibration import Calibration, Kind
from frontage.io.photos.interchange.georeference import east_north_up, to_world
from frontage.io.photos.interchange.numbers import finite, pixels
from frontage.io.photos.interchange.opensfmrigs import (
    RIG_FILES,
    opensfm_rigs,
    pose_of,
    rig_poses,
    table_of,
)
from frontage.io.photos.match import Posed, photo_set
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.request import PhotoRequest
from frontage.model import Camera

_PLACES = ("reconstruction.json", "opensfm/reconstruction.json")  # in the folder of a project
_REFERENCE = "reference_lla.json"
_FLAT = "geocoords"  # in the name of a file whose coordinates are projected already
_KINDS: dict[str, Kind] = {
    "perspective": "frame",
    "brown": "frame",
    "radial": "frame",
    "simple_radial": "frame",
    "fisheye": "fisheye",
    "fisheye_opencv": "fisheye",
    "fisheye62": "fisheye",
    "fisheye624": "fisheye",
    "spherical": "sphere",
    "equirectangular": "sphere",
}
_BEYOND = ("k5", "k6", "s0", "s1", "s2", "s3")  # of fisheye62 and fisheye624


def read_opensfm(request: PhotoRequest) -> PhotoSet:
    """The shots of the largest reconstruction, with their names as ids; a note counts the others.

    Poses with a reference are taken to the CRS of the run, and stay local where the run has none.

    Raises FileError (missing, damaged, empty, a camera that cannot be represented) and CrsError.
    """
    path, *others = opensfm_files(Path(str(request.cameras)))
    beside = [file for file in others if file.name == _REFERENCE]
    notes: list[str] = []
    with reading(path, "OpenSfM reconstruction"):
        stated = json.loads(path.read_text("utf-8-sig"))
        parts = stated if isinstance(stated, list) else [stated]
        if not parts or not all(isinstance(part, dict) for part in parts):
            raise ValueError("it holds no reconstructions")
        largest = max(parts, key=lambda part: len(table_of(part, "shots")))
        left = sum(len(table_of(part, "shots")) for part in parts) - len(table_of(largest, "shots"))
        if left:
            notes.append(
                f"{path.name}: {len(parts) - 1} smaller reconstructions with {left} shots were left out"
            )
        posed = _posed(path, largest)
        reference = largest.get("reference_lla")
    for file in beside if reference is None else ():
        with reading(file, "OpenSfM reference"):
            reference = json.loads(file.read_text("utf-8-sig"))
    if _FLAT in path.name:
        notes.append(
            f"{path.name}: its coordinates are projected already; [photos] offset adds what was subtracted"
        )
    elif reference is not None:
        with reading(path, "OpenSfM reconstruction"):
            posed = _referenced(path, posed, reference, request, notes)
    rigs = opensfm_rigs(path, largest, {name for name, _, _ in posed})
    return replace(photo_set(request, posed, notes), rigs=rigs)


def opensfm_files(path: Path) -> tuple[Path, ...]:
    """The files that `read_opensfm` opens: the reconstruction, and what there is beside it.

    These are the reference, and the files with rigs.

    path  the file, or the folder of an OpenSfM or ODM project

    Raises FileError when there is none.
    """
    file = require_file(_inside(path) or path)
    beside = [file.with_name(name) for name in (_REFERENCE, *RIG_FILES)]
    return file, *(p for p in beside if p.is_file())


def looks_like_opensfm(path: Path) -> bool:
    """Whether a path is a .json file, or a folder with a reconstruction and without a COLMAP model."""
    if _inside(path) is None:
        return path.suffix.lower() == ".json"
    try:
        model_folder(path)
    except FileError:
        return True
    return False


def _inside(folder: Path) -> Path | None:
    """The reconstruction in the folder of a project."""
    return next((folder / place for place in _PLACES if (folder / place).is_file()), None)


def _posed(path: Path, part: dict[str, Any]) -> list[Posed]:
    """The shots of a reconstruction, in its own coordinates."""
    stated, rigs = table_of(part, "cameras"), rig_poses(part)
    cameras: dict[str, Camera] = {}
    posed: list[Posed] = []
    for name, shot in table_of(part, "shots").items():
        of = shot["camera"]
        if of not in stated:
            raise ValueError(f"shot {name} has the camera {of!r}, which the file does not hold")
        if of not in cameras:
            cameras[of] = _camera(path, of, stated[of])
        pose = pose_of(shot, name) if "rotation" in shot else rigs.get(name)
        if pose is None:
            raise ValueError(f"shot {name} has no pose")
        posed.append((name, cameras[of], pose.inverse))
    if not posed:
        raise FileError(path, "holds no shots", "reconstruct the photos first", code="I105")
    return posed


def _camera(path: Path, name: str, node: Mapping[str, Any]) -> Camera:
    """A camera of the file. Raises ValueError and UnsupportedFormat."""
    kind = node.get("projection_type", "perspective")
    if kind not in _KINDS:
        known = ", ".join(_KINDS)
        raise UnsupportedFormat(
            path, f"camera {name!r} has the projection type {kind!r}", f"use one of {known}"
        )
    w, h = (pixels(node.get(side), f"the {side} of camera {name}") for side in ("width", "height"))
    value = {k: finite(v, k) for k, v in node.items() if isinstance(v, int | float)}
    beyond = [k for k in _BEYOND if value.get(k)]
    if beyond:
        raise UnsupportedFormat(
            path,
            f"camera {name!r} has the distortion terms {', '.join(beyond)}",
            "use fisheye_opencv cameras",
        )
    if _KINDS[kind] == "sphere":
        return Calibration("sphere", w, h, (1.0, 1.0), (w / 2, h / 2)).camera()[0]
    unit = max(w, h)

    def get(key: str) -> float:
        return value.get(key, 0.0)

    focal = (value["focal_x"], value["focal_y"]) if "focal_x" in value else (value["focal"],) * 2
    return Calibration(
        _KINDS[kind],
        w,
        h,
        (unit * focal[0], unit * focal[1]),
        (w / 2 + unit * get("c_x"), h / 2 + unit * get("c_y")),
        (get("k1"), get("k2"), get("k3"), get("k4") if _KINDS[kind] == "fisheye" else 0.0),
        (get("p1"), get("p2")),
    ).camera()[0]


def _referenced(
    path: Path, posed: list[Posed], reference: Any, request: PhotoRequest, notes: list[str]
) -> list[Posed]:
    """The shots in the world of the run; they stay local, with a note, when it has no CRS."""
    names = ("latitude", "longitude", "altitude")
    lat, lon, up = (finite(reference[n], f"the {n} of the reference") for n in names)
    if abs(lat) > 90 or abs(lon) > 360:
        raise ValueError(f"its reference, latitude {lat:g} and longitude {lon:g}, is no place on Earth")
    if request.world.crs is None:
        notes.append(
            f"{path.name}: the scans have no CRS, so the poses stay in metres east, north and up of "
            f"latitude {lat:.7f}, longitude {lon:.7f}, height {up:.2f} m"
        )
        return posed
    geographic, geocentric = CRS.from_epsg(4979), CRS.from_epsg(4978)
    centre = Transformer.from_crs(geographic, geocentric, always_xy=True).transform(lon, lat, up)
    frame = east_north_up(lat, lon, np.array(centre))
    poses = [frame.after(pose) for _, _, pose in posed]
    moved = to_world(path.name, geocentric, geographic, poses, request.world)
    notes += moved.notes
    return [(name, camera, pose) for (name, camera, _), pose in zip(posed, moved.poses, strict=True)]
