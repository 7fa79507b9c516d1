"""Faces are triangulated without new vertices, also where GEOS fails on them as they lie."""

import numpy as np
import pytest
import shapely

from frontage.model import Polygons
from frontage.validation.geometry.faces_2d import NodedRings
from frontage.validation.geometry.mesh import weld
from frontage.validation.geometry.triangulate import triangulate

# (turn, polygon) on which GEOS 3.14 finds no convex corner; found by search
HARD = [
    (2.28, "POLYGON ((0 1, 0 2, 0 3, 1 3, 1 2, 1 1, 2 1, 2 2, 3 2, 3 1, 3 0, 2 0, 1 0, 0 0, 0 1))"),
    (
        0.17,
        "POLYGON ((-1 -1, -1 5, 5 5, 5 -1, -1 -1), (1 0, 2 0, 3 0, 3 1, 2 1, 1 1, 1 0), "
        "(1 2, 0 2, 0 1, 1 1, 1 2), "
        "(2 2, 2 3, 1 3, 1 2, 2 2), (1 4, 0 4, 0 3, 1 3, 1 4), (3 3, 3 2, 4 2, 4 3, 3 3))",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("turn", "text"), HARD)
def test_the_triangles_cover_the_face(turn: float, text: str) -> None:
    s, c = np.sin(turn), np.cos(turn)
    rotation = np.array([[c, -s], [s, c]])
    easy = np.array([(9.0, 0), (10, 0), (11, 0.5), (10, 1), (9, 1)])
    polygon = shapely.from_wkt(text)
    faces = [[easy], [np.asarray(r.coords)[:-1] for r in (polygon.exterior, *polygon.interiors)]]
    flat = [[r @ rotation.T for r in face] for face in faces]
    mesh = weld([Polygons.of([[np.column_stack([r, np.zeros(len(r))]) for r in f] for f in flat])], 0.001)[0]
    xy = np.concatenate([r for f in flat for r in f])
    ids, face = triangulate(mesh, xy, np.ones(2, np.bool_), NodedRings.of(mesh))
    a, b, d = (mesh.xyz[ids[:, k], :2] for k in range(3))
    area = np.abs((b - a)[:, 0] * (d - a)[:, 1] - (b - a)[:, 1] * (d - a)[:, 0]) / 2
    assert np.bincount(face, weights=area) == pytest.approx([1.5, polygon.area], abs=1e-6)
    assert area.min() > 0.01
