"""Turns what view rays meet into the light they carry: diffuse surfaces, gloss, panes, sky."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.simulate.optics.glass import fresnel
from frontage.simulate.optics.light import sky_radiance
from frontage.simulate.optics.litscene import LitScene, ViewHits
from frontage.simulate.optics.materials import reflectance
from frontage.simulate.scene import Part

_ROOM = 0.35  # ambient light inside a room, relative to that outside
_SUN_IN_ROOM = 0.7  # share of the sunlight that a window lets pass
_TRANSMITTANCE = np.array([0.80, 0.85, 0.82], np.float32)  # of two clear sheets, besides reflection
_SURFACES = 4  # glass to air, of double glazing
_MIRRORED_OPENNESS = 0.5  # of what is seen in a pane, where the sky view factor is not sampled
_DUST = 0.012  # mean albedo of the dust on a pane


@dataclass(frozen=True, eq=False)
class SeenPoints:
    """Points at which n view rays end.

    triangle     (n,) int64, -1 = sky
    xyz          (n, 3) m local
    directions   (n, 3) unit vectors of the rays
    lit          (n,) whether the sun shines there
    openness     (n,) float32, sky view factor
    blur         (n,) float32 m, width of a pixel on the surface
    """

    triangle: Int
    xyz: Float
    directions: Float
    lit: Bool
    openness: Array
    blur: Array


def radiance(lit_scene: LitScene, view: ViewHits, which: Int, openness: Array, angle: float) -> Array:
    """Return the light (m, 3) float32 along the rays `which` (m,) of `view`.

    openness (m,) is that of the solid surfaces they end on; `angle` is in rad, between the rays of
    neighbouring pixels.
    """
    solid, directions = view.solid[which], view.directions[which]
    blur = _footprint(lit_scene, solid, directions, view.distance[which] * angle)
    rgb = surface_light(
        lit_scene, SeenPoints(solid, view.xyz[which], directions, view.lit[which], openness, blur)
    )
    place = np.full(len(view.solid), -1)
    place[which] = np.arange(len(which))
    at = np.flatnonzero(place[view.paned] >= 0)  # rows of the panes' arrays that are asked for
    if len(at):
        rows = place[view.paned[at]]
        rgb[rows] = _through_pane(lit_scene, view, at, rgb[rows], angle)
    return rgb


def surface_light(lit_scene: LitScene, points: SeenPoints) -> Array:
    """Return the light (n, 3) float32 that reaches the viewer from seen points, without panes in between."""
    rgb = np.empty((len(points.triangle), 3), np.float32)
    sky, hit = np.flatnonzero(points.triangle < 0), np.flatnonzero(points.triangle >= 0)
    rgb[sky] = sky_radiance(lit_scene.light, points.directions[sky])
    t, direction = points.triangle[hit], points.directions[hit]
    appearance = lit_scene.appearance
    surface = appearance.surface[t]
    normal, part = lit_scene.normals(t, direction), appearance.part[surface]
    albedo = reflectance(appearance, surface, points.xyz[hit], appearance.axes[t], points.blur[hit])
    light = lit_scene.light.ambient(normal, points.openness[hit])
    light[part == Part.ROOM] *= np.float32(_ROOM)
    slope = normal @ lit_scene.light.to_sun
    slope = np.where(part == Part.TREE, 0.35 + 0.65 * np.abs(slope), np.maximum(slope, 0.0))
    behind_glass = np.where(part == Part.ROOM, _SUN_IN_ROOM, 1.0)
    sunlight = (points.lit[hit] * slope * behind_glass).astype(np.float32)
    light += sunlight[:, None] * np.float32(lit_scene.light.sun)
    rgb[hit] = albedo * light
    _add_gloss(lit_scene, rgb, points, hit, normal)
    return rgb


def _add_gloss(lit_scene: LitScene, rgb: Array, points: SeenPoints, hit: Int, normal: Float) -> None:
    """Adds the sky that lacquer and metal mirror (Schlick's approximation) to rows `hit` (m,) of `rgb`.

    normal (m, 3); the mirrored sky is dimmed by the openness.
    """
    appearance = lit_scene.appearance
    surface = appearance.surface[points.triangle[hit]]
    gloss = appearance.gloss[appearance.material[surface]]
    shiny = np.flatnonzero((gloss > 0.02) & (appearance.part[surface] != Part.PANE))
    if not len(shiny):
        return
    at = hit[shiny]
    n, direction = normal[shiny], points.directions[at]
    cosine = -np.einsum("ij,ij->i", n, direction)
    share = gloss[shiny] * (0.04 + 0.96 * np.clip(1 - cosine, 0, 1) ** 5) * points.openness[at]
    mirrored = sky_radiance(lit_scene.light, direction + 2 * cosine[:, None] * n)
    rgb[at] = rgb[at] * (1 - gloss[shiny] * 0.3)[:, None] + share.astype(np.float32)[:, None] * mirrored


def _through_pane(lit_scene: LitScene, view: ViewHits, at: Int, inside: Array, angle: float) -> Array:
    """Returns the light (k, 3) from panes: the room's light `inside` (k, 3), mirrored surroundings, dust.

    `at` (k,) are rows of the panes' arrays of `view`.
    """
    appearance = lit_scene.appearance
    r = fresnel(view.cosine[at])
    reflected = (_SURFACES * r / (1 + (_SURFACES - 1) * r)).astype(np.float32)[:, None]
    pane, seen, direction = view.pane[at], view.mirror[at], view.mirror_direction[at]
    pane_distance = np.linalg.norm(view.pane_xyz[at] - view.xyz[view.paned[at]], axis=1)
    there = np.linalg.norm(view.mirror_xyz[at] - view.pane_xyz[at], axis=1)
    here = np.maximum(view.distance[view.paned[at]] - pane_distance, 0.0)
    here = np.where(np.isfinite(here), here, 0.0)
    flat = np.full(len(at), _MIRRORED_OPENNESS, np.float32)
    blur = _footprint(lit_scene, seen, direction, (here + there) * angle)
    points = SeenPoints(seen, view.mirror_xyz[at], direction, view.mirror_lit[at], flat, blur)
    mirrored = surface_light(lit_scene, points)
    blur = (here * angle).astype(np.float32)
    dust = reflectance(appearance, appearance.surface[pane], view.pane_xyz[at], appearance.axes[pane], blur)
    normal = lit_scene.normals(pane, view.directions[view.paned[at]])
    veil = (
        _DUST * dust / np.maximum(dust.mean(1, keepdims=True), 1e-3) * lit_scene.light.ambient(normal, flat)
    )
    return np.asarray(inside * (1 - reflected) * _TRANSMITTANCE + reflected * mirrored + veil, np.float32)


def _footprint(lit_scene: LitScene, triangle: Int, directions: Float, width: Float) -> Array:
    """Returns the width (n,) float32 m of a pixel on surfaces, from its `width` (n,) m across the ray."""
    cosine = np.abs(np.einsum("ij,ij->i", lit_scene.appearance.normals[triangle], directions))
    blur = width / np.sqrt(np.clip(cosine, 0.05, 1.0))
    return np.where(triangle >= 0, blur, 0.0).astype(np.float32)
