"""Obstacles stand on the ground and outside of houses; trees let light through."""

from functools import lru_cache

import numpy as np
import pytest

pytest.importorskip("embreex")

from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import Part, Scene
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street


@lru_cache
def scene() -> Scene:
    return build_street(SceneSpec(seed=11, houses=4, setting="terrace", trees=5, cars=4, lamps=3, people=6))


def points_of(part: Part) -> np.ndarray:
    rows = scene().parts[scene().mesh.surface] == part
    return scene().local_from_street.inverse.apply(
        scene().mesh.vertices[np.unique(scene().mesh.corners[rows])]
    )


def names(part: Part) -> set[str]:
    return {s.id.split("/")[0] for s in scene().surfaces if s.part == part}


def test_obstacles_are_as_many_as_asked_for() -> None:
    counts = [len(names(p)) for p in (Part.TREE, Part.CAR, Part.LAMP, Part.PERSON)]
    assert counts == [5, 4, 3, 6]


@pytest.mark.parametrize("part", [Part.TREE, Part.CAR, Part.LAMP, Part.PERSON])
def test_obstacles_stand_between_the_building_lines_and_on_the_ground(part: Part) -> None:
    found = points_of(part)
    width = -2 * scene().local_from_street.inverse.apply(scene().road)[0, 1]
    assert found[:, 1].max() < -0.02 and found[:, 1].min() > -width + 0.02
    tracer = Tracer(scene().mesh, keep=scene().parts[scene().mesh.surface] == Part.GROUND)
    lowest = []
    for name in names(part):
        own = [k for k, s in enumerate(scene().surfaces) if s.id.startswith(f"{name}/")]
        rows = np.isin(scene().mesh.surface, own)
        v = scene().mesh.vertices[np.unique(scene().mesh.corners[rows])]
        foot = v[np.argsort(v[:, 2])[:4]]
        hits = tracer.first_hit(foot + np.array([0, 0, 5.0]), np.tile([0.0, 0.0, -1.0], (4, 1)))
        assert hits.found.all()
        lowest.append(float((5.0 - hits.distance).min()))
    assert np.abs(lowest).max() < 0.15


def test_crowns_are_porous() -> None:
    one = build_street(SceneSpec(seed=12, houses=1, trees=1, cars=0, lamps=0, people=0))
    leafy = [k for k, s in enumerate(one.surfaces) if s.id.endswith("/leaves")]
    rows = np.isin(one.mesh.surface, leafy)
    v = one.mesh.vertices[np.unique(one.mesh.corners[rows])]
    middle, spread = v.mean(0), v.std(0).mean()
    rng = np.random.default_rng(0)
    targets = middle + rng.uniform(-spread, spread, (4000, 3))
    origin = middle + one.local_from_street.rotate(np.array([[0.0, -20.0, 0.0]]))[0]
    hits = Tracer(one.mesh, keep=rows).first_hit(origin, targets - origin)
    assert 0.2 < hits.found.mean() < 0.9


def test_cars_lie_on_the_slope() -> None:
    steep = build_street(
        SceneSpec(seed=11, houses=3, setting="terrace", slope=8, trees=0, cars=3, lamps=0, people=0)
    )
    body = [k for k, s in enumerate(steep.surfaces) if s.id.endswith("/wheels")]
    for k in body:
        rows = steep.mesh.surface == k
        v = steep.local_from_street.inverse.apply(steep.mesh.vertices[np.unique(steep.mesh.corners[rows])])
        low = v[v[:, 2] - 0.08 * v[:, 0] < (v[:, 2] - 0.08 * v[:, 0]).min() + 0.03]
        assert np.polyfit(low[:, 0], low[:, 2], 1)[0] == pytest.approx(0.08, abs=0.02)


def test_hedges_leave_paths_to_the_doors() -> None:
    green = build_street(
        SceneSpec(seed=20, houses=3, setting="detached", hedges=True, trees=0, cars=0, lamps=0, people=0)
    )
    leaves = [k for k, s in enumerate(green.surfaces) if s.id.startswith("hedge")]
    assert len(leaves) == len(green.houses)
    tracer = Tracer(green.mesh, keep=np.isin(green.mesh.surface, leaves))
    across = 8.0  # m, further away stand the hedges opposite
    for house in green.houses:
        facade = house.facades[0]
        frame = facade.local_from_facade
        out = frame.rotate(np.array([[0.0, -1.0, 0.0]]))
        doors = [o for o in facade.openings if o.kind == "door" and o.floor == 0]
        x = np.concatenate([np.linspace(o.ring[:, 0].min(), o.ring[:, 0].max(), 9) for o in doors])
        z = np.interp(x, [0, np.ptp(facade.outline[:, 0])], facade.outline[:2, 1]) + 0.5
        from_door = frame.apply(np.column_stack([x, np.full(len(x), -0.5), z]))
        assert tracer.first_hit(from_door, np.repeat(out, len(x), 0)).distance.min() > across
        x = np.linspace(0, np.ptp(facade.outline[:, 0]), 80)
        z = np.interp(x, x[[0, -1]], facade.outline[:2, 1]) + 0.5
        along = frame.apply(np.column_stack([x, np.full(80, -0.5), z]))
        assert 0.1 < (tracer.first_hit(along, np.repeat(out, 80, 0)).distance < across).mean() < 0.95
