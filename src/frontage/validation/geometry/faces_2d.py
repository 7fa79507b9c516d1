"""Faces as shapely polygons in their planes, with edges split where corners of other rings touch them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.validation.geometry.mesh import Mesh


@dataclass(frozen=True, eq=False)
class NodedRings:
    """The rings of a mesh with additional corners in their edges.

    corners  (n,) corner indices of all rings one after the other
    rings    (r + 1,) offsets of the rings
    """

    corners: Int
    rings: Int

    @classmethod
    def of(cls, mesh: Mesh) -> "NodedRings":
        """Returns the rings of a mesh as they are."""
        return cls(np.arange(len(mesh.corners)), mesh.rings)

    def closed(self, chosen: Bool) -> tuple[Int, Int]:
        """Returns the corners of the chosen rings (r,), the first repeated at the end, and their offsets."""
        start, length = self.rings[:-1][chosen], np.diff(self.rings)[chosen]
        offsets = np.concatenate([[0], np.cumsum(length + 1)])
        step = np.arange(offsets[-1]) - np.repeat(offsets[:-1], length + 1)
        return self.corners[np.repeat(start, length + 1) + step % np.repeat(length, length + 1)], offsets


def split_at_contacts(mesh: Mesh, xy: Float, corner: Int, edge: Int) -> NodedRings:
    """Inserts each `corner` (n,) into its `edge` (n,), as found by `corners_on_edges`.

    Two rings that touch share a corner afterwards, so that rounding cannot make them cross.
    """
    a, b = xy[edge], xy[mesh.after[edge]]
    t = np.einsum("ni,ni->n", xy[corner] - a, b - a)
    order = np.lexsort((t, edge))
    corner, edge = corner[order], edge[order]
    corners = np.insert(np.arange(len(mesh.corners)), edge + 1, corner)
    added = np.bincount(mesh.ring_of_corner[edge], minlength=len(mesh.rings) - 1)
    return NodedRings(corners, mesh.rings + np.concatenate([[0], np.cumsum(added)]))


def ring_polygons(mesh: Mesh, xy: Float, chosen: Bool) -> Array:
    """Returns every chosen ring (r,) as a polygon of its own."""
    corners, offsets = NodedRings.of(mesh).closed(chosen)
    return _polygons(xy[corners], offsets, np.arange(len(offsets)))


def face_polygons(mesh: Mesh, xy: Float, chosen: Bool, noded: NodedRings) -> Array:
    """Returns every chosen face (f,) as a polygon with its holes."""
    corners, offsets = noded.closed(chosen[mesh.face_of_ring])
    count = np.diff(mesh.faces)[chosen]
    return _polygons(xy[corners], offsets, np.concatenate([[0], np.cumsum(count)]))


def _polygons(xy: Float, rings: Int, faces: Int) -> Array:
    if len(faces) < 2:
        return np.zeros(0, object)
    kind: Any = shapely.GeometryType.POLYGON
    return np.asarray(shapely.from_ragged_array(kind, np.ascontiguousarray(xy), (rings, faces)))
