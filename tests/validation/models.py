"""Small solids for the validator's tests, easy to break in one place."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.model import Polygons, Shape

Ring = tuple[int, ...]
Face = tuple[Ring, ...]


@dataclass(frozen=True, eq=False)
class Model:
    """Vertices (v, 3) and faces as rings of vertex ids, the outer ring first."""

    xyz: Float
    faces: tuple[Face, ...]

    def surfaces(self, closed: bool = False) -> Polygons:
        """Returns the validator's input; if `closed`, rings repeat their first point, as in GML."""
        turn = [[(*r, r[0]) if closed and r else r for r in face] for face in self.faces]
        return Polygons.of([[self.xyz[list(r)] for r in face] for face in turn], explicit=closed)

    def shape(self, *inner: "Model", kind: str = "Solid") -> Shape:
        return Shape(kind, ((self.surfaces(), *(m.surfaces() for m in inner)),))  # type: ignore[arg-type]

    def without(self, face: int) -> "Model":
        return replace(self, faces=self.faces[:face] + self.faces[face + 1 :])

    def with_face(self, *rings: Ring) -> "Model":
        return replace(self, faces=(*self.faces, tuple(rings)))

    def changed(self, face: int, *rings: Ring) -> "Model":
        return replace(self, faces=(*self.faces[:face], tuple(rings), *self.faces[face + 1 :]))

    def moved(self, vertex: int, by: Sequence[float]) -> "Model":
        xyz = self.xyz.copy()
        xyz[vertex] += by
        return replace(self, xyz=xyz)

    def also(self, *points: Sequence[float]) -> "Model":
        return replace(self, xyz=np.vstack([self.xyz, points]))

    def shifted(self, by: Sequence[float]) -> "Model":
        return replace(self, xyz=self.xyz + np.asarray(by))

    def turned(self) -> "Model":
        """Returns the model inside out."""
        return replace(self, faces=tuple(tuple(r[::-1] for r in face) for face in self.faces))

    def placed(self, rotation: Float, shift: Sequence[float]) -> "Model":
        return replace(self, xyz=self.xyz @ rotation.T + np.asarray(shift))

    def joined(self, other: "Model") -> "Model":
        """Returns both models in one list of faces."""
        n = len(self.xyz)
        faces = tuple(tuple(tuple(i + n for i in r) for r in face) for face in other.faces)
        return Model(np.vstack([self.xyz, other.xyz]), self.faces + faces)


def box(low: Sequence[float] = (0, 0, 0), high: Sequence[float] = (1, 1, 1)) -> Model:
    """Returns a box: faces bottom, top, y low, x high, y high, x low; vertices 0-3 below and 4-7 above."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    flat = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    xyz = [(x, y, z) for z in (z0, z1) for x, y in flat]
    sides = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
    return Model(np.array(xyz, np.float64), tuple((s,) for s in sides))


def ell(height: float = 3.0) -> Model:
    """Returns an L-shaped prism, 4 x 4 m."""
    return extrude(shapely.Polygon([(0, 0), (4, 0), (4, 2), (2, 2), (2, 4), (0, 4)]), 0.0, height)


def extrude(plan: shapely.Polygon, low: float, high: float) -> Model:
    """Returns a prism over a polygon with holes."""
    plan = shapely.orient_polygons(plan)
    rings = [np.asarray(r.coords)[:-1] for r in (plan.exterior, *plan.interiors)]
    n = sum(len(r) for r in rings)
    flat = np.vstack(rings)
    xyz = np.vstack([np.column_stack([flat, np.full(n, z)]) for z in (low, high)])
    ids, start = [], 0
    for r in rings:
        ids.append(tuple(range(start, start + len(r))))
        start += len(r)
    walls = [((i, j, j + n, i + n),) for r in ids for i, j in zip(r, (*r[1:], r[0]), strict=True)]
    top = tuple(tuple(i + n for i in r) for r in ids)
    bottom = tuple(r[::-1] for r in ids)
    return Model(xyz, (bottom, top, *walls))


def pyramid(base: Sequence[Sequence[float]], tip: Sequence[float]) -> Model:
    """Returns a pyramid over a ring that is counter-clockwise as seen from its tip."""
    n = len(base)
    sides = tuple(((i, (i + 1) % n, n),) for i in range(n))
    return Model(np.array([*base, tip], np.float64), ((tuple(range(n))[::-1],), *sides))


def windows(columns: int, rows: int, depth: float = 0.2) -> Model:
    """Returns a block with recessed windows, each a hole in the wall, four reveals and a pane."""
    block = box((0, 0, 0), (3.0 * columns + 1, 10.0, 3.0 * rows + 1))
    xyz, faces, holes = list(block.xyz), list(block.faces), []
    for i in range(columns):
        for j in range(rows):
            x, z, k = 1 + 3.0 * i, 1 + 3.0 * j, len(xyz)
            around = [(x, z), (x + 1.5, z), (x + 1.5, z + 2), (x, z + 2)]
            xyz += [np.array([a, y, b]) for y in (0.0, depth) for a, b in around]
            holes.append((k, k + 3, k + 2, k + 1))
            faces.append(((k + 4, k + 5, k + 6, k + 7),))
            faces += [((k + a, k + b, k + b + 4, k + a + 4),) for a, b in ((0, 1), (1, 2), (2, 3), (3, 0))]
    faces[2] = (faces[2][0], *holes)
    return Model(np.array(xyz), tuple(faces))
