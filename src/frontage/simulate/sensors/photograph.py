"""Takes photographs of a scene, and colours points as a scanner's camera does."""

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.model import Estimate, Photo
from frontage.model.estimate import Provenance
from frontage.simulate.optics.light import LightSpec, draw_light
from frontage.simulate.optics.litscene import LitScene
from frontage.simulate.optics.materials import shade
from frontage.simulate.optics.shading import SeenPoints, surface_light
from frontage.simulate.scene import Scene
from frontage.simulate.sensors.cameras import CameraSpec, make_camera
from frontage.simulate.sensors.imaging import develop, encode
from frontage.simulate.sensors.recording import Shot
from frontage.simulate.sensors.render import render
from frontage.simulate.sensors.viewpoints import plan_photos

_OPENNESS = 0.55  # sky view factor of a typical wall of a street
_WHITE = 0.75  # linear code of a white surface in the mean light of a street, in scan colours
_CHUNK = 500_000


def take_photographs(scene: Scene, spec: CameraSpec, seed: int = 0) -> tuple[Shot, ...]:
    """Take all photos that `spec` asks for; the same scene, specification and seed give the same bytes.

    Raises MissingExtra if embreex is not installed, OptionError when there is no house to photograph or the
    camera sees nothing in the middle of its picture.
    """
    return tuple(iter_photographs(scene, spec, seed))


def iter_photographs(
    scene: Scene, spec: CameraSpec, seed: int = 0, only: Sequence[int] | None = None
) -> Iterator[Shot]:
    """Take photos as `take_photographs` does, but one at a time, so that only one picture is in memory.

    `viewpoints.plan_photos` tells how many there are. `only` are the numbers of the photos to take now,
    counted from 0; photos do not depend on one another.
    """
    camera = make_camera(spec, seed)
    lit_scene = lit_scene_of(scene, spec.light)
    aims = plan_photos(scene, spec, seed)
    for k in range(len(aims)) if only is None else only:
        aim = aims[k]
        light = render(lit_scene, camera, aim.true, spec.samples)
        image = develop(light, spec, np.random.default_rng([seed, 0xF117, k]))
        exact = Estimate(aim.true, np.zeros((6, 6)), np.inf, Provenance.GIVEN)
        yield Shot(image, Photo(aim.name, camera, exact, aim.time), aim.given)


@lru_cache(maxsize=2)
def lit_scene_of(scene: Scene, light: LightSpec) -> LitScene:
    """Return the scene in its light, ready for casting rays; the last two are cached."""
    return LitScene(scene, draw_light(scene, light))


def scan_colours(
    scene: Scene, surface: Array, xyz: Float, seen_from: Float | None = None, light: LightSpec | None = None
) -> Array:
    """Return the colours (n, 3) uint8 that a scanner's camera gives to points (n, 3) m local.

    `surface` (n,) are the indices of their surfaces; points without one (-1) are grey. `seen_from` (3,) or
    (n, 3) m local is where the camera stood: points that it sees are shaded by sun and sky as in the photos.
    Points that it does not see (stray, mixed, hidden) get the colour of their surface in even light, and so
    do all points if `seen_from` is None.
    """
    surface = np.asarray(surface)
    lit_scene = lit_scene_of(scene, light or LightSpec())
    rgb = np.full((len(xyz), 3), 0.3, np.float32)
    even = lit_scene.light.ambient(np.array([[0.0, 0.0, 0.0]]), np.array([_OPENNESS], np.float32))
    even += np.asarray(0.35 * lit_scene.light.sun, np.float32)
    for start in range(0, len(xyz), _CHUNK):
        at = start + np.flatnonzero(surface[start : start + _CHUNK] >= 0)
        rgb[at] = shade(scene, surface[at], xyz[at]) * even
        if seen_from is not None:
            origin = np.broadcast_to(seen_from, xyz.shape)[at]
            seen, colour = _seen(lit_scene, surface[at], xyz[at], origin)
            rgb[at[seen]] = colour
    return encode(rgb * np.float32(_WHITE / float(even.mean())))


def _seen(lit_scene: LitScene, surface: Array, xyz: Float, origin: Float) -> tuple[Array, Array]:
    """Returns which k points a camera at `origin` (n, 3) really sees, and their light (k, 3)."""
    directions = xyz - origin
    reach = np.linalg.norm(directions, axis=1)
    directions = directions / np.maximum(reach, 1e-9)[:, None]
    hits = lit_scene.solid.first_hit(origin, directions)
    seen = np.flatnonzero(hits.found & (lit_scene.appearance.surface[hits.triangle] == surface))
    triangle, place = hits.triangle[seen], origin[seen] + directions[seen] * hits.distance[seen, None]
    lit = lit_scene.sunny(triangle, place, directions[seen])
    free = np.full(len(seen), _OPENNESS, np.float32)
    blur = np.full(len(seen), 0.003, np.float32)  # m, pixel of a scanner's panorama at about 10 m
    return seen, surface_light(lit_scene, SeenPoints(triangle, place, directions[seen], lit, free, blur))
