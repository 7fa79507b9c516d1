"""True ortho-images and id images of facades, from parallel rays along the facade's normal."""

from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Array, Bool, Float, freeze
from frontage.simulate.optics.light import Light
from frontage.simulate.optics.litscene import LitScene
from frontage.simulate.optics.noise import scramble
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.optics.samples import group_samples, lattice
from frontage.simulate.optics.shading import SeenPoints, surface_light
from frontage.simulate.scene import FacadePlan, Part, Scene
from frontage.simulate.sensors.imaging import encode

_LOOSE = (Part.TREE, Part.CAR, Part.LAMP, Part.PERSON)
_FRONT_M = 0.3  # distance in front of the foremost protrusion at which rays start
_BACK_M = 25.0  # distance behind the plane beyond which nothing is seen
_MARGIN_M = 0.2  # around the outline
_SAMPLES = 4  # per pixel
_CHUNK = 200_000  # pixels traced at a time
_EVEN = Light(np.array([0.0, 0.0, 1.0]), np.zeros(3), np.full(3, 0.7), np.full(3, 0.4), 1.0, 0)
_PANE = np.array([0.030, 0.036, 0.042], np.float32)  # light that a pane adds to that of the room behind it
_TRANSMITTANCE = np.float32(0.75)  # of a pane


@dataclass(frozen=True, eq=False)
class OrthoTruth:
    """The true ortho-image of a facade in even light, without trees, cars, lamps and people.

    rgb      (h, w, 3) uint8, black where there is nothing
    opening  (h, w) int16, 1 + index of the facade's opening whose outline contains the pixel centre, 0 = none
    surface  (h, w) int32, index into `Scene.surfaces` of what is seen, panes included; -1 = nothing
    depth    (h, w) float32 m, y of what is seen in the facade frame; NaN = nothing
    corner   (x, z) m, facade frame, of the outer upper left corner of pixel (0, 0)
    gsd      m per pixel
    """

    rgb: Array
    opening: Array
    surface: Array
    depth: Array
    corner: tuple[float, float]
    gsd: float

    def __post_init__(self) -> None:
        h, w = self.opening.shape
        freeze(self, rgb=((h, w, 3), np.uint8), opening=((h, w), np.int16))
        freeze(self, surface=((h, w), np.int32), depth=((h, w), np.float32))


