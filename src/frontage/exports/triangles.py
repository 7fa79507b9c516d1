"""The solids of a building as classified triangles, which its textured model and its picture are made of."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Array, Float, Int
from frontage.model import OPENING_SURFACES, Face, Solid
from frontage.solids import Assembled
from frontage.solids.brep import GRID_PER_M, newell_normal

KINDS = ("WallSurface", "RoofSurface", "GroundSurface", "OuterCeilingSurface", "OuterFloorSurface",
         *OPENING_SURFACES, "Installation", "Frame", "Pane")  # fmt: skip
"""What a triangle can show; every other semantic class counts as a wall. A pane stands in a frame."""

PANE_BEHIND_M = 0.03
"""Usual distance from the front of a frame back to its pane."""


@dataclass(frozen=True, eq=False)
class ModelTriangles:
    """The triangles of a model.

    corners  (t, 3, 3) float64 m local, counter-clockwise as seen from outside
    normals  (t, 3) float64, unit vectors
    kind     (t,) int64 into `KINDS`
    edges    (e, 2, 3) float64 m local, borders of the faces but those of panes and frames, where a
             drawing would be all lines
    opening  (t,) ids of the openings that they belong to; "" = none
    """

    corners: Float
    normals: Float
    kind: Int
    edges: Float
    opening: Array

    def __len__(self) -> int:
        """The number of triangles."""
        return len(self.corners)


def model_triangles(assembled: Assembled) -> ModelTriangles:
    """Triangulates the fine solids of a building, its installations and window frames.

    The surface of an opening with a frame moves back to the place of its pane. The backs of frames, which
    nobody sees, are left out.
    """
    framed = {f.opening for f in assembled.frames if f.around}
    parts = [_solid(b.solid, framed=framed) for b in assembled.built]
    parts += [_solid(i.solid, KINDS.index("Installation")) for i in assembled.installations]
    parts += [_frame(f.solid, f.opening) for f in assembled.frames]
    return _joined(parts)


def host_triangles(assembled: Assembled) -> ModelTriangles:
    """Triangulates the coarse solids of a building, without anything that was found on its facades."""
    return _joined([_solid(b.host) for b in assembled.built])


def _frame(solid: Solid, opening: str) -> ModelTriangles:
    """Triangulates the front and the sides of a prism."""
    xyz = solid.vertices / GRID_PER_M
    front, _, *sides = solid.faces
    n = newell_normal(xyz[list(front.ring)])
    face = _triangles(front, xyz, n)
    quads = xyz[np.array([f.ring for f in sides])]
    around = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    across = np.cross(around[:, 1] - around[:, 0], around[:, 2] - around[:, 0])
    corners = np.concatenate([face, around])
    return ModelTriangles(
        corners,
        np.concatenate([np.tile(n, (len(face), 1)), across / np.linalg.norm(across, axis=1)[:, None]]),
        np.full(len(corners), KINDS.index("Frame")),
        np.zeros((0, 2, 3)),
        np.full(len(corners), opening),
    )


def _joined(parts: Sequence[ModelTriangles]) -> ModelTriangles:
    """Concatenates several sets of triangles."""
    return ModelTriangles(
        np.concatenate([np.zeros((0, 3, 3)), *(p.corners for p in parts)]),
        np.concatenate([np.zeros((0, 3)), *(p.normals for p in parts)]),
        np.concatenate([np.zeros(0, np.int64), *(p.kind for p in parts)]),
        np.concatenate([np.zeros((0, 2, 3)), *(p.edges for p in parts)]),
        np.concatenate([np.zeros(0, "U1"), *(p.opening for p in parts)]),
    )


def _solid(solid: Solid, kind: int | None = None, framed: Collection[str] = ()) -> ModelTriangles:
    """Triangulates a solid; all triangles get the same `kind`, or that of their face.

    The surfaces of the openings in `framed` become panes and move back.
    """
    xyz = solid.vertices / GRID_PER_M
    corners, normals, kinds, edges, openings = [], [], [], [], []
    for face in solid.faces:
        n = newell_normal(xyz[list(face.ring)])
        triangles = _triangles(face, xyz, n)
        pane = face.opening in framed
        corners.append(triangles - n * PANE_BEHIND_M if pane else triangles)
        normals.append(np.tile(n, (len(triangles), 1)))
        shown = "Pane" if pane else face.semantics
        own = kind if kind is not None else KINDS.index(shown) if shown in KINDS else 0
        kinds.append(np.full(len(triangles), own))
        openings.append(np.full(len(triangles), face.opening or ""))
        for ring in () if pane else (face.ring, *face.holes):
            edges.append(np.stack([xyz[list(ring)], xyz[[*ring[1:], ring[0]]]], axis=1))
    return ModelTriangles(
        np.concatenate(corners),
        np.concatenate(normals),
        np.concatenate(kinds),
        np.concatenate(edges),
        np.concatenate(openings),
    )


def _triangles(face: Face, xyz: Float, n: Float) -> Float:
    """Triangulates a face into (t, 3, 3) without adding a vertex; xyz (v, 3), n = its unit normal (3,)."""
    ring = xyz[list(face.ring)]
    if len(ring) == 3 and not face.holes:
        return ring[None]
    axis = int(np.argmax(np.abs(n)))
    u, v = [(1, 2), (2, 0), (0, 1)][axis] if n[axis] > 0 else [(2, 1), (0, 2), (1, 0)][axis]
    ids = np.array([i for r in (face.ring, *face.holes) for i in r])
    flat = xyz[:, [u, v]]
    polygon = shapely.Polygon(flat[list(face.ring)], [flat[list(h)] for h in face.holes])
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(shapely.make_valid(polygon)))
    found = np.array([shapely.get_coordinates(p)[:3] for p in parts]).reshape(-1, 3, 2)
    a, b = found[:, 1] - found[:, 0], found[:, 2] - found[:, 0]
    clockwise = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] < 0
    found[clockwise] = found[clockwise][:, ::-1]
    place = {tuple(p): i for p, i in zip(flat[ids].tolist(), ids.tolist(), strict=True)}
    known = [[place.get(tuple(p), -1) for p in t] for t in found.tolist()]
    return np.asarray(xyz[np.array([t for t in known if -1 not in t], np.int64).reshape(-1, 3)])


def cut_triangles(shapes: ModelTriangles, rows: Int, flat: Float, window: shapely.Polygon) -> ModelTriangles:
    """Cuts the triangles in `rows` (n,) where the border of a window crosses them.

    `flat` (n, 3, 2) are their corners in any affine coordinates of their plane, which the window is in, too.
    The parts stand at the end, inside and outside of the window.
    """
    corners, source = [np.zeros((0, 3, 3))], [np.zeros(0, np.int64)]
    for row, triangle in zip(rows.tolist(), flat, strict=True):
        whole = shapely.Polygon(triangle)
        halves = [whole.intersection(window), whole.difference(window)]
        parts = shapely.get_parts(shapely.constrained_delaunay_triangles(np.array(halves)))
        places = np.array([shapely.get_coordinates(p)[:3] for p in shapely.get_parts(parts)]).reshape(-1, 2)
        weights = np.linalg.solve(
            np.vstack([triangle.T, np.ones(3)]), np.vstack([places.T, np.ones(len(places))])
        )
        found = (weights.T @ shapes.corners[row]).reshape(-1, 3, 3)
        turned = np.cross(found[:, 1] - found[:, 0], found[:, 2] - found[:, 0]) @ shapes.normals[row] < 0
        found[turned] = found[turned][:, ::-1]
        corners.append(found)
        source.append(np.full(len(found), row))
    of = np.concatenate([np.setdiff1d(np.arange(len(shapes)), rows), *source])
    kept = shapes.corners[of[: len(shapes) - len(rows)]]
    return ModelTriangles(
        np.concatenate([kept, *corners]),
        shapes.normals[of],
        shapes.kind[of],
        shapes.edges,
        shapes.opening[of],
    )


def unique_vertices(corners: Float, extra: Float) -> tuple[Array, Array]:
    """Merges equal vertices of triangles.

    `corners` (t, 3, 3), `extra` (t, 3, k). Returns the distinct rows (n, 3 + k) of (corner, extra) and the
    triangles (t, 3) as numbers of rows.
    """
    rows = np.concatenate([corners, extra], axis=2).reshape(-1, 3 + extra.shape[2])
    found, index = np.unique(rows, axis=0, return_inverse=True)
    return found, index.reshape(-1, 3)
