"""Rays find panes, leaves, frames and walls where the plans say."""

from functools import lru_cache

import numpy as np
import pytest

pytest.importorskip("embreex")

import shapely

from frontage.geometry.arrays import Array, Float
from frontage.simulate.meshing import inset
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import FacadePlan, OpeningPlan, Part, Scene
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street

SEEDS = (1, 2, 4, 7)


@lru_cache
def scene_of(seed: int) -> tuple[Scene, Tracer]:
    setting = "terrace" if seed % 2 else "detached"
    scene = build_street(
        SceneSpec(seed=seed, houses=2 + seed % 2, setting=setting, trees=0, cars=0, lamps=0, people=0)
    )
    return scene, Tracer(scene.mesh)


def openings(scene: Scene) -> list[tuple[FacadePlan, OpeningPlan]]:
    return [(f, o) for h in scene.houses for f in h.facades for o in f.openings]


def look(scene: Scene, tracer: Tracer, facade: FacadePlan, xz: Float, y: float) -> tuple[Array, Float]:
    """Part and y (facade frame) of what rays into the building meet, from points (n, 2) at depth y."""
    frame = facade.local_from_facade
    origins = frame.apply(np.column_stack([xz[:, 0], np.full(len(xz), y), xz[:, 1]]))
    into = np.broadcast_to(frame.rotate(np.array([[0.0, 1.0, 0.0]])), origins.shape)
    hits = tracer.first_hit(origins, into)
    assert hits.found.all()
    return scene.parts[scene.mesh.surface[hits.triangle]], y + hits.distance


def inside(ring: Float, margin: float, count: int, seed: int) -> Float:
    """Points (n, 2) in a ring, at least `margin` from its border."""
    low, high = ring.min(0), ring.max(0)
    xz = np.random.default_rng(seed).uniform(low, high, (count, 2))
    area = shapely.Polygon(ring).buffer(-margin)
    return np.asarray(xz[shapely.contains_xy(area, xz[:, 0], xz[:, 1])])


@pytest.mark.parametrize("seed", SEEDS)
def test_through_an_opening_rays_find_pane_bars_or_leaf_at_the_planned_depth(seed: int) -> None:
    scene, tracer = scene_of(seed)
    for k, (facade, plan) in enumerate(openings(scene)):
        light = inset(plan.ring, plan.frame_width)
        part, y = look(scene, tracer, facade, inside(light, 0.002, 60, k), plan.wall_y - 0.25)
        depth = y - plan.wall_y
        if plan.shutters == "closed":
            assert set(part) == {Part.SHUTTER}
            np.testing.assert_allclose(depth, 0.01, atol=1e-6)
        elif plan.glazed:
            assert set(part) <= {Part.PANE, Part.BAR}, plan.id
            np.testing.assert_allclose(depth[part == Part.PANE], plan.glass_depth, atol=1e-6)
            bars = depth[part == Part.BAR]
            assert ((bars > plan.depth) & (bars < plan.glass_depth)).all()
        else:
            assert set(part) == {Part.LEAF}
            assert ((depth > plan.depth) & (depth < plan.depth + 0.03)).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_bars_cover_exactly_their_planned_area(seed: int) -> None:
    scene, tracer = scene_of(seed)
    seen = 0
    for k, (facade, plan) in enumerate(openings(scene)):
        if not plan.glazed or plan.shutters == "closed":
            continue
        xz = inside(inset(plan.ring, plan.frame_width), 0.002, 80, k)
        part, _ = look(scene, tracer, facade, xz, plan.wall_y - 0.25)
        covered = np.zeros(len(xz), bool)
        border = np.zeros(len(xz), bool)
        for bar in plan.bars:
            along, across = (xz[:, 1], xz[:, 0]) if bar.axis == "vertical" else (xz[:, 0], xz[:, 1])
            side = np.abs(across - bar.position) - bar.width / 2
            end = np.maximum(bar.extent[0] - along, along - bar.extent[1])
            covered |= (side < 0) & (end < 0)
            border |= (np.abs(side) < 1e-6) | ((side < 0) & (np.abs(end) < 1e-6))
        np.testing.assert_array_equal((part == Part.BAR)[~border], covered[~border])
        seen += int(covered.sum())
    assert seen > 50


@pytest.mark.parametrize("seed", SEEDS)
def test_between_the_hole_and_the_light_stands_the_frame(seed: int) -> None:
    scene, tracer = scene_of(seed)
    for facade, plan in openings(scene):
        if plan.shutters == "closed":
            continue
        middle = inset(plan.ring, plan.frame_width / 2)
        part, y = look(scene, tracer, facade, middle, plan.wall_y - 0.25)
        assert set(part) == {Part.FRAME}, plan.id
        np.testing.assert_allclose(y - plan.wall_y, plan.depth, atol=1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_beside_the_hole_stands_the_wall_or_what_is_fixed_to_it(seed: int) -> None:
    scene, tracer = scene_of(seed)
    plain = 0
    for facade, plan in openings(scene):
        part, y = look(scene, tracer, facade, inset(plan.ring, -0.004), plan.wall_y - 0.25)
        assert (y <= plan.wall_y + 1e-6).all(), plan.id
        wall = Part.WALL if plan.wall_y == 0 else Part.ORIEL
        np.testing.assert_allclose(y[part == wall], plan.wall_y, atol=1e-6)
        plain += int((part == wall).sum())
    assert plain > 20


@pytest.mark.parametrize("seed", SEEDS)
def test_behind_every_pane_lies_a_room(seed: int) -> None:
    scene, tracer = scene_of(seed)
    for k, (facade, plan) in enumerate(openings(scene)):
        if not plan.glazed:
            continue
        xz = inside(inset(plan.ring, plan.frame_width), 0.01, 40, k)
        behind = plan.wall_y + plan.glass_depth + 0.001
        part, y = look(scene, tracer, facade, xz, behind)
        house = next(h for h in scene.houses if facade in h.facades)
        sill = facade.local_from_facade.apply(np.array([[0.0, 0.0, plan.ring[:, 1].min()]]))[0, 2]
        if sill > house.eaves_z:  # a gable's window looks into the roof
            assert Part.PANE not in part
        else:  # into a room, or through it and out of another window
            assert set(part) <= {Part.ROOM, Part.BAR, Part.PANE, Part.FRAME}, plan.id
            assert len(house.facades) > 1 or Part.PANE not in part
        assert (y[part == Part.ROOM] > plan.wall_y + plan.depth).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_the_main_wall_lies_in_the_plane_of_its_frame(seed: int) -> None:
    scene, _ = scene_of(seed)
    for h, house in enumerate(scene.houses):
        for f, facade in enumerate(house.facades):
            own = [
                k
                for k, s in enumerate(scene.surfaces)
                if (s.house, s.facade, s.part) == (h, f, Part.WALL) and s.opening == -1
            ]
            corners = scene.mesh.corners[np.isin(scene.mesh.surface, own)]
            y = facade.local_from_facade.inverse.apply(scene.mesh.vertices[np.unique(corners)])[:, 1]
            assert len(y) and np.abs(y).max() < 1e-9
