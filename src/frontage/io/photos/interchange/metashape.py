"""Agisoft Metashape's camera file (XML, "Export Cameras").

Conventions (Metashape Professional manual, appendix on camera models; Python reference, `Camera.transform`):
the camera has x right, y down and z forward; `<transform>` of a camera is the row-major 4 x 4 matrix from the
camera to the chunk; that of the component or of the chunk (rotation, translation, scale) leads from there to
geocentric metres on the datum of `<reference>`, or to local coordinates where this is a LOCAL_CS or missing.
Pixels count from the outer corner of the first one, and (cx, cy) from the centre of the picture::

    x' = x (1 + k1 r^2 + ... + k4 r^8) + p1 (r^2 + 2 x^2) + 2 p2 x y      u = w/2 + cx + x' f + x' b1 + y' b2
    y' = y (1 + k1 r^2 + ... + k4 r^8) + p2 (r^2 + 2 y^2) + 2 p1 x y      v = h/2 + cy + y' f

so p1 and p2 have the opposite order of OpenCV's. A fisheye has the angle from the axis in place of r.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from lxml import etree
from pyproj import CRS

from frontage.errors import FileError, UnsupportedFormat
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.io.crs import parse_crs
from frontage.io.files import reading, require_file
from frontage.io.photos.interchange.calibration import VISIBLE_PX, Calibration, Kind
from frontage.io.photos.interchange.georeference import geocentric_of, to_world
from frontage.io.photos.interchange.numbers import finite, pixels, vector
from frontage.io.photos.match import Posed, photo_set
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.request import PhotoRequest
from frontage.io.poses import nearest_rotation
from frontage.model import Camera

_KINDS: dict[str, Kind] = {
    "frame": "frame",
    "fisheye": "fisheye",
    "equidistant_fisheye": "fisheye",
    "spherical": "sphere",
}
_AGAIN = "export the cameras again"


@dataclass(frozen=True, eq=False)
class _Similarity:
    """From the coordinates of a chunk to geocentric or local metres: ``scale R x + t``."""

    R: Float = field(default_factory=lambda: np.eye(3))
    t: Float = field(default_factory=lambda: np.zeros(3))
    scale: float = 1.0

    def of(self, matrix: Float) -> Rigid3:
        """The pose of a camera whose matrix (4, 4) leads to the chunk."""
        t = self.scale * self.R @ matrix[:3, 3] + self.t
        vector(t.tolist(), 3, "the position of a camera")
        return Rigid3("file", "camera", self.R @ nearest_rotation(matrix[:3, :3]), t)


def read_metashape(request: PhotoRequest) -> PhotoSet:
    """The aligned and enabled photos of a Metashape camera file, with the labels as ids.

    Cameras that are not aligned, disabled or slaves of a rig are left out with a note. Georeferenced poses
    are taken to the world of the run, local ones stay as they are.

    Raises FileError (missing, damaged, no aligned camera, a camera that cannot be represented) and CrsError.
    """
    path = require_file(str(request.cameras))
    with reading(path, "Metashape camera", _AGAIN):
        root = _root(path)
        chunks = root.findall("chunk") if root.tag == "document" else []
        if len(chunks) != 1:
            raise ValueError(f"it holds {len(chunks)} chunks of cameras instead of one")
        posed, notes = _posed(path, chunks[0])
        own = _reference(chunks[0], path)
    if own is not None:
        with reading(path, "Metashape camera", _AGAIN):
            moved = to_world(
                path.name, geocentric_of(own, path.name), own, [p for _, _, p in posed], request.world
            )
        posed = [(name, camera, pose) for (name, camera, _), pose in zip(posed, moved.poses, strict=True)]
        notes += moved.notes
    return photo_set(request, posed, notes)


def _root(path: Path) -> etree._Element:
    """The root of an XML file; entities are not resolved, and neither DTDs nor the network are used."""
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False)
    tree = etree.parse(str(path), parser)
    if tree.docinfo.doctype:
        raise ValueError("it has a document type declaration, which is not accepted")
    return tree.getroot()


def _posed(path: Path, chunk: etree._Element) -> tuple[list[Posed], list[str]]:
    """The photos of a chunk that have a pose, in geocentric or local metres, and notes on the others."""
    notes: list[str] = []
    sensors = {s.get("id"): s for s in chunk.iterfind("sensors/sensor")}
    cameras: dict[str, Camera] = {}
    whole = _similarity(chunk.find("transform"))
    parts = {
        c.get("id"): _similarity(c.find("transform")) if c.find("transform") is not None else whole
        for c in chunk.iterfind("components/component")
    }
    posed: list[Posed] = []
    left = {"are not aligned": 0, "are disabled": 0, "belong to a rig without poses of their own": 0}
    for camera in chunk.iterfind("cameras//camera"):
        label, sensor = camera.get("label") or "", camera.get("sensor_id") or ""
        why = _why_left(camera)
        if why is not None:
            left[why] += 1
            continue
        if not label or sensor not in sensors:
            raise ValueError(f"camera {label or camera.get('id')!r} has no label or no sensor")
        if sensor not in cameras:
            cameras[sensor], said = _camera(path, sensors[sensor])
            notes += [f"{path.name}: sensor {sensor}: {sentence}" for sentence in said]
        matrix = vector(camera.findtext("transform"), 16, f"the transform of camera {label}").reshape(4, 4)
        posed.append((label, cameras[sensor], parts.get(camera.get("component_id"), whole).of(matrix)))
    if not posed:
        raise FileError(path, "holds no aligned cameras", "align the photos and export again", code="I105")
    notes += [f"{path.name}: {n} cameras {why} and were left out" for why, n in left.items() if n]
    return posed, notes


def _why_left(camera: etree._Element) -> str | None:
    """Why a camera is not used; None for one that is."""
    if camera.get("enabled") in ("false", "0"):
        return "are disabled"
    if camera.find("transform") is not None:
        return None
    return "belong to a rig without poses of their own" if camera.get("master_id") else "are not aligned"


def _similarity(node: etree._Element | None) -> _Similarity:
    if node is None:
        return _Similarity()
    rotation, translation = node.findtext("rotation"), node.findtext("translation")
    scale = finite(node.findtext("scale", "1"), "the scale of the chunk")
    if scale <= 0:
        raise ValueError(f"the scale of the chunk is {scale:g}, which is not positive")
    return _Similarity(
        np.eye(3)
        if rotation is None
        else nearest_rotation(vector(rotation, 9, "the rotation").reshape(3, 3)),
        np.zeros(3) if translation is None else vector(translation, 3, "the translation"),
        scale,
    )


def _reference(chunk: etree._Element, path: Path) -> CRS | None:
    """The CRS of the chunk; None for local coordinates."""
    text = (chunk.findtext("reference") or "").strip()
    if not text or text.upper().startswith(("LOCAL_CS", "ENGCRS")):
        return None
    return parse_crs(text, str(path))


def _camera(path: Path, sensor: etree._Element) -> tuple[Camera, tuple[str, ...]]:
    """The camera of a sensor: its adjusted calibration where there is one."""
    stated = {c.get("class"): c for c in sensor.iterfind("calibration")}
    calibration = stated.get("adjusted", stated.get("initial"))
    kind = sensor.get("type") or ""
    size = sensor.find("resolution")
    if size is None:
        raise ValueError(f"sensor {sensor.get('id')} has no resolution")
    if calibration is not None:
        kind = calibration.get("type") or kind
        own = calibration.find("resolution")
        if own is not None and (own.get("width"), own.get("height")) != (
            size.get("width"),
            size.get("height"),
        ):
            raise ValueError(f"sensor {sensor.get('id')} and its calibration differ in size")
    if kind not in _KINDS:
        raise UnsupportedFormat(
            path, f"sensor {sensor.get('id')} is of the type {kind!r}", f"use {', '.join(_KINDS)} cameras"
        )
    w, h = pixels(size.get("width"), "the width"), pixels(size.get("height"), "the height")
    if _KINDS[kind] == "sphere":
        return Calibration("sphere", w, h, (1.0, 1.0), (w / 2, h / 2)).camera()
    if calibration is None or calibration.find("f") is None:
        raise ValueError(f"sensor {sensor.get('id')} has no calibration with a focal length f")
    value = {
        str(e.tag): finite(e.text, str(e.tag))
        for e in calibration
        if isinstance(e.tag, str) and len(e.tag) <= 2
    }
    return _calibrated(path, _KINDS[kind], (w, h), value)


def _calibrated(
    path: Path, kind: Kind, size: tuple[int, int], value: dict[str, float]
) -> tuple[Camera, tuple[str, ...]]:
    """The camera with the parameters that a calibration states by name; those it omits are zero."""
    w, h = size

    def get(name: str) -> float:
        return value.get(name, 0.0)

    calibration = Calibration(
        kind,
        w,
        h,
        (value["f"] + get("b1"), value["f"]),
        (w / 2 + get("cx"), h / 2 + get("cy")),
        (get("k1"), get("k2"), get("k3"), get("k4")),
        (get("p2"), get("p1")),
    )
    made = calibration.camera()
    x, y = np.abs(calibration.corners()).T
    q = x * x + y * y
    bent = np.abs(get("p3") * q + get("p4") * q * q) * 3 * q * (abs(get("p1")) + abs(get("p2")))
    for names, moved in (("b2", abs(get("b2")) * y.max()), ("p3 and p4", value["f"] * bent.max())):
        if not moved <= VISIBLE_PX:
            raise UnsupportedFormat(
                path,
                f"the parameter {names} moves a corner of the picture by {moved:.2g} px, "
                "which no camera model can represent",
                f"optimise the cameras in Metashape without {names}, or export undistorted photos",
            )
    return made


def looks_like_metashape(path: Path) -> bool:
    """Whether a file can only be meant as a Metashape camera file: its name ends in .xml."""
    return path.suffix.lower() == ".xml" and not path.is_dir()


def metashape_files(path: Path) -> tuple[Path, ...]:
    """The files that `read_metashape` opens. Raises FileError when it is missing."""
    return (require_file(path),)
