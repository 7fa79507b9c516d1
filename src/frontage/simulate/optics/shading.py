"""From what rays of sight meet to the light they carry: diffuse surfaces, gloss, panes, sky."""

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.simulate.optics.glass import fresnel
from frontage.simulate.optics.light import sky_radiance
from frontage.simulate.optics.litscene import LitScene, ViewHits
from frontage.simulate.optics.materials import reflectance
from frontage.simulate.scene import Part

_ROOM = 0.35  # of the ambient light outside is what walls inside pass on to each other
_TINT = np.array([0.80, 0.85, 0.82], np.float32)  # transmittance of two clear sheets, besides reflection
_SURFACES = 4  # glass to air, of double glazing
_MIRRORED_OPENNESS = 0.5  # of what is seen in a pane; its ambient occlusion is not traced
_DUST = 0.012


def radiance(lit_scene: LitScene, view: ViewHits, which: Int, openness: Array, angle: float) -> Array:
    """Light (m, 3) float32 along the rays `which` (m,) of `view`.

    openness (m,) of the diffuse surfaces seen; angle rad between the rays of neighbouring pixels.
    """
    blur = _footprint(lit_scene, view.solid[which], view.ways[which], view.distance[which] * angle)
    rgb = surface_light(
        lit_scene, view.solid[which], view.xyz[which], view.ways[which], view.lit[which], openness, blur
    )
    place = np.full(len(view.solid), -1)
    place[which] = np.arange(len(which))
    at = np.flatnonzero(place[view.paned] >= 0)  # rows of the panes' arrays that are asked for
    if len(at):
        rows = place[view.paned[at]]
        rgb[rows] = _through_pane(lit_scene, view, at, rgb[rows], angle)
    return rgb


def surface_light(
    lit_scene: LitScene, triangle: Int, xyz: Float, ways: Float, lit: Bool, openness: Array, blur: Array
) -> Array:
    """Light (n, 3) float32 that triangles (n,), -1 = sky, send along rays (n, 3) ending at xyz (n, 3)."""
    rgb = np.empty((len(triangle), 3), np.float32)
    sky, hit = np.flatnonzero(triangle < 0), np.flatnonzero(triangle >= 0)
    rgb[sky] = sky_radiance(lit_scene.light, ways[sky])
    t, way = triangle[hit], ways[hit]
    appearance = lit_scene.appearance
    surface = appearance.surface[t]
    normal, part = lit_scene.normals(t, way), appearance.part[surface]
    albedo = reflectance(appearance, surface, xyz[hit], appearance.axes[t], blur[hit])
    light = lit_scene.light.ambient(normal, openness[hit])
    light[part == Part.ROOM] *= np.float32(_ROOM)
    slope = normal @ lit_scene.light.to_sun
    slope = np.where(part == Part.TREE, 0.35 + 0.65 * np.abs(slope), np.maximum(slope, 0.0))
    behind_glass = np.where(part == Part.ROOM, 0.7, 1.0)
    light += (lit[hit] * slope * behind_glass).astype(np.float32)[:, None] * np.float32(lit_scene.light.sun)
    rgb[hit] = albedo * light
    _add_gloss(lit_scene, rgb, hit, normal, way, surface, openness[hit])
    return rgb


def _add_gloss(
    lit_scene: LitScene, rgb: Array, hit: Int, normal: Float, ways: Float, surface: Array, openness: Array
) -> None:
    """The mirrored sky on lacquer and metal (Schlick's approximation), dimmed where the sky is hidden."""
    gloss = lit_scene.appearance.gloss[lit_scene.appearance.material[surface]]
    shiny = np.flatnonzero((gloss > 0.02) & (lit_scene.appearance.part[surface] != Part.PANE))
    if not len(shiny):
        return
    n, way = normal[shiny], ways[shiny]
    cosine = -np.einsum("ij,ij->i", n, way)
    share = gloss[shiny] * (0.04 + 0.96 * np.clip(1 - cosine, 0, 1) ** 5) * openness[shiny]
    mirrored = sky_radiance(lit_scene.light, way + 2 * cosine[:, None] * n)
    at = hit[shiny]
    rgb[at] = rgb[at] * (1 - gloss[shiny] * 0.3)[:, None] + share.astype(np.float32)[:, None] * mirrored


def _through_pane(lit_scene: LitScene, view: ViewHits, at: Int, inside: Array, angle: float) -> Array:
    """Panes `at` (k,): the room's light (k, 3) passed, the surroundings mirrored, dust in front."""
    r = fresnel(view.cosine[at])
    reflected = (_SURFACES * r / (1 + (_SURFACES - 1) * r)).astype(np.float32)[:, None]
    pane, seen, way = view.pane[at], view.mirror[at], view.mirror_way[at]
    pane_distance = np.linalg.norm(view.pane_xyz[at] - view.xyz[view.paned[at]], axis=1)
    there = np.linalg.norm(view.mirror_xyz[at] - view.pane_xyz[at], axis=1)
    here = np.maximum(view.distance[view.paned[at]] - pane_distance, 0.0)
    here = np.where(np.isfinite(here), here, 0.0)
    flat = np.full(len(at), _MIRRORED_OPENNESS, np.float32)
    blur = _footprint(lit_scene, seen, way, (here + there) * angle)
    mirrored = surface_light(lit_scene, seen, view.mirror_xyz[at], way, view.mirror_lit[at], flat, blur)
    surface = lit_scene.appearance.surface[pane]
    dust = reflectance(
        lit_scene.appearance,
        surface,
        view.pane_xyz[at],
        lit_scene.appearance.axes[pane],
        (here * angle).astype(np.float32),
    )
    normal = lit_scene.normals(pane, view.ways[view.paned[at]])
    veil = (
        _DUST * dust / np.maximum(dust.mean(1, keepdims=True), 1e-3) * lit_scene.light.ambient(normal, flat)
    )
    return np.asarray(inside * (1 - reflected) * _TINT + reflected * mirrored + veil, np.float32)


def _footprint(lit_scene: LitScene, triangle: Int, ways: Float, width: Float) -> Array:
    """Width (n,) float32 m of a pixel on the surface: `width` across the ray, stretched by obliqueness."""
    cosine = np.abs(np.einsum("ij,ij->i", lit_scene.appearance.normals[triangle], ways))
    blur = width / np.sqrt(np.clip(cosine, 0.05, 1.0))
    return np.where(triangle >= 0, blur, 0.0).astype(np.float32)
