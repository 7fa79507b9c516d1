"""Meshes are closed around every hole, their solids face outwards, and they are repeatable."""

import time

import numpy as np
import pytest
import shapely

from frontage.geometry.arrays import Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle, ring_area
from frontage.simulate.houses.house import FOUNDATION_M
from frontage.simulate.houses.shapes import SHAPES, opening_ring
from frontage.simulate.meshing import MeshBuilder, Pen, inset, loft, triangulate
from frontage.simulate.scene import Part, Scene, SurfaceMaterial
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street

PLAIN = SurfaceMaterial("plain", "paint", (0.5, 0.5, 0.5), (0.5, 0.5, 0.5), 0.5)


def pen() -> tuple[MeshBuilder, Pen]:
    builder = MeshBuilder()
    return builder, Pen(builder, Rigid3.identity("local", "facade"))


def open_edges(vertices: Float, corners: Int) -> Float:
    """Ends (n, 2, 3) of the directed edges that no triangle has in the opposite direction."""
    points, index = np.unique(np.round(vertices, 6), axis=0, return_inverse=True)
    t = index.reshape(-1)[corners]
    edges = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    n = len(points)
    net: dict[int, int] = {}
    for a, b in edges.tolist():
        key, sign = (min(a, b) * n + max(a, b), 1 if a < b else -1)
        net[key] = net.get(key, 0) + sign
    left = [k for k, v in net.items() if v]
    return points[np.array([(k // n, k % n) for k in left], int).reshape(-1, 2)]


def volume(vertices: Float, corners: Int) -> float:
    a, b, c = (vertices[corners[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def area(vertices: Float, corners: Int) -> float:
    a, b, c = (vertices[corners[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def test_a_block_with_a_hole_is_closed_and_has_its_volume() -> None:
    builder, draw = pen()
    hole = opening_ring("round", 1.0, 1.0, 1.0, 1.5)
    outer = rectangle(0, 0, 4, 3)
    draw.block(draw.surface("block", Part.WALL, PLAIN), outer, 0.0, 0.5, holes=[hole])
    mesh = builder.mesh()
    assert len(open_edges(mesh.vertices, mesh.corners)) == 0
    expected = (ring_area(outer) - ring_area(hole)) * 0.5
    assert volume(mesh.vertices, mesh.corners) == pytest.approx(expected, rel=1e-12)


def test_boxes_and_lofts_are_closed_and_turned_outwards() -> None:
    builder, draw = pen()
    surface = draw.surface("box", Part.CAR, PLAIN)
    draw.box(surface, (1, 2, 3), (2, 4, 6))
    turn = np.linspace(0, 2 * np.pi, 7)[:-1]
    ring = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(6)])
    draw.triangles(surface, *loft(np.stack([ring, ring * 0.5 + np.array([0, 0, 2.0])])))
    mesh = builder.mesh()
    assert len(open_edges(mesh.vertices, mesh.corners)) == 0
    hexagon = 1.5 * np.sqrt(3)
    frustum = hexagon * 2 / 3 * (1 + 0.5 + 0.25)
    assert volume(mesh.vertices, mesh.corners) == pytest.approx(6 + frustum, rel=1e-12)


def test_triangles_cover_a_polygon_with_holes_once() -> None:
    ring = rectangle(0, 0, 8, 4)
    holes = [
        opening_ring(s, 0.5 + 1.1 * k, 0.5, 0.8, 0.8 if s == "circle" else 1.9) for k, s in enumerate(SHAPES)
    ]
    vertices, corners = triangulate(ring, holes)
    flat = np.column_stack([vertices, np.zeros(len(vertices))])
    assert area(flat, corners) == pytest.approx(32 - sum(ring_area(h) for h in holes), rel=1e-12)
    assert len(vertices) == 4 + sum(len(h) for h in holes)


def test_rings_that_touch_are_refused() -> None:
    with pytest.raises(ValueError, match="to be triangulated"):
        triangulate(rectangle(0, 0, 2, 2), [rectangle(1, 1, 3, 1.5)])


def test_inset_moves_every_side_by_the_distance() -> None:
    np.testing.assert_allclose(ring_area(inset(rectangle(0, 0, 2, 3), 0.1)), 1.8 * 2.8)
    np.testing.assert_allclose(ring_area(inset(rectangle(0, 0, 2, 3), -0.1)), 2.2 * 3.2)


def _shell(scene: Scene, house: int, facade: int) -> Int:
    """Triangles of a facade's wall, reveals, frames and inner reveals, and of the storeys' walls."""
    own = {Part.WALL, Part.REVEAL, Part.FRAME, Part.ORIEL}
    names = ("inner_reveal", "/walls", "/floor")
    keep = [
        k
        for k, s in enumerate(scene.surfaces)
        if s.house == house
        and "surround" not in s.id
        and ((s.facade == facade and s.part in own) or s.id.endswith(names))
    ]
    return np.flatnonzero(np.isin(scene.mesh.surface, keep))


@pytest.mark.parametrize("seed", [1, 5, 9])
def test_walls_are_closed_around_every_opening_up_to_the_rooms(seed: int) -> None:
    bare = {"setting": "terrace", "trees": 0, "cars": 0, "people": 0, "opposite": False}
    some = [{"shape": shape} for shape in ("triangular", "circle")] if seed == 1 else []
    scene = build_street(SceneSpec.model_validate({"seed": seed, "houses": 4, "house": some} | bare))
    for h, house in enumerate(scene.houses):
        plan = house.facades[0]
        rows = _shell(scene, h, 0)
        open_ = open_edges(scene.mesh.vertices, scene.mesh.corners[rows])
        inside = plan.local_from_facade.inverse.apply(open_.reshape(-1, 3)).reshape(-1, 2, 3)
        for opening in plan.openings:
            low = np.array([opening.ring[:, 0].min(), -2.0, opening.ring[:, 1].min()]) - 0.01
            high = np.array([opening.ring[:, 0].max(), 0.47, opening.ring[:, 1].max()]) + 0.01
            within = ((inside > low) & (inside < high)).all((1, 2))
            leaf = not opening.glazed  # the frame of a leaf has a free edge at its back
            free = inside[within][:, :, 1].min(axis=1) < opening.wall_y + opening.depth - 1e-6
            assert not (free.any() if leaf else within.any()), opening.id
        assert from_border(inside, plan.outline).max() < 1e-6


def from_border(edges: Float, outline: Float) -> Float:
    """How far the ends of open edges on the main plane are from the wall's own border (m)."""
    on = edges[(np.abs(edges[:, :, 1]) < 1e-6).all(1)]
    wall = np.vstack([[[0.0, FOUNDATION_M], [np.ptp(outline[:, 0]), FOUNDATION_M]], outline[2:]])
    assert len(on) >= len(wall)
    ends = shapely.points(on[:, :, [0, 2]].reshape(-1, 2))
    return np.asarray(shapely.distance(shapely.Polygon(wall).exterior, ends))


def test_the_same_spec_gives_the_same_bytes_and_another_seed_does_not() -> None:
    first, second, other = (build_street(SceneSpec(seed=s, houses=2)) for s in (4, 4, 5))
    assert first.mesh.vertices.tobytes() == second.mesh.vertices.tobytes()
    assert first.mesh.corners.tobytes() == second.mesh.corners.tobytes()
    assert first.surfaces == second.surfaces and first.materials == second.materials
    assert first.mesh.vertices.tobytes() != other.mesh.vertices.tobytes()


def test_every_triangle_has_an_area_and_every_surface_its_triangles() -> None:
    scene = build_street(SceneSpec(seed=6, houses=3))
    assert (np.linalg.norm(scene.mesh.normals, axis=1) > 0.5).mean() > 0.9999
    assert scene.mesh.corners.max() < len(scene.mesh.vertices)
    assert set(np.unique(scene.mesh.surface)) == set(range(len(scene.surfaces)))
    assert len({s.id for s in scene.surfaces}) == len(scene.surfaces)


def test_the_ground_meets_the_walls_and_does_not_enter_the_houses() -> None:
    scene = build_street(SceneSpec(seed=2, houses=3, trees=0, cars=0, people=0, hedges=False))
    ground = scene.parts[scene.mesh.surface] == Part.GROUND
    corners = scene.mesh.vertices[scene.mesh.corners[ground]][:, :, :2]
    plan = shapely.union_all(shapely.polygons(corners))
    feet = shapely.union_all([shapely.Polygon(h.footprint).buffer(1e-6) for h in scene.houses])
    for house in scene.houses:
        assert plan.intersection(shapely.Polygon(house.footprint).buffer(-0.15)).area < 1e-6
    assert plan.contains(feet.buffer(0.5).difference(feet))


def test_ten_houses_a_side_take_less_than_five_seconds() -> None:
    start = time.process_time()
    assert len(build_street(SceneSpec(seed=4, houses=10)).houses) == 20
    assert time.process_time() - start < 5.0
