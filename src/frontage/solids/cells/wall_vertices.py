"""The vertices of a partitioned wall: nodes at heights, and the new paths along the wall's border."""

import itertools

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import Solid
from frontage.solids.brep import GRID_PER_M, Edge, newell_normal, ring_edges, rings_of
from frontage.solids.cells.contract import Node
from frontage.solids.cells.partition import Partition
from frontage.solids.walls import HostWall

Spot = tuple[Node, int]
"""A node at a height (0.1 mm)."""

_ON_EDGE = 1.0  # 0.1 mm: how far rounding moves a node off the edge that it lies on

_Plane = tuple[Float, Float]  # a point (3,) m and the normal (3,), in the wall frame


class WallVertices:
    """Numbers the vertices of a wall's cells; vertices of the host are used where there are any.

    new    grid coordinates of the vertices that the host lacks; their ids follow those of the host
    paths  directed border edge of the host's wall -> vertex ids along it after the cut, ends included
    """

    def __init__(self, solid: Solid, wall: HostWall, partition: Partition) -> None:
        self.solid, self.wall, self.partition = solid, wall, partition
        self.new: list[tuple[int, int, int]] = []
        self._known: dict[Spot, int] = {}
        self._heights = partition.heights()
        self._local = solid.vertices / GRID_PER_M
        self._face_planes = {k: self._plane(k) for k in wall.faces}
        self._ground_planes = {e: self._ground_plane(f) for e, f in wall.ground.items()}
        self._face_at = {n: c.face for c in partition.cells for ring in c.rings for n in ring}
        self._nodes_on: dict[Edge, list[Node]] = {}
        self._edge_of: dict[Node, Edge] = {}
        place = {i: n for n, i in wall.nodes.items()}
        for edge in self._host_edges():
            self._nodes_on[edge] = self._nodes_between(place[edge[0]], place[edge[1]])
            self._edge_of |= dict.fromkeys(self._nodes_on[edge][1:-1], edge)
        self.paths = {e: self._path(e) for e in wall.border}

    def vertex(self, spot: Spot) -> int:
        """Returns the vertex id of a node at a height."""
        node, height = spot
        if height == 0 and node in self.wall.nodes:
            return self.wall.nodes[node]
        if spot not in self._known:
            local = self.wall.local_from_wall.apply(self._position(node, height)[None])[0]
            x, y, z = np.rint(local * GRID_PER_M).astype(np.int64).tolist()
            self._known[spot] = len(self.solid.vertices) + len(self.new)
            self.new.append((x, y, z))
        return self._known[spot]

    def rise(self, node: Node, start: int, end: int) -> list[Spot]:
        """Returns a node from one height (0.1 mm) to another, through all heights of its cells in between."""
        low, high = min(start, end), max(start, end)
        between = [(node, h) for h in sorted({*self._heights[node], low, high}) if low <= h <= high]
        return between if start < end else between[::-1]

    def _host_edges(self) -> list[Edge]:
        """Returns the edges of the wall's faces, inner ones once, those of the border as it runs."""
        edges = {
            e if e in self.wall.border or e[0] < e[1] else e[::-1]
            for k in self.wall.faces
            for ring in rings_of(self.solid.faces[k])
            for e in ring_edges(ring)
        }
        return sorted(edges)

    def _nodes_between(self, a: Node, b: Node) -> list[Node]:
        """Returns the nodes of the partition on a host edge, in order, its ends included."""
        p, q = np.array(a, np.float64), np.array(b, np.float64)
        nodes = list(self._heights)
        xz = np.array(nodes, np.float64)
        t = (xz - p) @ (q - p) / float((q - p) @ (q - p))
        off = np.linalg.norm(xz - p - t[:, None] * (q - p), axis=1)
        on = np.nonzero((off <= _ON_EDGE) & (t > 0) & (t < 1))[0]
        inner = [nodes[k] for k in on[np.argsort(t[on], kind="stable")] if nodes[k] not in (a, b)]
        return [a, *inner, b]

    def _plane(self, face: int) -> _Plane:
        """Returns the plane of a host face in the wall frame."""
        ring = self._local[list(self.solid.faces[face].ring)]
        in_wall = self.wall.local_from_wall.inverse.apply(ring)
        return in_wall.mean(0), newell_normal(in_wall)

    def _ground_plane(self, face: int) -> _Plane:
        """Returns the plane of a ground face in the wall frame, its normal from local coordinates."""
        ring = self._local[list(self.solid.faces[face].ring)]
        wall_from_local = self.wall.local_from_wall.inverse
        return wall_from_local.apply(ring).mean(0), self.wall.local_from_wall.R.T @ newell_normal(ring)

    def _path(self, edge: Edge) -> list[int]:
        """Returns the vertices along a border edge, up and down over the heights of its cells."""
        nodes = self._nodes_on[edge]
        spots: list[Spot] = [(nodes[0], 0)]
        for a, b in itertools.pairwise(nodes):
            height = self.partition.cells[self.partition.left[a, b]].height
            spots += [*self.rise(a, spots[-1][1], height)[1:], (b, height)]
        spots += self.rise(nodes[-1], spots[-1][1], 0)[1:]
        return [self.vertex(s) for s in spots]

    def _position(self, node: Node, height: int) -> Float:
        """Returns the position (3,) m of a node at a height, in the wall frame.

        Nodes on host edges follow these, nodes at height 0 lie in the plane of their host face, and nodes at
        the foot of the wall in that of the ground.
        """
        flat = np.array([node[0], height, node[1]]) / GRID_PER_M
        edge = self._edge_of.get(node)
        if edge is None and node in self.wall.nodes:
            ids = [e for e in self._ground_planes if self.wall.nodes[node] in e]
            edge = ids[0] if ids else None
        elif edge is not None:
            ends = self.wall.local_from_wall.inverse.apply(self._local[list(edge)])
            way = ends[1] - ends[0]
            t = float((flat - ends[0]) @ way / (way @ way))
            flat = ends[0] + t * way + [0.0, height / GRID_PER_M, 0.0]
        elif height == 0:
            point, n = self._face_planes[self._face_at[node]]
            flat[1] = point[1] - ((flat - point) * n)[[0, 2]].sum() / n[1]
        if height and edge in self._ground_planes:
            point, n = self._ground_planes[edge]
            flat[2] -= float((flat - point) @ n / n[2])
        return flat
