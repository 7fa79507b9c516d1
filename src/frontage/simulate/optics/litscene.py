"""Casts view rays into a lit scene: what they meet directly, behind a pane, and mirrored in it."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.simulate.optics import noise
from frontage.simulate.optics.appearance import Appearance, appearance_of
from frontage.simulate.optics.light import Light
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import Part, Scene

_OFFSET_M = 1e-3  # distance from a surface at which rays that leave it start
_SAME_PLANE_M = 0.004  # triangles of one surface whose planes are this close are one face
_FARTHEST_M = 1e4
_TILT_RAD = 0.0015  # standard deviation of a pane's tilt out of the plane of its frame
_WAVINESS_RAD = 0.0016  # standard deviation of the slope of a pane's waves (roller waves, sealed air)


@dataclass(frozen=True, eq=False)
class ViewHits:
    """What n view rays meet; k of them cross a pane.

    directions         (n, 3) unit vectors, local
    solid              (n,) int64, triangle that the ray ends on, behind any pane; -1 = sky
    xyz, distance      (n, 3) m local and (n,) m along the ray: where it ends
    lit                (n,) whether the sun shines there
    paned              (k,) int64, which rays cross a pane
    pane, pane_xyz     (k,) triangle of the first pane, and (k, 3) m local where the ray meets it
    cosine             (k,) of the angle of incidence on the pane
    mirror             (k,) int64, triangle that the pane mirrors; -1 = sky
    mirror_xyz, mirror_direction, mirror_lit   where that is, along which direction it is seen, whether lit
    key                (n,) uint32, equal for rays that see the same faces in the same light
    """

    directions: Float
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
    mirror_direction: Float
    mirror_lit: Bool
    key: Array


class LitScene:
    """A scene with its light and the search trees for casting rays.

    every, solid   tracers over all triangles, and over those that are not panes
    is_pane        (t,) which triangles are panes
    faces          (t + 1,) uint32, number of the face of every triangle; 0 for the sky
    """

    def __init__(self, scene: Scene, light: Light, keep: Bool | None = None) -> None:
        """Build the search trees over all triangles, or over those where `keep` (t,) is True."""
        self.scene, self.light, self.appearance = scene, light, appearance_of(scene)
        kept = np.ones(len(scene.mesh.corners), np.bool_) if keep is None else keep
        self.is_pane = self.appearance.part[self.appearance.surface] == Part.PANE
        self.every = Tracer(scene.mesh, kept)
        self.solid = Tracer(scene.mesh, kept & ~self.is_pane)
        self.faces = _faces(scene, self.appearance)
        apex = scene.mesh.vertices[scene.mesh.corners[:, 0]]
        self._offset = np.append(np.einsum("ij,ij->i", apex, self.appearance.normals[:-1]), 0.0)

    def cast(self, origin: Float, directions: Float) -> ViewHits:
        """Cast rays from `origin` (3,) m local along unit vectors `directions` (n, 3)."""
        hits = self.every.first_hit(origin, directions)
        solid, distance = hits.triangle.copy(), hits.distance.copy()
        paned = np.flatnonzero(self.is_pane[solid] & (solid >= 0))
        pane, pane_distance = solid[paned], distance[paned]
        behind = self.solid.first_hit(origin, directions[paned])
        solid[paned], distance[paned] = behind.triangle, behind.distance
        xyz = _along(origin, directions, distance)
        pane_xyz = _along(origin, directions[paned], pane_distance)
        cosine, mirror_direction = self._mirrored(pane, pane_xyz, directions[paned])
        mirror = self.every.first_hit(pane_xyz, mirror_direction, skip=_OFFSET_M)
        mirror_xyz = _along(pane_xyz, mirror_direction, mirror.distance)
        lit = self.sunny(solid, xyz, directions)
        mirror_lit = self.sunny(mirror.triangle, mirror_xyz, mirror_direction)
        key = self._key(solid, lit)
        key[paned] = noise.scramble(key[paned], 1) ^ self._key(mirror.triangle, mirror_lit)
        key[paned] ^= noise.scramble(self.faces[pane], 5)
        return ViewHits(
            directions, solid, xyz, distance, lit, paned, pane, pane_xyz, cosine,
            mirror.triangle, mirror_xyz, mirror_direction, mirror_lit, key,
        )  # fmt: skip

    def follow(self, view: ViewHits, rows: Int, origin: Float, directions: Float) -> ViewHits:
        """Return what rays (n, 3) from `origin` meet if they see the same as the rays `rows` (n,) of `view`.

        No rays are cast: they are intersected with the planes of the same faces.
        """
        solid = view.solid[rows]
        distance = self._reach(solid, origin, directions)
        xyz = _along(origin, directions, distance)
        place = np.full(len(view.solid), -1)
        place[view.paned] = np.arange(len(view.paned))
        paned = np.flatnonzero(place[rows] >= 0)
        of = place[rows[paned]]
        pane, mirror = view.pane[of], view.mirror[of]
        pane_xyz = _along(origin, directions[paned], self._reach(pane, origin, directions[paned]))
        cosine, mirror_direction = self._mirrored(pane, pane_xyz, directions[paned])
        mirror_xyz = _along(pane_xyz, mirror_direction, self._reach(mirror, pane_xyz, mirror_direction))
        return ViewHits(
            directions, solid, xyz, distance, view.lit[rows], paned, pane, pane_xyz, cosine,
            mirror, mirror_xyz, mirror_direction, view.mirror_lit[of], view.key[rows],
        )  # fmt: skip

    def _reach(self, triangle: Int, origin: Float, directions: Float) -> Float:
        """Returns the distance (n,) m along rays to the planes of triangles (n,), inf for the sky."""
        normal = self.appearance.normals[triangle]
        slope = np.einsum("ij,ij->i", normal, directions)
        start = np.einsum("ij,ij->i", normal, np.broadcast_to(origin, directions.shape))
        height = self._offset[triangle] - start
        flat = np.abs(slope) < 1e-9
        reach = np.clip(height / np.where(flat, 1.0, slope), 0.0, _FARTHEST_M)
        return np.where(triangle >= 0, reach, np.inf)

    def _mirrored(self, pane: Int, xyz: Float, directions: Float) -> tuple[Float, Float]:
        """Returns the cosine (k,) of incidence on panes, and the mirrored directions (k, 3)."""
        normal = self._pane_normals(pane, xyz, directions)
        cosine = -np.einsum("ij,ij->i", normal, directions)
        return cosine, directions + 2 * cosine[:, None] * normal

    def normals(self, triangle: Int, directions: Float) -> Float:
        """Return unit normals (n, 3) of triangles (n,) on the side that rays (n, 3) see; vertical for sky."""
        n = self.appearance.normals[triangle]
        n *= np.where(np.einsum("ij,ij->i", n, directions) > 0, -1.0, 1.0)[:, None]
        return n

    def sunny(self, triangle: Int, xyz: Float, directions: Float) -> Bool:
        """Return whether the sun shines on the seen side of triangles (n,) at xyz (n, 3).

        Panes let sunlight pass.
        """
        lit = np.zeros(len(triangle), np.bool_)
        if self.light.overcast >= 1:
            return lit
        normal = self.normals(triangle, directions)
        # leaves let light through
        thin = self.appearance.part[self.appearance.surface[triangle]] == Part.TREE
        facing = np.flatnonzero((triangle >= 0) & ((normal @ self.light.to_sun > 1e-3) | thin))
        start = xyz[facing] + _OFFSET_M * normal[facing]
        direction = np.broadcast_to(self.light.to_sun, start.shape)
        lit[facing] = ~self.solid.blocked(start, direction, np.inf, skip=_OFFSET_M)
        return lit

    def openness(self, triangle: Int, xyz: Float, directions: Float, count: int) -> Array:
        """Return the share (n,) float32 of the hemisphere over seen points that is free (sky view factor).

        It is sampled by `count` cosine-weighted rays, whose directions are a function of the position.
        """
        normal = self.normals(triangle, directions)
        start = xyz + _OFFSET_M * normal
        free = np.zeros(len(triangle), np.float32)
        i, j, k = (np.floor(xyz[:, a] * 4096).astype(np.int64).astype(np.int32) for a in range(3))
        seed = (k.astype(np.uint32) * np.uint32(0x9E3779B1)).astype(np.uint32)
        turn, height = noise.cell(i, j, seed, 1), noise.cell(i, j, seed, 2)
        for s in range(count):
            direction = _hemisphere(normal, (turn + s * 0.6180340) % 1.0, (height + s) / count % 1.0)
            free += ~self.solid.blocked(start, direction, np.inf, skip=_OFFSET_M)
        return np.asarray(free / np.float32(count))

    def _pane_normals(self, pane: Int, xyz: Float, directions: Float) -> Float:
        """Returns the normals (k, 3) of panes at points (k, 3): every pane is slightly tilted and wavy."""
        normal = self.normals(pane, directions)
        surface = self.appearance.surface[pane]
        u, v = self.appearance.texture_coordinates(surface, xyz, np.zeros(len(pane), np.uint8))
        seed, blur = surface.astype(np.uint32), np.zeros(len(pane), np.float32)
        frame = self.appearance.frame[surface]
        for k in (0, 1):
            tilt = noise.cell(surface, surface * 0 + k, seed, 3) - 0.5
            waves = noise.wave(u, v, 1.3, seed=seed, salt=4 + k, blur=blur)
            slope = _TILT_RAD * 3.5 * tilt + _WAVINESS_RAD * waves
            normal = normal + slope[:, None] * frame[:, k]
        return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))

    def _key(self, triangle: Int, lit: Bool) -> Array:
        return np.asarray(
            noise.scramble(self.faces[triangle], 2) ^ (lit.astype(np.uint32) * np.uint32(0x68E31DA4))
        )


def _along(origin: Float, directions: Float, distance: Float) -> Float:
    """Returns points (n, 3) at distances (n,) m along rays; the origin where the distance is infinite."""
    return np.asarray(origin + directions * np.where(np.isfinite(distance), distance, 0.0)[:, None])


def _faces(scene: Scene, appearance: Appearance) -> Array:
    """Numbers the faces of triangles (t + 1,) uint32 from 1, the last 0.

    Triangles of one surface that lie in one plane belong to the same face.
    """
    normals = appearance.normals[:-1]
    n = np.round(normals * 64).astype(np.int64)
    apex = scene.mesh.vertices[scene.mesh.corners[:, 0]]
    offset = np.round(np.einsum("ij,ij->i", apex, normals) / _SAME_PLANE_M).astype(np.int64)
    rows = np.column_stack([appearance.surface.astype(np.int64), n, offset])
    _, number = np.unique(rows, axis=0, return_inverse=True)
    return np.append(number.reshape(-1) + 1, 0).astype(np.uint32)


def _hemisphere(normal: Float, turn: Array, height: Array) -> Float:
    """Maps two numbers 0..1 (n,) to cosine-weighted directions (n, 3) about normals (Malley's method)."""
    r, angle = np.sqrt(height), 2 * np.pi * turn
    helper = np.where(np.abs(normal[:, 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    a = np.cross(helper, normal)
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    b = np.cross(normal, a)
    x, y, z = r * np.cos(angle), r * np.sin(angle), np.sqrt(1 - height)
    return np.asarray(x[:, None] * a + y[:, None] * b + z[:, None] * normal)
