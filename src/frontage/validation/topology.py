"""The topology of a shell: edges by their number of faces, connected components, and fans at vertices."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from frontage.geometry.arrays import Bool, Int
from frontage.validation.geometry.rows import distinct_rows, rows_among
from frontage.validation.geometry.triangulate import Triangles


@dataclass(frozen=True, eq=False)
class Topology:
    """The edges of a shell.

    triangles  of its faces, with the ring edges (e, 2)
    faces      number f of its faces
    ends       (u, 2) vertex ids of the edges, the smaller one first
    uses       (u,) number of ring edges that lie on each edge
    edge       (e,) edge that each ring edge lies on
    """

    triangles: Triangles
    faces: int
    ends: Int
    uses: Int
    edge: Int

    @classmethod
    def of(cls, triangles: Triangles, faces: int) -> "Topology":
        """Returns the topology of a shell of `faces` faces from their ring edges."""
        ends, edge, uses = distinct_rows(np.sort(triangles.edges, axis=1))
        return cls(triangles, faces, ends, uses, edge)

    @cached_property
    def pairs(self) -> Int:
        """Pairs (m, 2) of ring edges that lie on an edge of exactly two faces."""
        return _pairs_of_equals(self.edge, self.uses)

    @cached_property
    def edge_component(self) -> Int:
        """Component (f,) of every face, where faces are connected across edges of exactly two faces."""
        face = self.triangles.edge_face[self.pairs]
        labels = connected_components(_graph(face[:, 0], face[:, 1], self.faces), directed=False)[1]
        return np.asarray(labels, np.int64)

    @cached_property
    def largest_component(self) -> int:
        """The edge component with most faces."""
        return int(np.argmax(np.bincount(self.edge_component)))

    @cached_property
    def vertex_component(self) -> Int:
        """Component (f,) of every face, where faces are connected by common vertices."""
        face, vertex = self.triangles.edge_face, self.triangles.edges[:, 0]
        size = self.faces + int(self.triangles.edges.max(initial=-1)) + 1
        labels = connected_components(_graph(face, self.faces + vertex, size), directed=False)[1]
        return np.asarray(labels[: self.faces], np.int64)

    @cached_property
    def same_direction(self) -> Bool:
        """Which of `pairs` (m,) run in the same direction, so that one of the two faces is reversed."""
        first, second = self.triangles.edges[self.pairs[:, 0]], self.triangles.edges[self.pairs[:, 1]]
        return np.asarray((first == second).all(1))

    def orientations(self) -> tuple[Int, Bool]:
        """Colours faces (f,) with 0 or 1, alike if they agree in orientation with their neighbours.

        Also returns the pairs (m,) that contradict the colouring; they exist on a non-orientable surface
        only.
        """
        a, b = self.triangles.edge_face[self.pairs].T
        graph = _graph(a, b, self.faces)
        reversed_pairs = dict(
            zip(zip(a.tolist(), b.tolist(), strict=True), self.same_direction.tolist(), strict=True)
        )
        colour = np.full(self.faces, -1)
        for root in np.unique(self.edge_component, return_index=True)[1]:
            order, before = breadth_first_order(graph, root, directed=False)
            colour[root] = 0
            for face in order[1:]:
                came = int(before[face])
                flip = reversed_pairs.get((came, int(face)), reversed_pairs.get((int(face), came), False))
                colour[face] = colour[came] ^ int(flip)
        return colour, np.asarray((colour[a] != colour[b]) != self.same_direction)

    def non_manifold_vertices(self, open_fans: bool) -> Int:
        """Returns the vertices whose faces form more than one fan.

        A vertex where all fans are open counts only with `open_fans`, because in a closed shell the fault is
        the hole there. Vertices on edges of more than two faces are left out.
        """
        corner, vertex, loose = self._fans()
        number = int(corner.max(initial=-1)) + 1
        fan_vertex, fan_open = np.zeros(number, np.int64), np.zeros(number, np.bool_)
        fan_vertex[corner] = vertex
        fan_open[corner[loose]] = True
        size = int(vertex.max(initial=-1)) + 1
        fans = np.bincount(fan_vertex, minlength=size)
        closed = np.bincount(fan_vertex[~fan_open], minlength=size)
        crowded = (fans > 1) & (open_fans | (closed > 0))
        crowded[self.ends[self.uses > 2]] = False
        return np.nonzero(crowded)[0]

    def _fans(self) -> tuple[Int, Int, Bool]:
        """Returns for all corners of triangles: fan, vertex, and whether a free edge starts or ends there."""
        ids = self.triangles.ids
        half_edges = np.stack([ids, np.roll(ids, -1, axis=1)], axis=2).reshape(-1, 2)
        here = np.arange(ids.size).reshape(-1, 3)
        corner = np.stack([here, np.roll(here, -1, axis=1)], axis=2).reshape(-1, 2)
        face = np.repeat(self.triangles.face, 3)
        ring_edges = np.column_stack([self.triangles.edge_face, self.triangles.edges])
        inner = ~rows_among(np.column_stack([face, half_edges]), ring_edges)
        key = np.column_stack([np.where(inner, face + 1, 0), np.sort(half_edges, axis=1)])
        _, label, count = distinct_rows(key)
        pairs = _pairs_of_equals(label, count)
        low = half_edges[:, 0] < half_edges[:, 1]
        at_low = np.where(low, corner[:, 0], corner[:, 1])
        at_high = np.where(low, corner[:, 1], corner[:, 0])
        a = np.concatenate([at_low[pairs[:, 0]], at_high[pairs[:, 0]]])
        b = np.concatenate([at_low[pairs[:, 1]], at_high[pairs[:, 1]]])
        fan = connected_components(_graph(a, b, ids.size), directed=False)[1]
        loose = np.zeros(ids.size, np.bool_)
        loose[corner[count[label] == 1].ravel()] = True
        return np.asarray(fan, np.int64), ids.ravel(), loose


def _pairs_of_equals(label: Int, count: Int) -> Int:
    """Returns the pairs (m, 2) of indices whose label occurs exactly twice; `count` per label."""
    two = np.nonzero(count[label] == 2)[0]
    return two[np.argsort(label[two], kind="stable")].reshape(-1, 2)


def _graph(a: Int, b: Int, size: int) -> Any:
    return coo_array((np.ones(len(a), np.int32), (a, b)), shape=(size, size)).tocsr()
