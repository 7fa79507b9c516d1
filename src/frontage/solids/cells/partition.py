"""Partitions a wall into conforming cells: every cell has one height, every border is shared node by node.

The cells are the arrangement of the host's polygons and the reliefs' outlines in whole 0.1 mm, by snap
rounding (Hobby 1999, in GEOS), so that no node lies on another edge and no two borders almost coincide.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.solids.brep import ring_edges
from frontage.solids.cells.contract import SHORTEST, Node, contract_short_edges
from frontage.solids.cells.placed import PlacedRelief
from frontage.solids.walls import HostWall

_ON_LINE = 1.0  # 0.1 mm: how far rounding moves a node off the line that it was meant to lie on


@dataclass(frozen=True, eq=False)
class Cell:
    """A cell of a wall.

    rings   nodes (x, z) in 0.1 mm; the outer ring counter-clockwise as seen from the street, holes clockwise
    height  0.1 mm, positive = behind the wall
    relief  index of its relief; -1 = plain wall
    face    index of the host face that it lies on
    """

    rings: tuple[tuple[Node, ...], ...]
    height: int
    relief: int
    face: int


@dataclass(frozen=True, eq=False)
class Partition:
    """The cells of a wall, and directed edge -> index of the cell on its left."""

    cells: tuple[Cell, ...]
    left: dict[tuple[Node, Node], int]

    def heights(self) -> dict[Node, tuple[int, ...]]:
        """Returns for every node the different heights of the cells around it, ascending."""
        found: dict[Node, set[int]] = {}
        for (a, b), k in self.left.items():
            found.setdefault(a, set()).add(self.cells[k].height)
            found.setdefault(b, set()).add(self.cells[k].height)
        return {n: tuple(sorted(h)) for n, h in found.items()}

    def pinched_nodes(self) -> list[Node]:
        """Returns the nodes where the solid would touch itself along an edge, or a ring of a cell does.

        Around the former, solid and void alternate more than once at some height.
        """
        ends: dict[Node, list[Node]] = {}
        for a, b in {e for edge in self.left for e in (edge, edge[::-1])}:
            ends.setdefault(a, []).append(b)
        branching = [n for n, others in ends.items() if len(others) > 3]
        twice = {n for c in self.cells for r in c.rings if len(set(r)) < len(r) for n in r if r.count(n) > 1}
        return sorted(twice | {n for n in branching if self._alternates(n, ends[n])})

    def _alternates(self, node: Node, ends: Sequence[Node]) -> bool:
        """Decides whether solid and void alternate more than once around a node."""
        turn = np.argsort([np.arctan2(z - node[1], x - node[0]) for x, z in ends])
        cells = [self.left.get((node, ends[k]), -1) for k in turn]
        around = np.array([self.cells[c].height if c >= 0 else np.inf for c in cells], np.float64)
        for level in np.unique(around)[1:]:
            solid = around < level
            if (solid != np.roll(solid, 1)).sum() > 2:
                return True
        return False


def partition_wall(wall: HostWall, placed: Sequence[PlacedRelief]) -> Partition:
    """Returns the cells of a wall with its reliefs."""
    pieces = _arrangement(wall, placed)
    spots = shapely.point_on_surface(pieces)
    face = _last_covering(wall.polygons, spots)
    relief = _last_covering([p.polygon for p in placed], spots)
    inside = [k for k, f in enumerate(face.tolist()) if f >= 0]
    rings = [
        tuple(_nodes(g, k > 0) for k, g in enumerate((piece.exterior, *piece.interiors)))
        for piece in pieces[inside]
    ]
    kept = contract_short_edges(rings, set(wall.nodes))
    cells = [
        Cell(own, placed[r].height if r >= 0 else 0, r, wall.faces[f])
        for own, r, f in zip(kept, relief[inside].tolist(), face[inside].tolist(), strict=True)
        if own
    ]
    left = {e: k for k, c in enumerate(cells) for ring in c.rings for e in ring_edges(ring)}
    return Partition(tuple(cells), left)


def _arrangement(wall: HostWall, placed: Sequence[PlacedRelief]) -> np.ndarray:
    """Returns the polygons into which outlines of reliefs, border and seams divide a wall."""
    outlines = [p.polygon.exterior for p in placed]
    hosts = [b for p in wall.polygons for b in (p.exterior, *p.interiors)]
    covered = shapely.union_all([p.polygon for p in placed if p.parent < 0])
    border = shapely.union_all(list(wall.polygons), grid_size=1.0).boundary
    several = len(wall.polygons) > 1
    seams = shapely.difference(shapely.union_all(hosts, grid_size=1.0), covered) if several else []
    lines = [*outlines, border, *shapely.get_parts(seams)]
    noded = shapely.union_all(_through_nodes(lines), grid_size=1.0)
    pieces: np.ndarray = shapely.get_parts(shapely.polygonize([noded]))
    return pieces


def _through_nodes(lines: Sequence[shapely.Geometry]) -> np.ndarray:
    """Makes lines pass through the nodes of other lines that lie on them but for rounding.

    Hardly any grid point lies exactly on a line that is not parallel to an axis. Without this step, slivers
    as wide as the rounding would stay between two lines that were meant to coincide.
    """
    rings = [shapely.get_coordinates(g) for line in lines for g in shapely.get_parts(line)]
    start, end = (np.concatenate([r[part] for r in rings]) for part in (slice(None, -1), slice(1, None)))
    nodes = np.unique(start, axis=0)
    edges = shapely.linestrings(np.stack([start, end], axis=1))
    edge, node = shapely.STRtree(shapely.points(nodes)).query(edges, predicate="dwithin", distance=_ON_LINE)
    way = end - start
    along = np.einsum("ni,ni->n", nodes[node] - start[edge], way[edge])
    length = np.linalg.norm(way, axis=1)
    place = along / np.maximum(length[edge], 1e-9)
    inner = (place > SHORTEST) & (place < length[edge] - SHORTEST)
    edge, node, place = edge[inner], nodes[node[inner]], place[inner]
    ring = np.repeat(np.arange(len(rings)), [len(r) - 1 for r in rings])
    last = np.flatnonzero(np.diff(ring, append=len(rings)))  # the edge that ends each ring
    owner = np.concatenate([np.arange(len(start)), last, edge])
    points = np.concatenate([start, end[last], node])
    order = np.lexsort((np.concatenate([np.zeros(len(start)), length[last], place]), owner))
    found: np.ndarray = shapely.linestrings(points[order], indices=ring[owner[order]])
    return found


def _last_covering(areas: Sequence[shapely.Polygon], spots: np.ndarray) -> np.ndarray:
    """Returns for each point the last area that covers it, or -1; reliefs follow those that they lie on."""
    found = np.full(len(spots), -1)
    if len(areas):
        spot, area = shapely.STRtree(list(areas)).query(spots, predicate="intersects")
        np.maximum.at(found, spot, area)
    return found


def _nodes(ring: shapely.LinearRing, hole: bool) -> tuple[Node, ...]:
    """Returns the nodes of a ring, counter-clockwise for an outer ring and clockwise for a hole."""
    grid = np.rint(shapely.get_coordinates(ring)[:-1]).astype(np.int64)
    nodes = [(x, z) for x, z in grid.tolist()]
    return tuple(nodes[::-1] if ring.is_ccw == hole else nodes)
