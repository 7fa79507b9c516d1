"""Casts rays on a mesh: Embree finds the triangle in float32, its plane gives the distance in float64."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from frontage.errors import MissingExtra
from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.simulate.scene import SceneMesh

_CHUNK = 400_000  # rays per call into Embree: bounds the memory of its answers to some 20 MB
_GRAZING_COS = 1e-4  # below it, dividing by the cosine would lose more precision than float32 does


@dataclass(frozen=True, eq=False)
class Hits:
    """The first hits of n rays.

    triangle   (n,) index into the mesh, -1 = none
    distance   (n,) in lengths of the ray's direction, inf = none
    cosine     (n,) of the angle of incidence, 0..1 from either side; 0 = no hit
    """

    triangle: Int
    distance: Float
    cosine: Float

    @property
    def found(self) -> Bool:
        """Which rays (n,) hit something."""
        return self.triangle >= 0

    def take(self, rows: Array) -> "Hits":
        """Return the hits of the rays at `rows`."""
        return Hits(self.triangle[rows], self.distance[rows], self.cosine[rows])


class Tracer:
    """Casts rays on one mesh. Directions need not be unit vectors; if they are, distances are in metres.

    Embree is much faster on rays that lie close together, so pass them in scan or pixel order. Use one
    instance per process, as it cannot be pickled and its calls hold the interpreter lock.
    """

    def __init__(self, mesh: SceneMesh, keep: Bool | None = None) -> None:
        """Build the search tree over `mesh`, or over those of its triangles where `keep` (t,) is True.

        Hits always contain indices into the whole mesh.

        Raises MissingExtra if embreex is not installed, ValueError for a `keep` of the wrong length.
        """
        corners = mesh.vertices[mesh.corners]
        chosen = np.ones(len(corners), np.bool_) if keep is None else np.asarray(keep, np.bool_)
        if chosen.shape != (len(corners),):
            raise ValueError(f"keep: shape {chosen.shape}, expected ({len(corners)},)")
        self._rows = np.flatnonzero(chosen)
        self._apex = corners[self._rows, 0]
        self._normals = mesh.normals[self._rows]
        # float32 is precise enough only near zero, so rays are cast relative to the middle of the mesh
        self._centre = (
            (corners.min((0, 1)) + corners.max((0, 1))) / 2 if len(self._rows) else np.zeros(3, np.float64)
        )
        self._scene = _embree_scene(corners[self._rows] - self._centre) if len(self._rows) else None

    def first_hit(self, origins: Float, directions: Float, skip: float = 0.0) -> Hits:
        """Return the first triangle that each ray meets beyond `skip` times its direction.

        origins (n, 3) or (3,) are in m, local; directions are (n, 3). A `skip` > 0 keeps a ray that starts on
        a surface from hitting that surface again.
        """
        directions = np.asarray(directions, np.float64)
        origins = np.broadcast_to(np.asarray(origins, np.float64), directions.shape)
        n = len(directions)
        triangle, distance, cosine = np.full(n, -1, np.int64), np.full(n, np.inf), np.zeros(n)
        for start in range(0, n if self._scene is not None else 0, _CHUNK):
            part = slice(start, start + _CHUNK)
            o, d = origins[part], directions[part]
            answer = self._run(o + skip * d, d, output=True)
            hit = np.flatnonzero(answer["primID"] >= 0)
            row = answer["primID"][hit].astype(np.int64)
            triangle[start + hit] = self._rows[row]
            coarse = answer["tfar"][hit].astype(np.float64) + skip
            distance[start + hit], cosine[start + hit] = self._refined(o[hit], d[hit], row, coarse)
        return Hits(triangle, distance, cosine)

    def blocked(self, origins: Float, directions: Float, reach: Float | float, skip: float = 1e-4) -> Bool:
        """Return which rays (n,) meet anything between `skip` and `reach` times their direction.

        This is faster than `first_hit`.
        """
        directions = np.asarray(directions, np.float64)
        origins = np.broadcast_to(np.asarray(origins, np.float64), directions.shape)
        limit = np.broadcast_to(np.asarray(reach, np.float64), len(directions)) - skip
        answer = np.zeros(len(directions), np.bool_)
        for start in range(0, len(directions) if self._scene is not None else 0, _CHUNK):
            part = slice(start, start + _CHUNK)
            o, d, far = origins[part], directions[part], np.maximum(limit[part], 0.0)
            # an unbounded ray has an infinite reach, which float32 can represent
            hit = self._run(o + skip * d, d, query="OCCLUDED", dists=far.astype(np.float32))
            answer[part] = np.asarray(hit) >= 0
        return answer

    def _run(self, origins: Float, directions: Float, **options: Any) -> Any:
        near = (origins - self._centre).astype(np.float32)
        assert self._scene is not None
        return self._scene.run(near, np.ascontiguousarray(directions, np.float32), **options)

    def _refined(self, origins: Float, directions: Float, row: Int, coarse: Float) -> tuple[Float, Float]:
        """Returns distance to the triangles' planes (`coarse` for grazing rays) and cosine of incidence."""
        normal = self._normals[row]
        slope = np.einsum("ij,ij->i", directions, normal)
        height = np.einsum("ij,ij->i", self._apex[row] - origins, normal)
        cosine = np.abs(slope) / np.sqrt(np.einsum("ij,ij->i", directions, directions))
        flat = cosine < _GRAZING_COS
        return np.where(flat, coarse, height / np.where(flat, 1.0, slope)), np.minimum(cosine, 1.0)


def _embree_scene(corners: Array) -> Any:
    """Builds Embree's search tree over triangles (t, 3, 3)."""
    try:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene
    except ImportError as error:
        raise MissingExtra("simulating a scan or a photo", "simulate") from error
    scene = EmbreeScene(robust=True)  # no ray slips between triangles that share an edge
    TriangleMesh(scene, np.ascontiguousarray(corners, np.float32))
    return scene
