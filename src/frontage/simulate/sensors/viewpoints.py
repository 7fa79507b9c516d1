"""Where photos are taken from, and where the camera's own GPS and compass say so."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from frontage.errors import OptionError
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import FacadePlan, Part, Scene
from frontage.simulate.sensors.cameras import CameraSpec, Standpoint

_LOOSE = (Part.TREE, Part.CAR, Part.LAMP, Part.PERSON)
_BACK = 0.8  # m kept from the houses behind
_ROOM = 0.5  # m that a photographer needs around the camera
_DODGE = 0.7  # m further along when something stands in the way
_OVERLAP = 0.75
_FILM, _WIDEST = 36.0, 18.0  # mm: width of 35 mm film; shorter lenses do not widen the spacing
_FARTHEST = 99.0  # m
_COMMON = 0.7  # share of a GPS's variance that is the same for photos taken within minutes


@dataclass(frozen=True, eq=False)
class PlannedPhoto:
    """A photo to be taken: its name, its true pose and the given one, time s since the first."""

    name: str
    true: Rigid3
    given: Rigid3
    time: float


@lru_cache(maxsize=8)
def plan_photos(scene: Scene, spec: CameraSpec, seed: int) -> tuple[PlannedPhoto, ...]:
    """The poses of all photos, in the order they are taken; the last plans are remembered.

    A walk goes along the facades of one side, as far across the street as it is wide (or `spec.distance`),
    steps aside for trees and cars, and aims by hand: 1.5 degrees and some centimetres off.
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
    line = turn * float((turn * fronts[:, 1]).min())  # the foremost front
    away = _distance(scene, spec, fronts, line, turn)
    field = away * min(spec.width / spec.height, 1.0) * _FILM / max(spec.focal, _WIDEST)
    step = spec.spacing or (1 - _OVERLAP) * field
    stops = np.linspace(first, last, max(2, int(np.ceil((last - first) / step)) + 1))
    if spec.most is not None:
        stops = _thinned(stops, -(-spec.most // (len(spec.headings) * len(spec.pitches))))
    bodies = Tracer(scene.mesh, scene.parts[scene.mesh.surface] != Part.GROUND)
    places = []
    for stop in stops:
        along, across = stop + rng.normal(0, 0.08), line - turn * (away + rng.normal(0, 0.1))
        along = _dodged(scene, bodies, along, across, spec.eye)
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
    """Lower corners (2 f, 3) of the facades on one side that look at the street, street frame."""
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
    """How far from the foremost facade (m) photos are taken: as asked, but never inside what stands opposite.

    The free width is measured from the road, which nothing fixed stands on.
    """
    street = scene.local_from_street
    road = street.inverse.apply(scene.road)
    along = np.linspace(fronts[:, 0].min(), fronts[:, 0].max(), 64)
    level = [np.interp(along, road[:, 0], road[:, k]) for k in (1, 2)]
    start = np.column_stack([along, *level]) + np.array([0.0, 0.0, spec.eye])
    fixed = ~np.isin(scene.parts[scene.mesh.surface], [*_LOOSE, Part.GROUND])
    way = np.broadcast_to([0.0, -turn, 0.0], start.shape)
    hits = Tracer(scene.mesh, fixed).first_hit(street.apply(start), street.rotate(way))
    reach = np.abs(start[:, 1] - line) + np.minimum(hits.distance, _FARTHEST)
    free = float(np.quantile(reach, 0.1)) - _BACK
    tall = max((h.eaves_z - h.ground_z for h in scene.houses), default=10.0)
    return max(1.5, min(free, spec.distance or min(max(1.3 * tall, 8.0), 25.0)))


def _dodged(scene: Scene, bodies: Tracer, along: float, across: float, eye: float) -> float:
    """`along`, moved on until nothing is within arm's reach of the camera."""
    turns = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ways = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(24)])
    ways = np.concatenate([ways, ways * 0.7 + [0, 0, 0.7], ways * 0.7 - [0, 0, 0.7]])
    road = scene.local_from_street.inverse.apply(scene.road)
    for k in range(8):
        moved = along + k * _DODGE
        place = np.array([[moved, across, np.interp(moved, road[:, 0], road[:, 2]) + eye]])
        hits = bodies.first_hit(scene.local_from_street.apply(place), ways)
        if not (hits.distance < _ROOM).any():
            return moved
    return along


def _pose(scene: Scene, ground: Tracer, place: Standpoint) -> Rigid3:
    """local_from_camera of a standpoint: its height is above the ground, above the road where none is."""
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
    """The poses as GPS, compass and level know them: GPS errors are mostly common, the others are not."""
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
    """Rotation matrix (3, 3) about a coordinate axis."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[i, i] = R[j, j] = c
    R[i, j], R[j, i] = -s, s
    return R
