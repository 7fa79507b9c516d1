"""A wall cut into conforming cells: every cell has one height, every border is shared node by node.

The arrangement of the host's polygons and the reliefs' outlines in whole 0.1 mm, by snap rounding
(Hobby 1999, in GEOS), so that no node lies on another edge and no two borders almost coincide.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.solids.cells.contract import SHORTEST, Node, contracted
from frontage.solids.cells.placing import Placed
from frontage.solids.hosts.walls import Wall

_ON_LINE = 1.0  # 0.1 mm: as far from a line as rounding puts a node that was meant to be on it


@dataclass(frozen=True, eq=False)
class Cell:
    """A cell: rings of nodes (x, z) in 0.1 mm, the outer one counter-clockwise as seen from the street and
    the holes clockwise, its height, its relief's number (-1: plain wall), the host face it lies on."""

    rings: tuple[tuple[Node, ...], ...]
    height: int
    relief: int
    face: int


@dataclass(frozen=True, eq=False)
class Partition:
    """Cells, and which of them lies to the left of every directed edge."""

    cells: tuple[Cell, ...]
    left: dict[tuple[Node, Node], int]

    def heights(self) -> dict[Node, tuple[int, ...]]:
        """The different heights of the cells around every node, ascending."""
        found: dict[Node, set[int]] = {}
        for (a, b), k in self.left.items():
            found.setdefault(a, set()).add(self.cells[k].height)
            found.setdefault(b, set()).add(self.cells[k].height)
        return {n: tuple(sorted(h)) for n, h in found.items()}

    def pinched(self) -> list[Node]:
        """Nodes where the solid would touch itself along an edge: void, solid, void, solid around it.

        Also those where a cell's ring touches itself.
        """
        after: dict[Node, list[Node]] = {}
        for a, b in {e for edge in self.left for e in (edge, edge[::-1])}:
            after.setdefault(a, []).append(b)
        busy = [n for n, ends in after.items() if len(ends) > 3]
        twice = {n for c in self.cells for r in c.rings if len(set(r)) < len(r) for n in r if r.count(n) > 1}
        return sorted(twice | {n for n in busy if self._alternates(n, after[n])})

    def _alternates(self, node: Node, ends: Sequence[Node]) -> bool:
        turn = np.argsort([np.arctan2(z - node[1], x - node[0]) for x, z in ends])
        cells = [self.left.get((node, ends[k]), -1) for k in turn]
        around = np.array([self.cells[c].height if c >= 0 else np.inf for c in cells], np.float64)
        for level in np.unique(around)[1:]:
            solid = around < level
            if (solid != np.roll(solid, 1)).sum() > 2:
                return True
        return False


def partition(wall: Wall, placed: Sequence[Placed]) -> Partition:
    """The cells of a wall with its reliefs."""
    outlines = [p.polygon.exterior for p in placed]
    hosts = [b for p in wall.polygons for b in (p.exterior, *p.interiors)]
    top = shapely.union_all([p.polygon for p in placed if p.parent < 0])
    border = shapely.union_all(list(wall.polygons), grid_size=1.0).boundary
    seams = shapely.difference(shapely.union_all(hosts, grid_size=1.0), top) if len(wall.polygons) > 1 else []
    lines = [*outlines, border, *shapely.get_parts(seams)]
    pieces = shapely.get_parts(shapely.polygonize([shapely.union_all(_pinned(lines), grid_size=1.0)]))
    spots = shapely.point_on_surface(pieces)
    face = _last(wall.polygons, spots)
    relief = _last([p.polygon for p in placed], spots)
    inside = [k for k, f in enumerate(face.tolist()) if f >= 0]
    rings = [
        tuple(_nodes(g, k > 0) for k, g in enumerate((piece.exterior, *piece.interiors)))
        for piece in pieces[inside]
    ]
    kept = contracted(rings, set(wall.nodes))
    cells = [
        Cell(own, placed[r].height if r >= 0 else 0, r, wall.faces[f])
        for own, r, f in zip(kept, relief[inside].tolist(), face[inside].tolist(), strict=True)
        if own
    ]
    left = {e: k for k, c in enumerate(cells) for ring in c.rings for e in _pairs(ring)}
    return Partition(tuple(cells), left)


def _pinned(lines: Sequence[shapely.Geometry]) -> np.ndarray:
    """Lines that pass through the nodes of others which lie on them but for rounding.

    Along a line that is not parallel to an axis no whole 0.1 mm lies exactly on it; without this, slivers
    as wide as the rounding stay between two lines that were meant to be one.
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


def _last(areas: Sequence[shapely.Polygon], spots: np.ndarray) -> np.ndarray:
    """Number of the last area that covers each spot (reliefs come after what they lie on), or -1."""
    found = np.full(len(spots), -1)
    if len(areas):
        spot, area = shapely.STRtree(list(areas)).query(spots, predicate="intersects")
        np.maximum.at(found, spot, area)
    return found


def _nodes(ring: shapely.LinearRing, hole: bool) -> tuple[Node, ...]:
    grid = np.rint(shapely.get_coordinates(ring)[:-1]).astype(np.int64)
    nodes = [(x, z) for x, z in grid.tolist()]
    return tuple(nodes[::-1] if ring.is_ccw == hole else nodes)


def _pairs(ring: Sequence[Node]) -> list[tuple[Node, Node]]:
    return list(zip(ring, (*ring[1:], ring[0]), strict=True))
