"""Cells become faces: the boundary between solid and void over a partitioned wall, put into its host.

A wall with reliefs is a field of heights over its cells. The surface is every cell at its height, and a side
face over every border between two heights; along a border node the heights of all cells around it are
vertices of all faces that pass there, so that every edge has exactly two faces.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import Face, Solid
from frontage.solids.cells.contract import Node
from frontage.solids.cells.partition import Partition
from frontage.solids.cells.placing import Placed
from frontage.solids.hosts.walls import Wall
from frontage.solids.relief import GRID
from frontage.solids.rims import Edge, compact, normal, rings_of, without_spurs

Spot = tuple[Node, int]  # a node at a height
_STEEP = float(np.sin(np.pi / 4))  # a side of a protrusion is a floor or ceiling below 45 degrees


def carve(solid: Solid, wall: Wall, parts: Partition, placed: Sequence[Placed]) -> Solid:
    """The solid with a wall's cells in place of its faces."""
    work = _Work(solid, wall, parts)
    faces = []
    for cell in parts.cells:
        ring, *holes = (tuple(work.vertex((n, cell.height)) for n in r) for r in cell.rings)
        relief = placed[cell.relief].relief if cell.relief >= 0 else None
        opening = relief.id if relief is not None else None
        semantics = relief.semantics if relief is not None else "WallSurface"
        faces.append(Face(ring, semantics, tuple(holes), opening))
    faces += _sides(work, parts, placed)
    others = [_rimmed(f, work.paths) for k, f in enumerate(solid.faces) if k not in wall.faces]
    grid = np.concatenate([solid.vertices, np.array(work.new, np.int64).reshape(-1, 3)])
    return compact(solid.building, grid, others + faces, solid.origin, "3")


def _sides(work: "_Work", parts: Partition, placed: Sequence[Placed]) -> list[Face]:
    """Faces between neighbouring cells of different height."""
    faces = []
    for (a, b), k in sorted(parts.left.items()):
        other = parts.left.get((b, a))
        if other is None or parts.cells[k].height == parts.cells[other].height or a > b:
            continue
        here, there = parts.cells[k], parts.cells[other]
        ring = [(b, here.height), *work.rise(a, here.height, there.height)]
        ring += [*work.rise(b, there.height, here.height)[:-1]]
        outer = here if here.height < there.height else there
        stands_out = outer.relief >= 0 and _stands_out(placed, outer.relief)
        inner = there if outer is here else here
        part_of = _lies_on(placed, inner.relief, outer.relief)
        kind = "WallSurface"
        if stands_out and not part_of:
            right = (a, b) if outer is here else (b, a)  # the protrusion lies to the left
            kind = _side_kind(right[0], right[1])
        faces.append(Face(tuple(work.vertex(s) for s in ring), kind))
    return faces


def _stands_out(placed: Sequence[Placed], index: int) -> bool:
    base = placed[placed[index].parent].height if placed[index].parent >= 0 else 0
    return placed[index].height < base


def _lies_on(placed: Sequence[Placed], index: int, below: int) -> bool:
    """Whether a relief lies on another one, directly or not."""
    while index >= 0 and index != below:
        index = placed[index].parent
    return index >= 0


def _side_kind(a: Node, b: Node) -> str:
    """Class of the side of a protrusion that lies to the left of the edge from a to b."""
    length = float(np.hypot(b[0] - a[0], b[1] - a[1]))
    up = -(b[0] - a[0]) / length  # outward normal (dz, -dx) / length
    return "OuterFloorSurface" if up > _STEEP else "OuterCeilingSurface" if up < -_STEEP else "WallSurface"


