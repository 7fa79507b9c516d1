"""Scenes built from city models keep the model's openings, add what it lacks, and get a street."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import shapely

from frontage.errors import OptionError
from frontage.geometry.arrays import Float
from frontage.io.citymodels.read import read_city_model
from frontage.model import CityBuilding, CityModel, Shell, Surface, WorldRef
from frontage.simulate.citymodel.scene import build_model_scene
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import FacadePlan, OpeningPlan, Part, Scene
from frontage.simulate.sensors.instrument import ScannerSpec
from frontage.simulate.sensors.positions import station_positions
from frontage.simulate.spec import SceneSpec, parse_spec
from frontage.simulate.street.build import build_street
from frontage.simulate.survey import ModelSpec, survey_model
from frontage.simulate.truth.solids import truth_solid
from frontage.studies.scenemodels import write_lod3
from realdata import data_path

SPEC = SceneSpec(seed=4, trees=0, cars=0, lamps=0, people=0)
WORLD = WorldRef(np.array([691_000, 5_336_000, 500]), "EPSG:25832")
WINDOW = np.array([[2.0, 0, 1.0], [3.2, 0, 1.0], [3.2, 0, 2.6], [2.0, 0, 2.6]])


def block(
    more: Sequence[Surface], front_holes: Sequence[Float] = (), installation: bool = False
) -> CityModel:
    """A house 10 m wide, 8 m deep, 6 m high, its front in the plane y = 0, with `more` polygons."""
    a, b, c, d = np.array([[0, 0, 0], [10, 0, 0], [10, 8, 0], [0, 8, 0]], float)
    up = np.array([0.0, 0.0, 6.0])
    sides = [np.array([p, q, q + up, p + up]) for p, q in ((a, b), (b, c), (c, d), (d, a))]
    holes = [tuple(h[::-1] for h in front_holes), (), (), ()]
    body = [Surface(r, "WallSurface", f"w{k}", holes[k]) for k, r in enumerate(sides)]
    body.append(Surface(np.array([a, d, c, b]), "GroundSurface", "g"))
    body.append(Surface(np.array([a, b, c, d]) + up, "RoofSurface", "r"))
    shells: tuple[Shell, ...]
    if installation:
        shells = (Shell("3", tuple(body)), Shell("3", tuple(more), part="i", installation=True))
    else:
        shells = (Shell("3", (*body, *more)),)
    return CityModel((CityBuilding("house", shells),), WORLD)


def back(ring: Float, by: float) -> Float:
    """The ring `by` m behind the front."""
    return np.add(ring, [0, by, 0])


def front(scene: Scene) -> FacadePlan:
    """The facade in the plane y = 0."""
    (found,) = [
        f
        for f in scene.houses[0].facades
        if abs(f.local_from_facade.t[1]) < 1e-6 and f.local_from_facade.R[1, 1] > 0.99
    ]
    return found


def local_ring(facade: FacadePlan, opening: OpeningPlan) -> Float:
    xyz = np.insert(opening.ring, 1, opening.wall_y, axis=1)
    return facade.local_from_facade.apply(xyz)


def part_along(scene: Scene, start: Sequence[float], way: Sequence[float]) -> tuple[Part, float]:
    """The part that a ray meets first, and the distance in metres."""
    hits = Tracer(scene.mesh).first_hit(np.array([start], float), np.array([way], float))
    assert hits.found[0]
    return Part(scene.parts[scene.mesh.surface[hits.triangle[0]]]), float(hits.distance[0])


@pytest.mark.parametrize("off", [0.0, 0.03, -0.03])
def test_a_window_on_a_wall_without_hole_is_cut_out_and_completed(off: float) -> None:
    scene = build_model_scene(SPEC, [block([Surface(back(WINDOW, off), "Window", "v")])])
    facade = front(scene)
    (opening,) = facade.openings
    assert np.abs(local_ring(facade, opening) - WINDOW).max() < 1e-6
    assert 0.04 < opening.depth < 0.31 and opening.shape == "rectangle" and opening.kind == "window"
    # through the pane, beside the bars, into a room; no wall and no model window is left before it
    at = opening.ring.min(0) + opening.frame_width + 0.05
    part, distance = part_along(scene, (at[0], -5.0, at[1]), (0, 1, 0))
    assert part == Part.PANE and distance == pytest.approx(5 + opening.glass_depth, abs=1e-6)
    part, distance = part_along(scene, (at[0], opening.glass_depth + 0.001, at[1]), (0, 1, 0))
    assert part == Part.ROOM
    part, distance = part_along(scene, (1.9, -5.0, 1.8), (0, 1, 0))
    assert part == Part.WALL and distance == pytest.approx(5.0)
    assert part_along(scene, (2.01, opening.depth / 2, 1.8), (-1, 0, 0))[0] == Part.REVEAL


def test_a_window_set_back_keeps_its_depth_and_its_hole() -> None:
    far = back(WINDOW, 0.17)
    after = (1, 2, 3, 0)
    sides = [np.array([WINDOW[k], WINDOW[n], far[n], far[k]]) for k, n in enumerate(after)]
    more = [Surface(far, "Window", "v")]
    more += [Surface(r, "WallSurface", f"s{k}") for k, r in enumerate(sides)]
    scene = build_model_scene(SPEC, [block(more, [WINDOW])])
    (opening,) = front(scene).openings
    assert opening.depth == pytest.approx(0.17, abs=1e-9)
    # the model's own reveal is replaced, not doubled
    assert sum(s.part == Part.WALL for s in scene.surfaces) == 4
    assert part_along(scene, (2.01, 0.1, 1.8), (-1, 0, 0))[0] == Part.REVEAL


def test_a_window_made_of_many_polygons_is_one_opening() -> None:
    half = np.array([[2.0, 0.1, 1.0], [2.6, 0.1, 1.0], [2.6, 0.1, 2.6], [2.0, 0.1, 2.6]])
    leaves = [Surface(half, "Window", "v"), Surface(np.add(half, [0.6, 0, 0]), "Window", "v#2")]
    scene = build_model_scene(SPEC, [block(leaves, [WINDOW])])
    (opening,) = front(scene).openings
    assert np.ptp(opening.ring, axis=0) == pytest.approx([1.2, 1.6])
    assert opening.depth == pytest.approx(0.1)


def test_a_door_at_the_foot_is_found_and_a_window_outside_of_walls_is_not() -> None:
    door = np.array([[5.0, 0, 0.0], [6.0, 0, 0.0], [6.0, 0, 2.1], [5.0, 0, 2.1]])
    astray = np.array([[2.0, -9, 1.0], [3.2, -9, 1.0], [3.2, -9, 2.6]])
    scene = build_model_scene(SPEC, [block([Surface(door, "Door", "d"), Surface(astray, "Window", "v")])])
    (opening,) = front(scene).openings
    assert opening.kind == "door" and not opening.glazed
    assert part_along(scene, (5.5, -5.0, 1.0), (0, 1, 0))[0] == Part.LEAF
    assert any("1 windows or doors lie in no wall" in note for note in scene.notes)


def test_an_installation_is_a_protrusion_of_its_facade() -> None:
    slab = np.array([[4.0, -1.2, 3.0], [7.0, -1.2, 3.0], [7.0, 0, 3.0], [4.0, 0, 3.0]])
    rail = np.array([[4.0, -1.2, 3.0], [7.0, -1.2, 3.0], [7.0, -1.2, 4.0], [4.0, -1.2, 4.0]])
    pieces = [Surface(slab, "RoofSurface", "a"), Surface(rail, "WallSurface", "b")]
    (found,) = front(build_model_scene(SPEC, [block(pieces, installation=True)])).protrusions
    assert found.y_range == pytest.approx((-1.2, 0.0))
    assert found.ring.min(0) == pytest.approx([4.0, 3.0]) and found.ring.max(0) == pytest.approx([7.0, 4.0])


def test_sensors_stand_on_free_ground_before_the_longest_facade() -> None:
    scene = build_model_scene(SPEC, [block([Surface(WINDOW, "Window", "v")])])
    spec = ScannerSpec.model_validate({"stations": 3})
    centres = np.array(station_positions(scene, spec, Tracer(scene.mesh)))
    assert (centres[:, 1] < -2.0).all() and (centres[:, 1] > -16.0).all()
    assert scene.houses[0].side == 0
    assert centres[:, 2] == pytest.approx(spec.height - 0.1, abs=0.2)


def test_the_simulators_own_lod3_comes_back_with_the_same_openings(tmp_path: Path) -> None:
    built = build_street(SceneSpec(seed=6, houses=2, opposite=False, trees=0, cars=0, lamps=0, people=0))
    write_lod3(tmp_path / "lod3.city.json", built)
    model = read_city_model(tmp_path / "lod3.city.json", built.world)
    again = build_model_scene(SPEC, [model])
    made = [(f, o) for h in again.houses for f in h.facades for o in f.openings]
    wanted = [(f, o) for h in built.houses for f in h.facades for o in f.openings]
    assert len(made) == len(wanted) > 10
    middles = np.array([local_ring(f, o).mean(0) for f, o in made])
    for facade, opening in wanted:
        ring = local_ring(facade, opening)
        other_facade, other = made[int(np.linalg.norm(middles - ring.mean(0), axis=1).argmin())]
        there = facade.local_from_facade.inverse.apply(local_ring(other_facade, other))
        assert np.abs(there[:, 1] - opening.wall_y).max() < 1e-3
        gap = shapely.hausdorff_distance(shapely.Polygon(opening.ring), shapely.Polygon(there[:, [0, 2]]))
        assert gap < 1e-3, opening.id
        assert other.depth == pytest.approx(opening.depth, abs=1e-3)
        assert other.shape == opening.shape


def test_the_same_model_and_seed_give_the_same_scene_and_another_seed_other_materials() -> None:
    model = block([Surface(WINDOW, "Window", "v")])
    first, again = build_model_scene(SPEC, [model]), build_model_scene(SPEC, [model])
    assert first.surfaces == again.surfaces and np.array_equal(first.mesh.vertices, again.mesh.vertices)
    other = build_model_scene(SPEC.model_copy(update={"seed": 5}), [model])
    assert other.materials != first.materials


def test_the_surveyed_model_of_a_model_scene_is_as_wrong_as_asked() -> None:
    scene = build_model_scene(SPEC, [block([Surface(WINDOW, "Window", "v")])])
    exact = ModelSpec(shift=0, building=0, corner=0, height=0, roof=0)
    (house,) = survey_model(scene, exact).buildings
    kinds = [s.semantics for s in house.surfaces]
    assert kinds.count("WallSurface") == 4 and {"GroundSurface", "RoofSurface"} < set(kinds)
    corners = np.concatenate([s.ring for s in house.surfaces])
    assert corners.min(0) == pytest.approx([0, 0, 0], abs=1e-9)
    assert corners.max(0) == pytest.approx([10, 8, 6], abs=1e-9)
    (off,) = survey_model(scene, ModelSpec(shift=0, building=0, corner=0.1, height=0, roof=0)).buildings
    moved = np.concatenate([s.ring for s in off.surfaces])
    assert 0.01 < np.abs(moved.max(0)[:2] - [10, 8]).max() < 0.5
    assert truth_solid(scene.houses[0], scene.world).faces


def test_specs_of_models_name_files_and_leave_houses_out() -> None:
    assert parse_spec('from_model = "a.gml"').from_model == ("a.gml",)
    assert parse_spec('from_model = ["a.gml", "b.gml"]').from_model == ("a.gml", "b.gml")
    with pytest.raises(
        OptionError, match="from_model brings its own houses and ground; leave out houses, slope"
    ):
        parse_spec('from_model = "a.gml"\nslope = 2\nhouses = 3')
    with pytest.raises(OptionError, match="no building of the model has a wall"):
        roof = Surface(WINDOW[:, [0, 2, 1]], "RoofSurface", "r")
        build_model_scene(SPEC, [CityModel((CityBuilding("x", (Shell("3", (roof,)),)),), WORLD)])


@pytest.mark.parametrize("version", ["CityGMLv2", "CityGMLv3"])
def test_the_example_house_has_two_windows_and_a_door(version: str) -> None:
    path = data_path(f"citymodels/lod_examples/{version}/Building_LOD3-EPSG25832.gml")
    scene = build_model_scene(SPEC, [read_city_model(path)])
    openings = [o for f in scene.houses[0].facades for o in f.openings]
    assert sorted(o.kind for o in openings) == ["door", "window", "window"]
    assert [o.depth for o in openings] == pytest.approx([0.1] * 3, abs=1e-3)
    sizes = sorted(tuple(np.ptp(o.ring, axis=0).round(3)) for o in openings)
    assert sizes == [(1.0, 2.0), (1.5, 1.0), (1.5, 1.0)]


def test_a_street_runs_along_a_front_that_bays_part() -> None:
    front = [(x, y) for a in (2, 6) for x, y in ((a, 0), (a, -1), (a + 2, -1), (a + 2, 0))]
    ground = np.array([(x, y, 0.0) for x, y in ((0, 0), *front, (10, 0), (10, 8), (0, 8))])
    up = np.array([0.0, 0.0, 6.0])
    sides = [np.array([p, q, q + up, p + up]) for p, q in zip(ground, np.roll(ground, -1, 0), strict=True)]
    faces = [Surface(r, "WallSurface", f"w{k}") for k, r in enumerate(sides)]
    faces += [Surface(ground[::-1], "GroundSurface", "g"), Surface(ground + up, "RoofSurface", "r")]
    faces += [Surface(np.add(WINDOW, [x, 0, 0]), "Window", f"v{x}") for x in (-1.6, 2.4, 6.4)]
    scene = build_model_scene(SPEC, [CityModel((CityBuilding("house", (Shell("3", tuple(faces)),)),), WORLD)])
    assert (scene.road[:, 1] < -1.0).all()


def test_real_houses_keep_their_windows_and_leave_room_for_a_street() -> None:
    for name in ("4018270", "4018150b", "4018115", "4018152b"):
        model = read_city_model(data_path(f"citymodels/ingolstadt_lod3/{name}.xml"))
        scene = build_model_scene(SPEC, [model])
        (building,) = model.buildings
        shells = [s for s in building.level() if not s.installation]
        objects = {
            s.about.get(f.source_id, {}).get("surface")
            for s in shells
            for f in s.surfaces
            if f.semantics in ("Window", "Door")
        }
        found = sum(len(f.openings) for f in scene.houses[0].facades)
        assert 0.95 * len(objects) <= found <= len(objects), name
        spec = ScannerSpec.model_validate({"stations": 2})
        assert len(station_positions(scene, spec, Tracer(scene.mesh))) == 2
        assert clear_share(scene) > 0.95, name


def clear_share(scene: Scene) -> float:
    """Share of the openings whose own pane, bar or leaf a ray from just in front of the wall meets."""
    tracer = Tracer(scene.mesh)
    met = []
    for f, facade in enumerate(scene.houses[0].facades):
        for o, opening in enumerate(facade.openings):
            at = opening.ring.min(0) + np.ptp(opening.ring, axis=0) * [0.37, 0.31]
            start = facade.local_from_facade.apply(np.array([[at[0], -0.01, at[1]]]))
            hits = tracer.first_hit(start, facade.local_from_facade.R[:, 1][None])
            seen = scene.surfaces[scene.mesh.surface[hits.triangle[0]]]
            met.append((seen.facade, seen.opening) == (f, o) and seen.part != Part.ROOM)
    return float(np.mean(met))
