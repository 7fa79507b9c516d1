"""Plans where photos are taken from, and the poses that the camera's GPS and compass report."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from frontage.errors import OptionError
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import FacadePlan, Part, Scene
from frontage.simulate.sensors.cameras import FILM_MM, CameraSpec, Standpoint

_LOOSE = (Part.TREE, Part.CAR, Part.LAMP, Part.PERSON)
_BACK_M = 0.8  # distance that is kept from the houses behind
_CLEARANCE_M = 0.5  # free radius that a photographer needs around the camera
_DODGE_M = 0.7  # step along the street when something stands in the way
_OVERLAP = 0.75  # of neighbouring photos
_WIDEST_MM = 18.0  # shorter focal lengths (35 mm equivalent) do not widen the spacing
_FARTHEST_M = 99.0
_COMMON = 0.7  # share of the variance of GPS errors that is common to photos taken within minutes


@dataclass(frozen=True, eq=False)
class PlannedPhoto:
    """A photo to be taken: its name, its true and its reported pose, and the time (s) since the first."""

    name: str
    true: Rigid3
    given: Rigid3
    time: float


@lru_cache(maxsize=8)
def plan_photos(scene: Scene, spec: CameraSpec, seed: int) -> tuple[PlannedPhoto, ...]:
    """Return the poses of all photos in the order in which they are taken; the last plans are cached.

    A walk leads along the facades of one side, at the other edge of the street (or at `spec.distance`). It
    avoids trees and cars, and the camera is aimed by hand: 1.5 degrees and some centimetres off.

    Raises OptionError when there is no house on the side that is to be photographed.
    """
    rng = np.random.default_rng([seed, 0x57A9])
    places = spec.places if spec.layout == "places" else _walk(scene, spec, rng)
    ground = Tracer(scene.mesh, scene.parts[scene.mesh.surface] == Part.GROUND)
    true = [_pose(scene, ground, place) for place in places]
    return tuple(
        PlannedPhoto(f"IMG_{k + 1:04d}.jpg", pose, given, 4.0 * k)
        for k, (pose, given) in enumerate(zip(true, _given(true, spec, rng), strict=True))
    )


def _walk(scene: Scene, spec: CameraSpec, rng: np.random.Generator) -> tuple[Standpoint, ...]:
    fronts = _fronts(scene, spec.side)
    first, last = fronts[:, 0].min(), fronts[:, 0].max()
    turn = 1.0 if spec.side == 0 else -1.0
    line = turn * float((turn * fronts[:, 1]).min())  # of the foremost front
    away = _distance(scene, spec, fronts, line, turn)
    field = away * min(spec.width / spec.height, 1.0) * FILM_MM / max(spec.focal, _WIDEST_MM)
    step = spec.spacing or (1 - _OVERLAP) * field
    stops = np.linspace(first, last, max(2, int(np.ceil((last - first) / step)) + 1))
    if spec.most is not None:
        stops = _thinned(stops, -(-spec.most // (len(spec.headings) * len(spec.pitches))))
    bodies = Tracer(scene.mesh, scene.parts[scene.mesh.surface] != Part.GROUND)
    places = []
    for stop in stops:
        along, across = stop + rng.normal(0, 0.08), line - turn * (away + rng.normal(0, 0.1))
        along = _avoid_obstacles(scene, bodies, along, across, spec.eye)
        for heading in spec.headings:
            for pitch in spec.pitches:
                h, p, r = np.array([heading, pitch, 0.0]) + rng.normal(0, 1.5, 3) * [1, 1, 0.5]
                h = (h + 180 * spec.side + 180) % 360 - 180
                eye = spec.eye + rng.normal(0, 0.03)
                places.append(Standpoint(along=along, across=across, height=eye, heading=h, pitch=p, roll=r))
    return tuple(places[: spec.most])


def _thinned(stops: Float, most: int) -> Float:
    if len(stops) <= most:
        return stops
    middle = (stops[:1] + stops[-1:]) / 2
    return np.asarray(np.linspace(stops[0], stops[-1], most) if most > 1 else middle)


def _fronts(scene: Scene, side: int) -> Float:
    """Returns the lower corners (2 f, 3), street frame, of the facades on one side that face the street."""
    street_from_local = scene.local_from_street.inverse
    ends = []
    for house in scene.houses:
        for facade in house.facades if house.side == side else ():
            inward = street_from_local.rotate(facade.local_from_facade.R[:, 1][None])[0]
            if inward[1] * (1 - 2 * side) > 0.7:
                ends.append(street_from_local.apply(facade.local_from_facade.apply(_foot(facade))))
    if not ends:
        raise OptionError(f"there is no house on side {side} to photograph; choose the other side or places")
    return np.concatenate(ends)


def _foot(facade: FacadePlan) -> Float:
    x = facade.outline[:, 0]
    return np.array([[x.min(), 0.0, 0.0], [x.max(), 0.0, 0.0]])


def _distance(scene: Scene, spec: CameraSpec, fronts: Float, line: float, turn: float) -> float:
    """Returns how far (m) from the foremost facade photos are taken, as asked but never inside a house.

    The free width is measured from the road, on which nothing fixed stands.
    """
    street = scene.local_from_street
    road = street.inverse.apply(scene.road)
    along = np.linspace(fronts[:, 0].min(), fronts[:, 0].max(), 64)
    level = [np.interp(along, road[:, 0], road[:, k]) for k in (1, 2)]
    start = np.column_stack([along, *level]) + np.array([0.0, 0.0, spec.eye])
    fixed = ~np.isin(scene.parts[scene.mesh.surface], [*_LOOSE, Part.GROUND])
    direction = np.broadcast_to([0.0, -turn, 0.0], start.shape)
    hits = Tracer(scene.mesh, fixed).first_hit(street.apply(start), street.rotate(direction))
    reach = np.abs(start[:, 1] - line) + np.minimum(hits.distance, _FARTHEST_M)
    free = float(np.quantile(reach, 0.1)) - _BACK_M
    tall = max((h.eaves_z - h.ground_z for h in scene.houses), default=10.0)
    return max(1.5, min(free, spec.distance or min(max(1.3 * tall, 8.0), 25.0)))


def _avoid_obstacles(scene: Scene, bodies: Tracer, along: float, across: float, eye: float) -> float:
    """Moves the position `along` the street on until nothing stands too close to the camera."""
    turns = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    directions = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(24)])
    directions = np.concatenate([directions, directions * 0.7 + [0, 0, 0.7], directions * 0.7 - [0, 0, 0.7]])
    road = scene.local_from_street.inverse.apply(scene.road)
    for k in range(8):
        moved = along + k * _DODGE_M
        place = np.array([[moved, across, np.interp(moved, road[:, 0], road[:, 2]) + eye]])
        hits = bodies.first_hit(scene.local_from_street.apply(place), directions)
        if not (hits.distance < _CLEARANCE_M).any():
            return moved
    return along


def _pose(scene: Scene, ground: Tracer, place: Standpoint) -> Rigid3:
    """Returns local_from_camera of a standpoint, whose height is above the ground or else above the road."""
    street = scene.local_from_street
    road = street.inverse.apply(scene.road)
    level = float(np.interp(place.along, road[:, 0], road[:, 2]))
    top = np.array([[place.along, place.across, level + 30.0]])
    hit = ground.first_hit(street.apply(top), street.rotate(np.array([[0.0, 0.0, -1.0]])))
    if hit.found[0]:
        level = level + 30.0 - float(hit.distance[0])
    h, p, r = np.radians([place.heading, place.pitch, place.roll])
    forward = np.array([np.sin(h) * np.cos(p), np.cos(h) * np.cos(p), np.sin(p)])
    right = np.array([np.cos(h), -np.sin(h), 0.0])
    down = np.cross(forward, right)
    axes = [np.cos(r) * right + np.sin(r) * down, np.cos(r) * down - np.sin(r) * right, forward]
    centre = street.apply(np.array([[place.along, place.across, level + place.height]]))[0]
    return Rigid3("local", "camera", street.R @ np.column_stack(axes), centre)


def _given(true: list[Rigid3], spec: CameraSpec, rng: np.random.Generator) -> list[Rigid3]:
    """Draws the poses that GPS, compass and level report; GPS errors are mostly common to all photos."""
    n = len(true)
    shift = np.sqrt(_COMMON) * rng.normal(size=3) + np.sqrt(1 - _COMMON) * rng.normal(size=(n, 3))
    heading = np.radians(spec.sigma_heading) * (0.6 * rng.normal() + 0.8 * rng.normal(size=n))
    level = np.radians(spec.sigma_level) * rng.normal(size=(n, 2))
    given = []
    for k, pose in enumerate(true):
        R = _about(2, heading[k]) @ pose.R @ _about(0, level[k, 0]) @ _about(2, level[k, 1])
        given.append(Rigid3("local", "camera", R, pose.t + spec.sigma_position * shift[k]))
    return given


def _about(axis: int, angle: float) -> Float:
    """Returns the rotation matrix (3, 3) about a coordinate axis by `angle` rad."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[i, i] = R[j, j] = c
    R[i, j], R[j, i] = -s, s
    return R