@dataclass
class _Work:
    """Vertices of nodes at heights, and the new way along every border edge of the wall."""

    solid: Solid
    wall: Wall
    parts: Partition
    new: list[tuple[int, int, int]] = field(default_factory=list)
    known: dict[Spot, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.levels = self.parts.heights()
        self.local = self.solid.vertices / GRID
        frame = self.wall.local_from_wall
        self.planes = {k: self._plane(self.solid.faces[k]) for k in self.wall.faces}
        self.face_at = {n: c.face for c in self.parts.cells for ring in c.rings for n in ring}
        self.on_edge: dict[Node, Edge] = {}
        self.trail: dict[Edge, list[Node]] = {}
        place = {i: n for n, i in self.wall.nodes.items()}
        for edge in self._host_edges():
            self.trail[edge] = self._along(place[edge[0]], place[edge[1]])
            self.on_edge |= dict.fromkeys(self.trail[edge][1:-1], edge)
        self.feet = {e: self._ground_plane(f) for e, f in self.wall.ground.items()}
        self.frame = frame
        self.paths = {e: self._path(e) for e in self.wall.border}

    def _host_edges(self) -> list[Edge]:
        edges = {
            e if e in self.wall.border or e[0] < e[1] else e[::-1]
            for k in self.wall.faces
            for ring in rings_of(self.solid.faces[k])
            for e in zip(ring, (*ring[1:], ring[0]), strict=True)
        }
        return sorted(edges)

    def _along(self, a: Node, b: Node) -> list[Node]:
        """The nodes of the partition on a host edge, in order; rounding moves them by 1 at most."""
        p, q = np.array(a, np.float64), np.array(b, np.float64)
        nodes = list(self.levels)
        xz = np.array(nodes, np.float64)
        t = (xz - p) @ (q - p) / float((q - p) @ (q - p))
        off = np.linalg.norm(xz - p - t[:, None] * (q - p), axis=1)
        on = np.nonzero((off <= 1.0) & (t > 0) & (t < 1))[0]
        inner = [nodes[k] for k in on[np.argsort(t[on], kind="stable")] if nodes[k] not in (a, b)]
        return [a, *inner, b]

    def _plane(self, face: Face) -> tuple[Float, Float]:
        """Height of a host face over the wall's frame: point (3,) and normal (3,) in wall axes, m."""
        ring = self.wall.local_from_wall.inverse.apply(self.local[list(face.ring)])
        return ring.mean(0), normal(ring)

    def _ground_plane(self, face: int) -> tuple[Float, Float]:
        ring = self.local[list(self.solid.faces[face].ring)]
        return self.wall.local_from_wall.inverse.apply(ring).mean(0), self.wall.local_from_wall.R.T @ normal(
            ring
        )

    def rise(self, node: Node, start: int, end: int) -> list[Spot]:
        """A node from one height to another, through all heights of its cells between the two."""
        low, high = min(start, end), max(start, end)
        between = [(node, h) for h in sorted({*self.levels[node], low, high}) if low <= h <= high]
        return between if start < end else between[::-1]

    def _path(self, edge: Edge) -> list[int]:
        """The vertices from end to end of a border edge, seen from the wall, its ends included."""
        nodes = self.trail[edge]
        spots: list[Spot] = [(nodes[0], 0)]
        for a, b in itertools.pairwise(nodes):
            height = self.parts.cells[self.parts.left[a, b]].height
            spots += [*self.rise(a, spots[-1][1], height)[1:], (b, height)]
        spots += self.rise(nodes[-1], spots[-1][1], 0)[1:]
        return [self.vertex(s) for s in spots]

    def vertex(self, spot: Spot) -> int:
        """The vertex of a node at a height: the host's own where there is one."""
        node, height = spot
        if height == 0 and node in self.wall.nodes:
            return self.wall.nodes[node]
        if spot not in self.known:
            world = np.rint(self.frame.apply(self._position(node, height)[None])[0] * GRID).astype(np.int64)
            self.known[spot] = len(self.solid.vertices) + len(self.new)
            x, y, z = world.tolist()
            self.new.append((x, y, z))
        return self.known[spot]

    def _position(self, node: Node, height: int) -> Float:
        """In wall axes, m: on its host edge or face at height 0, else at its height; feet on the ground."""
        flat = np.array([node[0], height, node[1]]) / GRID
        edge = self.on_edge.get(node)
        if edge is None and node in self.wall.nodes:
            ids = [e for e in self.feet if self.wall.nodes[node] in e]
            edge = ids[0] if ids else None
        elif edge is not None:
            ends = self.frame.inverse.apply(self.local[list(edge)])
            way = ends[1] - ends[0]
            t = float((flat - ends[0]) @ way / (way @ way))
            flat = ends[0] + t * way + [0.0, height / GRID, 0.0]
        elif height == 0:
            point, n = self.planes[self.face_at[node]]
            flat[1] = point[1] - ((flat - point) * n)[[0, 2]].sum() / n[1]
        if height and edge in self.feet:
            point, n = self.feet[edge]
            flat[2] -= float((flat - point) @ n / n[2])
        return flat


def _rimmed(face: Face, paths: dict[Edge, list[int]]) -> Face:
    """A neighbour of the wall with its edges along the wall replaced."""
    ring, *holes = (_follow(r, paths) for r in rings_of(face))
    return Face(ring, face.semantics, tuple(holes), face.opening)


def _follow(ring: tuple[int, ...], paths: dict[Edge, list[int]]) -> tuple[int, ...]:
    out: list[int] = []
    for a, b in zip(ring, (*ring[1:], ring[0]), strict=True):
        way = paths.get((b, a), [b, a])[::-1]
        out += way[:-1]
    return without_spurs(out)
