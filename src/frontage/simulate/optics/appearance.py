"""The appearance of a scene as arrays per surface, per material and per triangle, ready to be indexed."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from frontage.geometry.arrays import Array, Float, Int
from frontage.simulate.scene import Part, Scene

_FACING_COS = 0.5  # below it, a triangle is too oblique to its surface's texture plane


@dataclass(frozen=True, eq=False)
class Appearance:
    """Arrays over the s surfaces, m materials and t triangles of a scene.

    Surfaces:
    material         (s,) int64, index of the material
    part             (s,) uint8, `Part`
    origin, frame    (s, 3) m local and (s, 3, 3): texture origin, and the unit vectors u, v and w = u x v
    axes_of_surface  (s,) uint8, the most frequent `axes` of its triangles by area
    first, second    (3 s, 4): row 3 * surface + axes maps (x, y, z, 1) to the texture coordinates u and v

    Materials:
    kinds            names of the kinds of material; kind (m,) is an index into them
    rgb, joint       (m, 3) float32; size (m, 2) float32; gloss (m,) float32; seed (m,) uint32

    Triangles:
    normals          (t + 1, 3) float64, outward unit normals; the last row, for the sky, points up
    surface          (t,) int32, index of the surface
    axes             (t,) uint8, the two axes that its texture runs along: 0 = (u, v), 1 = (u, w), 2 = (w, v)
    """

    material: Int
    part: Array
    frame: Float
    origin: Float
    kinds: tuple[str, ...]
    kind: Int
    rgb: Array
    joint: Array
    size: Array
    gloss: Array
    seed: Array
    normals: Float
    surface: Array
    axes: Array
    axes_of_surface: Array
    first: Float
    second: Float

    def texture_coordinates(self, surface: Array, xyz: Float, axes: Array) -> tuple[Array, Array]:
        """Return texture coordinates u, v (n,) float32 m of points (n, 3) m local.

        surface (n,) are the indices of their surfaces, axes (n,) those of their triangles (see the class).
        """
        row = 3 * np.asarray(surface, np.int64) + axes
        u, v = (
            np.einsum("ij,ij->i", xyz, table[row, :3]) + table[row, 3] for table in (self.first, self.second)
        )
        return u.astype(np.float32), v.astype(np.float32)


_FIRST: Int = np.array([0, 0, 2])
_SECOND: Int = np.array([1, 2, 1])


@lru_cache(maxsize=4)
def appearance_of(scene: Scene) -> Appearance:
    """Return the appearance of a scene; those of the last few scenes are cached."""
    surfaces, materials = scene.surfaces, scene.materials
    frame = _frames(
        surfaces_u=np.array([s.u for s in surfaces]), surfaces_v=np.array([s.v for s in surfaces])
    )
    kinds = tuple(sorted({m.kind for m in materials}))
    normals, surface = scene.mesh.normals, scene.mesh.surface
    axes = _axes(normals, frame[surface])
    origin = np.array([s.origin for s in surfaces], np.float64)
    return Appearance(
        material=np.array([s.material for s in surfaces], np.int64),
        part=scene.parts,
        frame=frame,
        origin=origin,
        kinds=kinds,
        kind=np.array([kinds.index(m.kind) for m in materials], np.int64),
        rgb=np.array([m.rgb for m in materials], np.float32),
        joint=np.array([m.rgb_joint for m in materials], np.float32),
        size=np.array([m.size for m in materials], np.float32),
        gloss=np.array([m.gloss for m in materials], np.float32),
        seed=np.array([m.seed & 0xFFFFFFFF for m in materials], np.uint32),
        normals=np.concatenate([normals, [[0.0, 0.0, 1.0]]]),
        surface=surface,
        axes=axes,
        axes_of_surface=_most_frequent(axes, surface, areas(scene), len(surfaces)),
        first=_tables(frame, origin, _FIRST),
        second=_tables(frame, origin, _SECOND),
    )


def areas(scene: Scene) -> Float:
    """Return the area (t,) m2 of every triangle."""
    a, b, c = (scene.mesh.vertices[scene.mesh.corners[:, k]] for k in range(3))
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))


def triangles_without(scene: Scene, *parts: Part) -> Int:
    """Return the indices (k,) int64 of the triangles that belong to none of `parts`."""
    return np.flatnonzero(~np.isin(scene.parts[scene.mesh.surface], [int(p) for p in parts]))


def _tables(frame: Float, origin: Float, axis: Int) -> Float:
    along = frame[:, axis]
    shift = -np.einsum("skj,sj->sk", along, origin)
    return np.concatenate([along, shift[..., None]], axis=2).reshape(-1, 4)


def _frames(surfaces_u: Float, surfaces_v: Float) -> Float:
    """Returns unit vectors u, v and w = u x v (s, 3, 3); a v parallel to u is replaced by a normal to u."""
    u = surfaces_u / np.linalg.norm(surfaces_u, axis=1, keepdims=True)
    w = np.cross(u, surfaces_v)
    lost = np.linalg.norm(w, axis=1) < 1e-6
    w[lost] = np.cross(u[lost], np.roll(u[lost], 1, axis=1) * [1.0, -1.0, 1.0])
    w /= np.maximum(np.linalg.norm(w, axis=1, keepdims=True), 1e-12)
    return np.stack([u, np.cross(w, u), w], axis=1)


def _axes(normals: Float, frame: Float) -> Array:
    """Returns the texture axes of each triangle (t,): (u, v) unless it is too oblique to them."""
    facing = np.abs(np.einsum("tij,tj->ti", frame, normals))  # along u, v, w
    other = np.where(facing[:, 1] >= facing[:, 0], 1, 2)
    return np.where(facing[:, 2] >= _FACING_COS, 0, other).astype(np.uint8)


def _most_frequent(axes: Array, surface: Array, area: Float, count: int) -> Array:
    votes = np.zeros((count, 3))
    np.add.at(votes, (surface, axes), area)
    return np.asarray(np.argmax(votes, axis=1), np.uint8)
