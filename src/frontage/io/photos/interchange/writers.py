"""Writing the poses of photos for other programs: Metashape XML, OpenSfM, tables of omega, phi, kappa.

The conventions of every format stand in the module that reads it.
"""

import csv
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree
from pyproj.enums import WktVersion
from pyproj.exceptions import CRSError as ProjError
from scipy.spatial.transform import Rotation

from frontage.errors import CrsError, FileError
from frontage.geometry.rigid import Rigid3
from frontage.io.colmapwrite import camera_lines
from frontage.io.files import whole_file
from frontage.io.photos.interchange.calibration import Calibration, of_camera, refused
from frontage.io.photos.interchange.georeference import topocentric
from frontage.io.photos.interchange.opk import angles_of
from frontage.model import Camera, Photo, WorldRef

_LOCAL = 'LOCAL_CS["Local Coordinates (m)",LOCAL_DATUM["Local Datum",0],UNIT["metre",1]]'
_TYPES = {"frame": "frame", "fisheye": "fisheye", "sphere": "spherical"}
_METASHAPE, _OPENSFM = "Metashape XML", "OpenSfM"
_COLMAP = "cameras.txt"


def write_metashape(path: Path, photos: Sequence[Photo], world: WorldRef) -> Path:
    """Write a Metashape camera file: geocentric with the CRS of the world, else in local coordinates.

    Raises InputError for a camera that Metashape cannot express, CrsError for a CRS that cannot be written,
    and FileError when the file cannot be written.
    """
    poses, frame, reference = _chunk(path, photos, world)
    numbers = {camera: k for k, camera in enumerate(_cameras(photos))}
    root = etree.Element("document", version="2.0.0")
    chunk = etree.SubElement(root, "chunk", label="frontage", enabled="true")
    sensors = etree.SubElement(chunk, "sensors", next_id=str(len(numbers)))
    for key, camera in _cameras(photos).items():
        _sensor(sensors, numbers[key], of_camera(camera, _METASHAPE))
    listed = etree.SubElement(chunk, "cameras", next_id=str(len(photos)), next_group_id="0")
    for k, (photo, pose) in enumerate(zip(photos, poses, strict=True)):
        about = {"id": str(k), "sensor_id": str(numbers[_key(photo.camera)]), "label": photo.id}
        node = etree.SubElement(listed, "camera", about)
        etree.SubElement(node, "transform").text = _text(pose.matrix.ravel().tolist())
    etree.SubElement(chunk, "reference").text = reference
    transform = etree.SubElement(chunk, "transform")
    for name, values in (("rotation", frame.R.ravel()), ("translation", frame.t), ("scale", np.ones(1))):
        etree.SubElement(transform, name, locked="true").text = _text(values.tolist())
    etree.indent(root)
    _put(path, etree.tostring(root, encoding="unicode"))
    return path


def _chunk(path: Path, photos: Sequence[Photo], world: WorldRef) -> tuple[Sequence[Rigid3], Rigid3, str]:
    """The poses in the chunk, the pose of the chunk, and its coordinate reference system as WKT 1."""
    if world.crs is None:
        frame = Rigid3("file", "local", np.eye(3), world.origin.astype(np.float64))
        return [photo.pose for photo in photos], frame, _LOCAL
    placed = topocentric(path.name, [photo.pose for photo in photos], world, on_wgs84=False)
    try:
        return placed.poses, placed.frame, str(placed.own.to_wkt(WktVersion.WKT1_GDAL))
    except ProjError as problem:
        name = placed.own.name
        raise CrsError(f"{path}: {name} cannot be written as Metashape needs it", code="I201") from problem


def _sensor(sensors: Any, number: int, c: Calibration) -> None:
    """Append a sensor with its adjusted calibration."""
    kind, size = _TYPES[c.kind], {"width": str(c.width), "height": str(c.height)}
    sensor = etree.SubElement(sensors, "sensor", id=str(number), label=f"camera {number}", type=kind)
    etree.SubElement(sensor, "resolution", size)
    node = etree.SubElement(sensor, "calibration", {"type": kind, "class": "adjusted"})
    etree.SubElement(node, "resolution", size)
    (fx, fy), (cx, cy), (p1, p2) = c.focal, c.centre, c.tangential
    values = {"f": fy, "cx": cx - c.width / 2, "cy": cy - c.height / 2, "b1": fx - fy}
    values |= {f"k{k}": value for k, value in enumerate(c.radial, 1)} | {"p1": p2, "p2": p1}
    for name, value in values.items():
        if value or name == "f":
            etree.SubElement(node, name).text = repr(float(value))


