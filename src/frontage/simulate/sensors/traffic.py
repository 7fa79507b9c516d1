"""Traffic between two recordings: parked cars and pedestrians that have gone or stand elsewhere."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.simulate.scene import Part, Scene, SceneMesh

_MOVING = (Part.CAR, Part.PERSON)
_STANDING = (Part.TREE, Part.LAMP)
_GONE = 0.4  # share of those that move which are not there at all
_SHIFT_M = (1.5, 12.0)  # along the street
_TRIES = 12
_CLEAR_M = 0.3  # that is kept between things
_STATION_M = 1.2  # half-width of the place that a tripod takes
_STREAM = 0x3C7A


@lru_cache(maxsize=2)
def with_moved_traffic(
    scene: Scene, share: float, seed: int, clear: tuple[tuple[float, float], ...] = ()
) -> Scene:
    """Return `scene` as it was at another time of the day; the last two are cached.

    Of the cars and pedestrians, a `share` (0..1) has either gone or stands elsewhere along the street, clear
    of other things and of the places `clear` (x, y) m local. Surfaces keep their indices. With a share of 0
    it is the same scene.
    """
    if not share:
        return scene
    groups = _groups(scene)
    rng = np.random.default_rng([seed, scene.seed, _STREAM])
    street = scene.local_from_street.inverse.apply(scene.mesh.vertices)
    boxes = {name: _box(street[vertices]) for name, (_, vertices) in groups.items()}
    taken = [*boxes.values(), *_fixed(scene, street), *_stations(scene, clear)]
    keep = np.ones(len(scene.mesh.corners), np.bool_)
    rise = _slope(scene)
    for name, (triangles, vertices) in groups.items():
        goes, gone, tries = rng.random(), rng.random(), _draw_shifts(rng)
        if goes >= share:
            continue
        others = [box for box in taken if box is not boxes[name]]
        moves = [m for m in tries if _free(boxes[name] + [m, 0, m, 0], others)]
        if gone < _GONE or not moves:
            keep[triangles] = False
            continue
        street[vertices] += np.array([moves[0], 0.0, moves[0] * rise])
        taken.append(boxes[name] + [moves[0], 0, moves[0], 0])
    return _with_mesh(scene, scene.local_from_street.apply(street), keep)


def _groups(scene: Scene) -> dict[str, tuple[Int, Int]]:
    """Returns the triangles and the vertices of every car and pedestrian, by the beginning of their ids."""
    part = scene.parts[scene.mesh.surface]
    names = np.array([s.id.rpartition("/")[0] for s in scene.surfaces])[scene.mesh.surface]
    moving = np.flatnonzero(np.isin(part, _MOVING))
    found: dict[str, tuple[Int, Int]] = {}
    for name in dict.fromkeys(names[moving].tolist()):
        triangles = moving[names[moving] == name]
        found[name] = triangles, np.unique(scene.mesh.corners[triangles])
    return found


def _draw_shifts(rng: np.random.Generator) -> list[float]:
    size, sign = rng.uniform(*_SHIFT_M, _TRIES), rng.choice([-1.0, 1.0], _TRIES)
    return [float(s) for s in size * sign]


def _box(street: Float) -> Array:
    """Returns s and d of the lower, then of the upper corner (4,) m around points (n, 3), street frame."""
    return np.concatenate([street[:, :2].min(0), street[:, :2].max(0)])


def _fixed(scene: Scene, street: Float) -> list[Array]:
    """Returns the boxes of lamps and of the trunks of trees."""
    part = scene.parts[scene.mesh.surface]
    found = []
    for surface in np.unique(scene.mesh.surface[np.isin(part, _STANDING)]):
        points = street[np.unique(scene.mesh.corners[scene.mesh.surface == surface])]
        found.append(_box(points[points[:, 2] < points[:, 2].min() + 1.0]))
    return found


def _stations(scene: Scene, clear: Sequence[tuple[float, float]]) -> list[Array]:
    places = np.array([(x, y, 0.0) for x, y in clear]).reshape(-1, 3)
    at = scene.local_from_street.inverse.apply(places)[:, :2]
    return [np.concatenate([p - _STATION_M, p + _STATION_M]) for p in at]


def _free(box: Array, others: Sequence[Array]) -> bool:
    apart = (
        (box[:2] > np.array(other[2:]) + _CLEAR_M) | (box[2:] < np.array(other[:2]) - _CLEAR_M)
        for other in others
    )
    return all(bool(a.any()) for a in apart)


def _slope(scene: Scene) -> float:
    """Returns the rise of the street, m per m."""
    road = scene.local_from_street.inverse.apply(scene.road)
    run = float(road[-1, 0] - road[0, 0]) if len(road) else 0.0
    return float(road[-1, 2] - road[0, 2]) / run if run else 0.0


def _with_mesh(scene: Scene, vertices: Float, keep: Bool) -> Scene:
    """Returns the scene with other vertices (v, 3) m local and only the triangles `keep` (t,)."""
    mesh = SceneMesh(vertices, scene.mesh.corners[keep], scene.mesh.surface[keep])
    return replace(scene, mesh=mesh)
