"""A lit scene: what a ray of sight meets, directly, behind a pane and mirrored in it."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.simulate.optics import noise
from frontage.simulate.optics.appearance import Appearance, appearance_of
from frontage.simulate.optics.light import Light
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import Part, Scene

_OFF = 1e-3  # m: rays start this far off the surface they leave
_SAME_PLANE = 0.004  # m
_FARTHEST = 1e4  # m
_TILT = 0.0015  # rad, one sigma of a pane's tilt out of the frame's plane
_BULGE = 0.0016  # rad, one sigma of the slope of a pane's waves (roller waves, sealed air)


@dataclass(frozen=True, eq=False)
class ViewHits:
    """What rays (n,) of sight meet.

    solid (n,) int64: triangle behind any pane, -1 = sky; xyz (n, 3) where; lit (n,) whether in the sun
    distance (n,) m along the ray to it
    paned (k,): which rays cross a pane; cosine (k,) of incidence on it; pane (k,) its triangle
    mirror (k,) int64: triangle that the pane mirrors, -1 = sky, with mirror_xyz and mirror_way (k, 3)
    key (n,) uint32: equal for rays that see the same faces in the same light
    """

    ways: Float
    solid: Int
    xyz: Float
    distance: Float
    lit: Bool
    paned: Int
    pane: Int
    pane_xyz: Float
    cosine: Float
    mirror: Int
    mirror_xyz: Float
    mirror_way: Float
    mirror_lit: Bool
    key: Array


class LitScene:
    """A scene with its light and the trees for casting rays; `keep` (t,) leaves triangles out."""

    def __init__(self, scene: Scene, light: Light, keep: Bool | None = None) -> None:
        self.scene, self.light, self.appearance = scene, light, appearance_of(scene)
        kept = np.ones(len(scene.mesh.corners), np.bool_) if keep is None else keep
        self.is_pane = self.appearance.part[self.appearance.surface] == Part.PANE
        self.every = Tracer(scene.mesh, kept)
        self.solid = Tracer(scene.mesh, kept & ~self.is_pane)
        self.faces = _faces(scene, self.appearance)
        apex = scene.mesh.vertices[scene.mesh.corners[:, 0]]
        self._offset = np.append(np.einsum("ij,ij->i", apex, self.appearance.normals[:-1]), 0.0)

    def cast(self, origin: Float, ways: Float) -> ViewHits:
        """Cast rays from `origin` (3,) m local along unit vectors (n, 3)."""
        hits = self.every.first_hit(origin, ways)
        solid, distance = hits.triangle.copy(), hits.distance.copy()
        paned = np.flatnonzero(self.is_pane[solid] & (solid >= 0))
        pane, pane_distance = solid[paned], distance[paned]
        behind = self.solid.first_hit(origin, ways[paned])
        solid[paned], distance[paned] = behind.triangle, behind.distance
        xyz = _along(origin, ways, distance)
        pane_xyz = _along(origin, ways[paned], pane_distance)
        cosine, mirror_way = self._mirrored(pane, pane_xyz, ways[paned])
        mirror = self.every.first_hit(pane_xyz, mirror_way, skip=_OFF)
        mirror_xyz = _along(pane_xyz, mirror_way, mirror.distance)
        lit = self.sunny(solid, xyz, ways)
        mirror_lit = self.sunny(mirror.triangle, mirror_xyz, mirror_way)
        key = self._key(solid, lit)
        key[paned] = noise.scramble(key[paned], 1) ^ self._key(mirror.triangle, mirror_lit)
        key[paned] ^= noise.scramble(self.faces[pane], 5)
        return ViewHits(
            ways, solid, xyz, distance, lit, paned, pane, pane_xyz, cosine,
            mirror.triangle, mirror_xyz, mirror_way, mirror_lit, key,
        )  # fmt: skip

    def follow(self, view: ViewHits, rows: Int, origin: Float, ways: Float) -> ViewHits:
        """What rays (n, 3) from `origin` meet that see the same faces in the same light as `rows` of `view`.

        Nothing is cast: the rays are cut with the planes of those faces.
        """
        solid = view.solid[rows]
        distance = self._reach(solid, origin, ways)
        xyz = _along(origin, ways, distance)
        place = np.full(len(view.solid), -1)
        place[view.paned] = np.arange(len(view.paned))
        paned = np.flatnonzero(place[rows] >= 0)
        of = place[rows[paned]]
        pane, mirror = view.pane[of], view.mirror[of]
        pane_xyz = _along(origin, ways[paned], self._reach(pane, origin, ways[paned]))
        cosine, mirror_way = self._mirrored(pane, pane_xyz, ways[paned])
        mirror_xyz = _along(pane_xyz, mirror_way, self._reach(mirror, pane_xyz, mirror_way))
        return ViewHits(
            ways, solid, xyz, distance, view.lit[rows], paned, pane, pane_xyz, cosine,
            mirror, mirror_xyz, mirror_way, view.mirror_lit[of], view.key[rows],
        )  # fmt: skip

    def _reach(self, triangle: Int, origin: Float, ways: Float) -> Float:
        """Distance (n,) m along rays to the planes of triangles (n,), inf for the sky."""
        normal = self.appearance.normals[triangle]
        slope = np.einsum("ij,ij->i", normal, ways)
        start = np.einsum("ij,ij->i", normal, np.broadcast_to(origin, ways.shape))
        height = self._offset[triangle] - start
        flat = np.abs(slope) < 1e-9
        reach = np.clip(height / np.where(flat, 1.0, slope), 0.0, _FARTHEST)
        return np.where(triangle >= 0, reach, np.inf)

    def _mirrored(self, pane: Int, xyz: Float, ways: Float) -> tuple[Float, Float]:
        """Cosine (k,) of incidence on panes and the mirrored directions (k, 3)."""
        normal = self._bent(pane, xyz, ways)
        cosine = -np.einsum("ij,ij->i", normal, ways)
        return cosine, ways + 2 * cosine[:, None] * normal

    def normals(self, triangle: Int, ways: Float) -> Float:
        """Unit normals (n, 3) of triangles, turned against the rays (n, 3) seeing them; vertical for sky."""
        n = self.appearance.normals[triangle]
        n *= np.where(np.einsum("ij,ij->i", n, ways) > 0, -1.0, 1.0)[:, None]
        return n

    def sunny(self, triangle: Int, xyz: Float, ways: Float) -> Bool:
        """Whether the sun shines on the seen side of triangles (n,) at xyz (n, 3); panes let it pass."""
        lit = np.zeros(len(triangle), np.bool_)
        if self.light.overcast >= 1:
            return lit
        normal = self.normals(triangle, ways)
        thin = (
            self.appearance.part[self.appearance.surface[triangle]] == Part.TREE
        )  # light comes through leaves
        facing = np.flatnonzero((triangle >= 0) & ((normal @ self.light.to_sun > 1e-3) | thin))
        start = xyz[facing] + _OFF * normal[facing]
        way = np.broadcast_to(self.light.to_sun, start.shape)
        lit[facing] = ~self.solid.blocked(start, way, np.inf, skip=_OFF)
        return lit

    def openness(self, triangle: Int, xyz: Float, ways: Float, count: int) -> Array:
        """Share (n,) float32 of the hemisphere over seen points that is free: `count` cosine-weighted rays.

        The directions are a function of the position.
        """
        normal = self.normals(triangle, ways)
        start = xyz + _OFF * normal
        free = np.zeros(len(triangle), np.float32)
        i, j, k = (np.floor(xyz[:, a] * 4096).astype(np.int64).astype(np.int32) for a in range(3))
        seed = (k.astype(np.uint32) * np.uint32(0x9E3779B1)).astype(np.uint32)
        turn, height = noise.cell(i, j, seed, 1), noise.cell(i, j, seed, 2)
        for s in range(count):
            way = _hemisphere(normal, (turn + s * 0.6180340) % 1.0, (height + s) / count % 1.0)
            free += ~self.solid.blocked(start, way, np.inf, skip=_OFF)
        return np.asarray(free / np.float32(count))

    def _bent(self, pane: Int, xyz: Float, ways: Float) -> Float:
        """Normals (k, 3) of panes against the rays: every pane is tilted and wavy by a little."""
        normal = self.normals(pane, ways)
        surface = self.appearance.surface[pane]
        u, v = self.appearance.texture_coordinates(surface, xyz, np.zeros(len(pane), np.uint8))
        seed, blur = surface.astype(np.uint32), np.zeros(len(pane), np.float32)
        frame = self.appearance.frame[surface]
        for k in (0, 1):
            tilt = noise.cell(surface, surface * 0 + k, seed, 3) - 0.5
            slope = _TILT * 3.5 * tilt + _BULGE * noise.wave(u, v, 1.3, seed, 4 + k, blur)
            normal = normal + slope[:, None] * frame[:, k]
        return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))

    def _key(self, triangle: Int, lit: Bool) -> Array:
        return np.asarray(
            noise.scramble(self.faces[triangle], 2) ^ (lit.astype(np.uint32) * np.uint32(0x68E31DA4))
        )


def _along(origin: Float, ways: Float, distance: Float) -> Float:
    """Points (n, 3) at distances (n,) m along rays; the origin where that is infinite."""
    return np.asarray(origin + ways * np.where(np.isfinite(distance), distance, 0.0)[:, None])


def _faces(scene: Scene, appearance: Appearance) -> Array:
    """A number > 0 per triangle, equal for those of one surface in one plane; (t + 1,) uint32, the last 0."""
    normals = appearance.normals[:-1]
    n = np.round(normals * 64).astype(np.int64)
    apex = scene.mesh.vertices[scene.mesh.corners[:, 0]]
    offset = np.round(np.einsum("ij,ij->i", apex, normals) / _SAME_PLANE).astype(np.int64)
    rows = np.column_stack([appearance.surface.astype(np.int64), n, offset])
    _, number = np.unique(rows, axis=0, return_inverse=True)
    return np.append(number.reshape(-1) + 1, 0).astype(np.uint32)


def _hemisphere(normal: Float, turn: Array, height: Array) -> Float:
    """Cosine-weighted directions (n, 3) about unit normals from two numbers 0..1 (n,) (Malley's method)."""
    r, angle = np.sqrt(height), 2 * np.pi * turn
    helper = np.where(np.abs(normal[:, 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    a = np.cross(helper, normal)
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    b = np.cross(normal, a)
    x, y, z = r * np.cos(angle), r * np.sin(angle), np.sqrt(1 - height)
    return np.asarray(x[:, None] * a + y[:, None] * b + z[:, None] * normal)
