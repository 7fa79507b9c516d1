"""Poses that move between the world of a run and the coordinate reference systems of other programs.

A transformation between systems is curved. At every camera it is replaced by its derivative, from symmetric
differences along the axes of the camera; the rotation nearest to that turns the camera. It contains the
convergence of the meridians and, from geocentric axes, the turn to east, north and up.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from pyproj import CRS, Transformer
from pyproj.exceptions import ProjError

from frontage.errors import CrsError
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.io import crs as systems
from frontage.io.placement import PlacementRequest
from frontage.io.transform import best_transformer
from frontage.model import WorldRef

_LEVER_M = 30.0  # of the differences: a curvature of the third order and rounding both stay below 1e-10 rad
_VISIBLE_SCALE = 1e-4  # relative difference of the scales in plan and height that a note tells
_SAME = 70  # percent: PROJ's confidence that a system without a code is one with a code

_WGS84 = CRS.from_epsg(4978)
_GEOCENTRIC_AXES = [
    {"name": f"Geocentric {n}", "abbreviation": n, "direction": f"geocentric{n}", "unit": "metre"}
    for n in "XYZ"
]


@dataclass(frozen=True, eq=False)
class Moved:
    """Poses in another system, in the order given, and notes for the user."""

    poses: tuple[Rigid3, ...]
    notes: tuple[str, ...] = ()


def recognised(crs: CRS) -> CRS:
    """The registered system that a system without a code is, where PROJ knows one; else the system itself.

    Other programs write systems with names of their own, for which no transformation would be found.
    """
    if crs.is_compound:
        return crs
    found = crs.to_authority(min_confidence=_SAME)
    try:
        return CRS.from_authority(*found) if found else crs
    except ProjError:
        return crs


def geocentric_of(crs: CRS, name: str) -> CRS:
    """The geocentric system in metres on the datum of a system. Raises CrsError when it has no datum."""
    base = recognised(systems.horizontal(crs)).geodetic_crs
    if base is None:
        raise CrsError(f"{name}: {crs.name} has no datum; state a projected or geographic CRS", code="I201")
    if base.is_geocentric:
        return base
    stated = base.to_json_dict()
    datum = {k: stated[k] for k in ("datum", "datum_ensemble") if k in stated}
    axes = {"subtype": "Cartesian", "axis": _GEOCENTRIC_AXES}
    made = {"type": "GeodeticCRS", "name": base.name, **datum, "coordinate_system": axes}
    return recognised(CRS.from_json_dict(made))


def to_world(name: str, source: CRS, own: CRS, poses: Sequence[Rigid3], world: WorldRef) -> Moved:
    """Poses with coordinates in `source` as poses in the world of a run, coordinates in full.

    own   the system that the file names; `source` may be the geocentric one on its datum. Where the run has
          no CRS, its coordinates are taken to be in this system.

    Raises CrsError when no transformation is known, or when the run has no CRS and `own` is not projected in
    metres.
    """
    notes: list[str] = []
    target = world.crs
    if target is None:
        if not systems.is_world(own):
            raise CrsError(
                f"{name}: its cameras are in {own.name}, but the scans have no CRS; state crs for the scans",
                code="I202",
            )
        target = systems.crs_text(recognised(own))
        notes.append(f"{name}: the scans have no CRS and were taken to be in that of the cameras, {own.name}")
    centres = np.array([pose.t for pose in poses]).reshape(-1, 3)
    whole = WorldRef(np.zeros(3, np.int64), target)
    place = PlacementRequest(name, world=whole).place(source, centres)
    moved, stretch = _carried(poses, place.to_local)
    if stretch > _VISIBLE_SCALE:
        notes.append(
            f"{name}: in {systems.parse_crs(target).name} lengths in plan differ from heights by "
            f"{100 * stretch:.2g} % here, which no pose can follow"
        )
    return Moved(tuple(moved), (*place.notes, *notes))


def topocentric(name: str, poses: Sequence[Rigid3], world: WorldRef, on_wgs84: bool) -> "Topocentric":
    """Local poses of a run with a CRS in axes east, north and up at their middle.

    on_wgs84  on WGS 84 instead of the datum of the CRS

    Heights without a datum are taken to be above the ellipsoid. Raises CrsError when no transformation of
    known accuracy is installed.
    """
    assert world.crs is not None
    own = systems.parse_crs(world.crs, name)
    target = _WGS84 if on_wgs84 else geocentric_of(own, name)
    source = own if systems.vertical(own) is not None else systems.horizontal(own).to_3d()
    full = [Rigid3("world", pose.frm, pose.R, world.to_world(pose.t)) for pose in poses]
    move = best_transformer(name, source, target, np.array([p.t for p in full]), [])
    moved = _carried(full, lambda xyz: np.column_stack(move.transform(*xyz.T)))[0]
    middle = np.mean([pose.t for pose in moved], axis=0)
    to_degrees = Transformer.from_crs(_WGS84, "EPSG:4979", always_xy=True)
    lon, lat, up = to_degrees.transform(middle[0], middle[1], middle[2])
    frame = east_north_up(lat, lon, middle)
    return Topocentric(own, (lat, lon, up), frame, tuple(frame.inverse.after(pose) for pose in moved))


@dataclass(frozen=True, eq=False)
class Topocentric:
    """Poses in axes east, north and up at a place.

    own        the CRS of the run
    place      latitude and longitude in degrees and ellipsoidal height in m of the origin
    frame      the pose of the axes in geocentric metres
    poses      of the cameras, in the axes
    """

    own: CRS
    place: tuple[float, float, float]
    frame: Rigid3
    poses: tuple[Rigid3, ...]


def east_north_up(latitude: float, longitude: float, centre: Float) -> Rigid3:
    """The pose in geocentric coordinates of axes east, north and up at a place in degrees.

    centre  (3,) m geocentric, where the axes meet
    """
    (sa, so), (ca, co) = np.sin(np.radians([latitude, longitude])), np.cos(np.radians([latitude, longitude]))
    R = np.array([[-so, -sa * co, ca * co], [co, -sa * so, ca * so], [0.0, ca, sa]])
    return Rigid3("geocentric", "enu", R, centre)


def _carried(poses: Sequence[Rigid3], transform: Callable[[Float], Float]) -> tuple[list[Rigid3], float]:
    """The poses after a transformation of points, and the largest relative difference between its scales."""
    if not poses:
        return [], 0.0
    turns, centres = np.array([p.R for p in poses]), np.array([p.t for p in poses])
    steps = _LEVER_M * np.swapaxes(turns, 1, 2)  # the axes of each camera, one per row
    probes = np.concatenate([centres[:, None], centres[:, None] + steps, centres[:, None] - steps], axis=1)
    moved = transform(probes.reshape(-1, 3)).reshape(-1, 7, 3)
    if not np.isfinite(moved).all():
        raise CrsError(
            "the positions of the cameras lie outside the area of their CRS; check the file", code="I204"
        )
    jacobian = np.swapaxes(moved[:, 1:4] - moved[:, 4:7], 1, 2) / (2 * _LEVER_M)
    U, scales, Vt = np.linalg.svd(jacobian)
    stretch = float((scales[:, 0] / scales[:, 2]).max() - 1.0)
    return [
        Rigid3("world", pose.frm, R, t) for pose, R, t in zip(poses, U @ Vt, moved[:, 0], strict=True)
    ], stretch