def true_ortho(scene: Scene, house: int, facade: int, gsd: float) -> OrthoTruth:
    """Return the true ortho-image of a facade at `gsd` m per pixel.

    `house` and `facade` are indices. The image covers the facade's outline and 0.2 m around it; pixels below
    the ground show nothing.
    """
    plan = scene.houses[house].facades[facade]
    (x0, z0), (x1, z1) = plan.outline.min(0) - _MARGIN_M, plan.outline.max(0) + _MARGIN_M
    loose = np.isin(scene.parts[scene.mesh.surface], [*_LOOSE, Part.GROUND])
    lit_scene = LitScene(
        scene, _EVEN, ~loose & _within(scene, plan, (x0, _front(plan), z0), (x1, _BACK_M, z1))
    )
    w, h = int(np.ceil((x1 - x0) / gsd)), int(np.ceil((z1 - z0) / gsd))
    corner = (float(x0), float(z1))
    x, z = x0 + gsd * (np.arange(w) + 0.5), z1 - gsd * (np.arange(h) + 0.5)
    buried = z[:, None] < _ground(scene, plan, x)
    parts = [_rows(lit_scene, plan, x, z[k : k + _CHUNK // w + 1], gsd) for k in range(0, h, _CHUNK // w + 1)]
    light, surface, depth = (np.concatenate(p) for p in zip(*parts, strict=True))
    surface[buried], depth[buried] = -1, np.nan
    light[surface < 0] = 0.0
    return OrthoTruth(encode(light), _holes(plan, x, z), surface, depth, corner, gsd)


def _rows(
    lit_scene: LitScene, plan: FacadePlan, x: Float, z: Float, gsd: float
) -> tuple[Array, Array, Array]:
    """Renders some rows: light (r, w, 3) float32, surface and depth (r, w)."""
    centre = np.stack(np.broadcast_arrays(x, 0.0, z[:, None]), axis=-1).reshape(-1, 3)
    triangle, y = _cast(lit_scene.every, plan, centre)
    surface = np.where(triangle >= 0, lit_scene.appearance.surface[triangle], -1).astype(np.int32)
    offsets = gsd * np.insert(lattice(_SAMPLES), 1, 0.0, axis=1)
    light = _light(lit_scene, plan, (centre[:, None] + offsets).reshape(-1, 3), gsd)
    shape = (len(z), len(x))
    return light.reshape(*shape, 3), surface.reshape(shape), y.astype(np.float32).reshape(shape)


def _light(lit_scene: LitScene, plan: FacadePlan, at: Float, gsd: float) -> Array:
    """Returns the mean light (n, 3) float32 of every four samples at facade points (4 n, 3)."""
    triangle, y = _cast(lit_scene.every, plan, at)
    key = lit_scene.faces[triangle]
    paned = np.flatnonzero(lit_scene.is_pane[triangle] & (triangle >= 0))
    triangle[paned], y[paned] = _cast(lit_scene.solid, plan, at[paned])
    through = np.zeros(len(at), np.bool_)
    through[paned] = True
    key = scramble(key, 1) ^ lit_scene.faces[triangle]
    groups = group_samples(key, _SAMPLES)
    pick = groups.pick
    rgb = np.zeros((len(pick), 3), np.float32)
    hit = np.flatnonzero(triangle[pick] >= 0)
    seen = pick[hit]
    middle = groups.mean(np.column_stack([at[:, 0], y, at[:, 2]]))[hit]
    xyz = plan.local_from_facade.apply(middle)
    directions = np.broadcast_to(plan.local_from_facade.R[:, 1], xyz.shape)
    flat, blur = np.ones(len(seen), np.float32), np.full(len(seen), gsd, np.float32)
    dark = np.zeros(len(seen), np.bool_)
    rgb[hit] = surface_light(lit_scene, SeenPoints(triangle[seen], xyz, directions, dark, flat, blur))
    rgb[through[pick]] = rgb[through[pick]] * _TRANSMITTANCE + _PANE
    return groups.blend(rgb)


def _cast(tracer: Tracer, plan: FacadePlan, at: Float) -> tuple[Array, Float]:
    """Casts rays at facade points (n, 3) along the normal: triangle (n,), -1 = none; y (n,) m, NaN = none."""
    front = _front(plan)
    start = plan.local_from_facade.apply(np.column_stack([at[:, 0], np.full(len(at), front), at[:, 2]]))
    hits = tracer.first_hit(start, np.broadcast_to(plan.local_from_facade.R[:, 1], start.shape))
    return hits.triangle, np.where(hits.found, front + hits.distance, np.nan)


def _front(plan: FacadePlan) -> float:
    """Returns the y (m) from which rays start."""
    return min([0.0, *(p.y_range[0] for p in plan.protrusions)]) - _FRONT_M


def _within(scene: Scene, plan: FacadePlan, low: tuple[float, ...], high: tuple[float, ...]) -> Bool:
    """Returns which triangles (t,) have a bounding box that overlaps a box (low, high), facade frame."""
    corners = plan.local_from_facade.inverse.apply(scene.mesh.vertices)[scene.mesh.corners]
    return np.asarray(((corners.max(1) >= low) & (corners.min(1) <= high)).all(1))


def _ground(scene: Scene, plan: FacadePlan, x: Float) -> Float:
    """Returns the height z (w,) m, facade frame, of the ground just in front of the wall; -inf for none."""
    top = float(plan.outline[:, 1].max()) + 1.0
    start = np.column_stack([x, np.full(len(x), -0.05), np.full(len(x), top)])
    frame = plan.local_from_facade
    down = np.broadcast_to(-frame.R[:, 2], start.shape)
    ground = np.asarray(scene.parts[scene.mesh.surface] == Part.GROUND)
    hits = Tracer(scene.mesh, ground).first_hit(frame.apply(start), down)
    return np.where(hits.found, top - hits.distance, -np.inf)


def _holes(plan: FacadePlan, x: Float, z: Float) -> Array:
    """Returns 1 + the index of the opening whose ring contains each pixel centre (h, w) int16, 0 = none."""
    image = np.zeros((len(z), len(x)), np.int16)
    for k, opening in enumerate(plan.openings):
        (a, c), (b, d) = opening.ring.min(0), opening.ring.max(0)
        columns, rows = np.flatnonzero((x >= a) & (x <= b)), np.flatnonzero((z >= c) & (z <= d))
        px, pz = np.meshgrid(x[columns], z[rows])
        inside = shapely.contains_xy(shapely.Polygon(opening.ring), px, pz)
        block = image[np.ix_(rows, columns)]
        image[np.ix_(rows, columns)] = np.where(inside, np.int16(k + 1), block)
    return image
