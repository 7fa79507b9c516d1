"""Turns cells into faces: the boundary between solid and void replaces the faces of a partitioned wall.

A wall with reliefs is a field of heights over its cells. Its boundary consists of every cell at its height,
and a side face at every border between two heights. At a node, the heights of all cells around it are
vertices of all faces that pass there, so that every edge has exactly two faces.
"""

from collections.abc import Sequence

import numpy as np

from frontage.model import Face, Solid
from frontage.solids.brep import Edge, compact, ring_edges, rings_of, without_spurs
from frontage.solids.cells.contract import Node
from frontage.solids.cells.partition import Cell, Partition
from frontage.solids.cells.placed import PlacedRelief, base_height
from frontage.solids.cells.wall_vertices import WallVertices
from frontage.solids.walls import HostWall

_STEEP_SINE = float(np.sin(np.pi / 4))  # a side of a protrusion flatter than 45 degrees is a floor or ceiling


def carve(solid: Solid, wall: HostWall, partition: Partition, placed: Sequence[PlacedRelief]) -> Solid:
    """Returns the solid with the cells of a wall in place of the wall's faces, as LoD3."""
    vertices = WallVertices(solid, wall, partition)
    faces = [_cell_face(cell, vertices, placed) for cell in partition.cells]
    faces += _side_faces(vertices, partition, placed)
    others = [_along_new_border(f, vertices.paths) for k, f in enumerate(solid.faces) if k not in wall.faces]
    grid = np.concatenate([solid.vertices, np.array(vertices.new, np.int64).reshape(-1, 3)])
    return compact(solid.building, grid, others + faces, solid.origin, "3")


def _cell_face(cell: Cell, vertices: WallVertices, placed: Sequence[PlacedRelief]) -> Face:
    """Returns a cell as a face at its height."""
    ring, *holes = (tuple(vertices.vertex((n, cell.height)) for n in r) for r in cell.rings)
    if cell.relief < 0:
        return Face(ring, "WallSurface", tuple(holes))
    relief = placed[cell.relief].relief
    return Face(ring, relief.semantics, tuple(holes), relief.id)


def _side_faces(vertices: WallVertices, partition: Partition, placed: Sequence[PlacedRelief]) -> list[Face]:
    """Returns the faces between neighbouring cells of different height."""
    faces = []
    for (a, b), k in sorted(partition.left.items()):
        other = partition.left.get((b, a))
        if other is None or partition.cells[k].height == partition.cells[other].height or a > b:
            continue
        here, there = partition.cells[k], partition.cells[other]
        ring = [(b, here.height), *vertices.rise(a, here.height, there.height)]
        ring += [*vertices.rise(b, there.height, here.height)[:-1]]
        outer, inner = (here, there) if here.height < there.height else (there, here)
        kind = "WallSurface"
        if _protrudes(placed, outer.relief) and not _lies_on(placed, inner.relief, outer.relief):
            left_edge = (a, b) if outer is here else (b, a)  # the protrusion lies to the left of it
            kind = _side_semantics(*left_edge)
        faces.append(Face(tuple(vertices.vertex(s) for s in ring), kind))
    return faces


def _protrudes(placed: Sequence[PlacedRelief], index: int) -> bool:
    """Decides whether a relief stands in front of the surface that it lies on."""
    return index >= 0 and placed[index].height < base_height(placed, index)


def _lies_on(placed: Sequence[PlacedRelief], index: int, below: int) -> bool:
    """Decides whether a relief lies on another one, directly or not."""
    while index >= 0 and index != below:
        index = placed[index].parent
    return index >= 0


def _side_semantics(a: Node, b: Node) -> str:
    """Returns the CityGML class of the side of a protrusion that lies to the left of the edge from a to b."""
    length = float(np.hypot(b[0] - a[0], b[1] - a[1]))
    up = -(b[0] - a[0]) / length  # the outward normal is (dz, -dx) / length
    if abs(up) <= _STEEP_SINE:
        return "WallSurface"
    return "OuterFloorSurface" if up > 0 else "OuterCeilingSurface"


def _along_new_border(face: Face, paths: dict[Edge, list[int]]) -> Face:
    """Returns a neighbour of the wall with the new vertices in its edges along the wall."""
    ring, *holes = (_ring_along(r, paths) for r in rings_of(face))
    return Face(ring, face.semantics, tuple(holes), face.opening)


def _ring_along(ring: tuple[int, ...], paths: dict[Edge, list[int]]) -> tuple[int, ...]:
    out: list[int] = []
    for a, b in ring_edges(ring):
        path = paths.get((b, a), [b, a])[::-1]
        out += path[:-1]
    return without_spurs(out)
