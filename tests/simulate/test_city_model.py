"""The surveyed city model and the true LoD3 solids are closed, and their errors are those asked for."""

from collections import Counter
from collections.abc import Iterable, Sequence
from functools import lru_cache

import numpy as np
import pytest

from frontage.geometry.arrays import Float
from frontage.geometry.ring import ring_area
from frontage.model import Polygons, Shape, Solid
from frontage.simulate.scene import House, Scene
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street
from frontage.simulate.survey import ModelSpec, survey_model
from frontage.simulate.truth.solids import GRID, truth_solid
from frontage.validation.validate import validate, validate_shape

EXACT = ModelSpec(shift=0, building=0, corner=0, height=0, roof=0)


@lru_cache
def scenes() -> tuple[Scene, ...]:
    return tuple(
        build_street(SceneSpec(seed=seed, houses=5, trees=0, cars=0, lamps=0, people=0)) for seed in (1, 3, 8)
    )


def unmatched(rings: Iterable[Sequence[object]]) -> int:
    """Directed edges that do not have exactly one opposite edge."""
    edges = Counter((a, b) for r in rings for a, b in zip(r, [*r[1:], r[0]], strict=True))
    return sum(n != 1 or edges[b, a] != 1 for (a, b), n in edges.items())


def fan_volume(rings: Iterable[Float]) -> float:
    return sum(float(r[0] @ np.cross(r[k], r[k + 1])) / 6 for r in rings for k in range(1, len(r) - 1))


def off_plane(ring: Float) -> float:
    return float(np.linalg.svd(ring - ring.mean(0))[1][2]) if len(ring) > 3 else 0.0


def test_model_buildings_are_closed_upright_and_plane() -> None:
    for scene in scenes():
        for building in survey_model(scene, ModelSpec(corner=0.1)).buildings:
            rings = [s.ring for s in building.surfaces]
            assert unmatched([tuple(map(tuple, r.round(7))) for r in rings]) == 0
            assert fan_volume(r - rings[0][0] for r in rings) > 50
            assert max(off_plane(r) for r in rings) < 1e-3
            for s in building.surfaces:
                normal = np.cross(s.ring, np.roll(s.ring, -1, 0)).sum(0)
                upright = abs(normal[2]) / np.linalg.norm(normal)
                assert upright < 1e-6 if s.semantics == "WallSurface" else upright > 0.2
            assert ring_area(building.footprint) > 0


def test_a_model_without_errors_is_the_upright_house() -> None:
    scene = scenes()[0]
    model = survey_model(scene, EXACT)
    for house, building in zip(scene.houses, model.buildings, strict=True):
        top = max(float(s.ring[:, 2].max()) for s in building.surfaces)
        assert (building.id, building.address) == (house.id, house.address)
        assert top == pytest.approx(house.ridge_z) and ring_area(building.footprint) == pytest.approx(
            ring_area(house.footprint), rel=1e-3
        )
        foot = house.facades[0].local_from_facade.t
        nearest = np.min([np.linalg.norm(s.ring - foot, axis=1).min() for s in building.surfaces])
        assert nearest < 1e-9


def test_errors_are_as_large_as_asked_and_partly_common() -> None:
    scene = build_street(SceneSpec(seed=2, houses=12, trees=0, cars=0, lamps=0, people=0, setting="terrace"))
    true, wrong = (
        survey_model(scene, s, 5) for s in (EXACT, ModelSpec(shift=0.5, building=0.2, corner=0.05))
    )
    corners = np.array(
        [w.footprint - t.footprint for t, w in zip(true.buildings, wrong.buildings, strict=True)]
    )
    own = corners.mean(1)
    np.testing.assert_allclose(own.mean(0), wrong.shift[:2], atol=4 * 0.2 / np.sqrt(24))
    assert 0.13 < np.std(own, axis=0).mean() < 0.28
    assert 0.035 < np.std(corners - own[:, None], axis=(0, 1)).mean() < 0.065
    assert np.array_equal(wrong.shift, survey_model(scene, ModelSpec(shift=0.5), 5).shift)


def solid_rings(solid: Solid) -> list[tuple[int, ...]]:
    return [r for f in solid.faces for r in (f.ring, *f.holes)]


def true_volume(house: House) -> float:
    """The volume of the shell without the recesses, plus that of the oriels."""
    shell = fan_volume(ring for _, ring in house.shell)
    for facade in house.facades:
        for opening in facade.openings:
            shell -= ring_area(opening.ring) * opening.depth
        for p in facade.protrusions:
            if p.kind == "oriel" and p.front is not None:
                (a, b), depth = (ring_area(r) for r in (p.ring, p.front)), -p.y_range[0]
                shell += (a + b) / 2 * depth  # sides are straight in plan: exact for a trapezium
    return shell


def test_lod3_solids_are_closed_and_have_exactly_their_volume() -> None:
    for scene in scenes():
        for house in scene.houses:
            solid = truth_solid(house, scene.world)
            assert unmatched(solid_rings(solid)) == 0, house.id
            vertices = solid.vertices / GRID
            centre = vertices.mean(0)
            volume = fan_volume(vertices[list(r)] - centre for r in solid_rings(solid))
            reference = true_volume(house)
            assert volume == pytest.approx(reference, abs=0.05), house.id


def test_lod3_solids_name_every_opening_once() -> None:
    for scene in scenes():
        for house in scene.houses:
            solid = truth_solid(house, scene.world)
            kinds = {f.opening: f.semantics for f in solid.faces if f.opening}
            plans = {o.id: o.kind for f in house.facades for o in f.openings}
            assert len([f for f in solid.faces if f.opening]) == len(plans) and set(kinds) == set(plans)
            for name, kind in plans.items():
                assert (kinds[name] == "Door") == (kind in ("door", "passage", "garage"))


def test_lod3_faces_are_plane() -> None:
    scene = scenes()[1]
    for house in scene.houses[:3]:
        solid = truth_solid(house, scene.world)
        assert max(off_plane(solid.vertices[list(f.ring)] / GRID) for f in solid.faces) < 5e-4


def test_solids_and_city_model_are_valid_by_iso_19107() -> None:
    scene = scenes()[2]
    for house, building in list(zip(scene.houses, survey_model(scene, ModelSpec()).buildings, strict=True))[
        :4
    ]:
        assert validate(truth_solid(house, scene.world)) == ()
        faces = Polygons.of([[s.ring] for s in building.surfaces])
        assert validate_shape(Shape("Solid", ((faces,),))) == ()
