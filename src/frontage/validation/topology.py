"""How the faces of a shell hang together: edges by their number of faces, components, fans at vertices."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from frontage.geometry.arrays import Bool, Int
from frontage.validation.geometry.rows import among, distinct
from frontage.validation.polygons import Triangles


@dataclass(frozen=True, eq=False)
class Topology:
    """Edges of a shell: `ends` (u, 2) vertex ids (small, large), `uses` (u,) how many ring edges lie there.

    `edge` (e,): which of them every ring edge of `triangles` is.
    """

    triangles: Triangles
    faces: int
    ends: Int
    uses: Int
    edge: Int

    @classmethod
    def of(cls, triangles: Triangles, faces: int) -> "Topology":
        """From the ring edges of a shell of so many faces."""
        ends, edge, uses = distinct(np.sort(triangles.edges, axis=1))
        return cls(triangles, faces, ends, uses, edge)

    @cached_property
    def pairs(self) -> Int:
        """Ring edges (m, 2) that are alone together on one edge."""
        two = np.nonzero(self.uses[self.edge] == 2)[0]
        return two[np.argsort(self.edge[two], kind="stable")].reshape(-1, 2)

    @cached_property
    def component(self) -> Int:
        """Which part every face (f,) belongs to, passing only edges of exactly two faces."""
        face = self.triangles.edge_face[self.pairs]
        labels = connected_components(_graph(face[:, 0], face[:, 1], self.faces), directed=False)[1]
        return np.asarray(labels, np.int64)

    @cached_property
    def main(self) -> int:
        """The part with most faces."""
        return int(np.argmax(np.bincount(self.component)))

    @cached_property
    def group(self) -> Int:
        """Which part every face (f,) belongs to when a common vertex is enough."""
        face, vertex = self.triangles.edge_face, self.triangles.edges[:, 0]
        size = self.faces + int(self.triangles.edges.max(initial=-1)) + 1
        labels = connected_components(_graph(face, self.faces + vertex, size), directed=False)[1]
        return np.asarray(labels[: self.faces], np.int64)

    @cached_property
    def same_way(self) -> Bool:
        """Which of `pairs` run in the same direction, so that one of the two faces is turned."""
        first, second = self.triangles.edges[self.pairs[:, 0]], self.triangles.edges[self.pairs[:, 1]]
        return np.asarray((first == second).all(1))

    def colours(self) -> tuple[Int, Bool]:
        """Faces (f,) as 0 or 1, alike when they agree in orientation, and the pairs that contradict it."""
        a, b = self.triangles.edge_face[self.pairs].T
        graph = _graph(a, b, self.faces)
        turned = dict(zip(zip(a.tolist(), b.tolist(), strict=True), self.same_way.tolist(), strict=True))
        colour = np.full(self.faces, -1)
        for root in np.unique(self.component, return_index=True)[1]:
            order, before = breadth_first_order(graph, root, directed=False)
            colour[root] = 0
            for face in order[1:]:
                came = int(before[face])
                flip = turned.get((came, int(face)), turned.get((int(face), came), False))
                colour[face] = colour[came] ^ int(flip)
        return colour, np.asarray((colour[a] != colour[b]) != self.same_way)

    def crowded_vertices(self, open_fans: bool) -> Int:
        """Vertices whose faces form more than one fan.

        A vertex where all fans are open is only counted with `open_fans`: in a closed shell it is the holes
        that are wrong there. Vertices on edges of more than two faces are left out.
        """
        corner, vertex, loose = self._fans()
        number = int(corner.max(initial=-1)) + 1
        fan_vertex, fan_open = np.zeros(number, np.int64), np.zeros(number, np.bool_)
        fan_vertex[corner] = vertex
        fan_open[corner[loose]] = True
        size = int(vertex.max(initial=-1)) + 1
        fans = np.bincount(fan_vertex, minlength=size)
        shut = np.bincount(fan_vertex[~fan_open], minlength=size)
        crowded = (fans > 1) & (open_fans | (shut > 0))
        crowded[self.ends[self.uses > 2]] = False
        return np.nonzero(crowded)[0]

    def _fans(self) -> tuple[Int, Int, Bool]:
        """For the corners of all triangles: fan, vertex, whether a free edge starts or ends there."""
        ids = self.triangles.ids
        half = np.stack([ids, np.roll(ids, -1, axis=1)], axis=2).reshape(-1, 2)
        here = np.arange(ids.size).reshape(-1, 3)
        corner = np.stack([here, np.roll(here, -1, axis=1)], axis=2).reshape(-1, 2)
        face = np.repeat(self.triangles.face, 3)
        inner = ~among(
            np.column_stack([face, half]), np.column_stack([self.triangles.edge_face, self.triangles.edges])
        )
        key = np.column_stack([np.where(inner, face + 1, 0), np.sort(half, axis=1)])
        _, label, count = distinct(key)
        two = np.nonzero(count[label] == 2)[0]
        pairs = two[np.argsort(label[two], kind="stable")].reshape(-1, 2)
        low = half[:, 0] < half[:, 1]
        at_low = np.where(low, corner[:, 0], corner[:, 1])
        at_high = np.where(low, corner[:, 1], corner[:, 0])
        a = np.concatenate([at_low[pairs[:, 0]], at_high[pairs[:, 0]]])
        b = np.concatenate([at_low[pairs[:, 1]], at_high[pairs[:, 1]]])
        fan = connected_components(_graph(a, b, ids.size), directed=False)[1]
        loose = np.zeros(ids.size, np.bool_)
        loose[corner[count[label] == 1].ravel()] = True
        return np.asarray(fan, np.int64), ids.ravel(), loose


def _graph(a: Int, b: Int, size: int) -> Any:
    return coo_array((np.ones(len(a), np.int32), (a, b)), shape=(size, size)).tocsr()