def write_opensfm(path: Path, photos: Sequence[Photo], world: WorldRef) -> Path:
    """Write a reconstruction.json: east, north and up of a reference where the world has a CRS, else local.

    Local coordinates keep the origin of the world. Raises InputError for a camera that OpenSfM cannot
    express, CrsError, and FileError when the file cannot be written.
    """
    out: dict[str, Any] = {}
    if world.crs is None:
        poses = [Rigid3("file", "camera", p.pose.R, world.to_world(p.pose.t)) for p in photos]
    else:
        placed = topocentric(path.name, [photo.pose for photo in photos], world, on_wgs84=True)
        poses = list(placed.poses)
        names = ("latitude", "longitude", "altitude")
        out["reference_lla"] = {n: float(v) for n, v in zip(names, placed.place, strict=True)}
    numbers = {camera: f"camera {k}" for k, camera in enumerate(_cameras(photos))}
    out["cameras"] = {numbers[key]: _opensfm_camera(camera) for key, camera in _cameras(photos).items()}
    out["shots"] = {}
    for photo, pose in zip(photos, poses, strict=True):
        back = pose.inverse
        out["shots"][photo.id] = {
            "rotation": Rotation.from_matrix(back.R).as_rotvec().tolist(),
            "translation": back.t.tolist(),
            "camera": numbers[_key(photo.camera)],
        }
    out["points"] = {}
    _put(path, json.dumps([out], indent=1, ensure_ascii=False))
    return path


def _opensfm_camera(camera: Camera) -> dict[str, Any]:
    """A camera as OpenSfM writes it: normalised by the longer side, about the centre of the picture."""
    c = of_camera(camera, _OPENSFM)
    size = {"width": c.width, "height": c.height}
    if c.kind == "sphere":
        return {"projection_type": "spherical", **size}
    unit = max(c.width, c.height)
    about = {
        **size,
        "focal_x": c.focal[0] / unit,
        "focal_y": c.focal[1] / unit,
        "c_x": (c.centre[0] - c.width / 2) / unit,
        "c_y": (c.centre[1] - c.height / 2) / unit,
        **{f"k{k}": value for k, value in enumerate(c.radial, 1)},
    }
    if c.kind == "frame":
        if about.pop("k4"):
            raise refused(camera, _OPENSFM, "has a distortion that it cannot express")
        kind, more = "brown", dict(zip(("p1", "p2"), c.tangential, strict=True))
    elif any(c.tangential):
        kind, more = "fisheye62", {"k5": 0.0, "k6": 0.0, "p1": c.tangential[0], "p2": c.tangential[1]}
    else:
        kind, more = "fisheye_opencv", {}
    return {"projection_type": kind, **about, **more}


def write_opk(path: Path, photos: Sequence[Photo], world: WorldRef) -> Path:
    """Write a table of positions in the world and angles in degrees, and a COLMAP cameras.txt beside it.

    Raises FileError when the files cannot be written, or the table would be the cameras.txt itself.
    """
    if path.name == _COLMAP:
        raise FileError(path, "is the name of the cameras beside the table", "name the table otherwise")
    numbers = {camera: k for k, camera in enumerate(_cameras(photos), 1)}
    out = io.StringIO()
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(("imageName", "X", "Y", "Z", "Omega", "Phi", "Kappa", "camera"))
    for photo in photos:
        values = [*world.to_world(photo.pose.t).tolist(), *np.degrees(angles_of(photo.pose.R)).tolist()]
        rows.writerow((photo.id, *(repr(float(v)) for v in values), numbers[_key(photo.camera)]))
    _put(path.with_name(_COLMAP), camera_lines(_cameras(photos).values()))
    _put(path, out.getvalue())
    return path


def _key(camera: Camera) -> tuple[Any, ...]:
    return camera.model, camera.width, camera.height, *camera.params.tolist()


def _cameras(photos: Sequence[Photo]) -> dict[tuple[Any, ...], Camera]:
    """The unlike cameras of photos, in the order of their first photo."""
    return {_key(photo.camera): photo.camera for photo in photos}


def _text(values: Sequence[float]) -> str:
    return " ".join(repr(float(v)) for v in values)


def _put(path: Path, text: str) -> None:
    with whole_file(path) as temporary:
        temporary.write_text(text, "utf-8")
