"""`find_buildings` divides a street into its houses, and no point is lost."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.buildings import BuildingOptions, BuildingSplit, find_buildings
from frontage.model import Scan, WorldRef
from one_house import KINDS, Kind, one_house
from scenes import CAR, FACADE, GROUND, TREE, Scene, street_scene, wall_scene

WORLD = WorldRef((0, 0, 0))


@pytest.fixture(scope="module")
def street() -> Scene:
    return street_scene(seed=3, houses=4, spacing=0.06)


@pytest.fixture(scope="module")
def split(street: Scene) -> BuildingSplit:
    return find_buildings(street.scan)


def labels(split: BuildingSplit, n: int) -> np.ndarray:
    out = np.full(n, -1)
    for i, building in enumerate(split.buildings):
        out[building.index] = i
    return out


def best_iou(split: BuildingSplit, scene: Scene) -> np.ndarray:
    """Returns the best IoU of every true house's facade points with those of a building."""
    found = labels(split, len(scene.scan))
    facade = scene.label == FACADE
    out = []
    for house in range(len(scene.houses)):
        true = facade & (scene.house == house)
        out.append(
            max(
                (
                    (true & (found == b)).sum() / (facade & (true | (found == b))).sum()
                    for b in range(len(split.buildings))
                ),
                default=0.0,
            )
        )
    return np.array(out)


def test_every_point_belongs_to_exactly_one_class(street: Scene, split: BuildingSplit) -> None:
    parts = [b.index for b in split.buildings] + [split.ground, split.occluders, split.rest]
    assert np.array_equal(np.sort(np.concatenate(parts)), np.arange(len(street.scan)))


def test_a_terrace_is_cut_into_its_houses(street: Scene, split: BuildingSplit) -> None:
    assert len(split.buildings) == len(street.houses)
    assert best_iou(split, street).min() > 0.9
    assert [b.id for b in split.buildings] == ["B01", "B02", "B03", "B04"]


def test_connected_components_do_not_divide_a_terrace(street: Scene) -> None:
    paper = find_buildings(street.scan, BuildingOptions(method="paper"))
    assert best_iou(paper, street).min() < 0.75


def test_trees_and_cars_are_occluders_and_the_street_is_ground(street: Scene, split: BuildingSplit) -> None:
    n = len(street.scan)
    occluder, ground, building = np.zeros(n, bool), np.zeros(n, bool), labels(split, n) >= 0
    occluder[split.occluders] = True
    ground[split.ground] = True
    assert occluder[street.label == TREE].mean() > 0.9
    assert building[street.label == CAR].mean() < 0.05
    assert ground[street.label == GROUND].mean() > 0.97
    assert building[street.label == FACADE].mean() > 0.95


@pytest.mark.parametrize("slope", [0.01, 0.08])
def test_slopes_are_ground(slope: float) -> None:
    scene = street_scene(seed=5, houses=3, spacing=0.08, slope=slope)
    split = find_buildings(scene.scan)
    ground = np.zeros(len(scene.scan), bool)
    ground[split.ground] = True
    assert ground[scene.label == GROUND].mean() > 0.95
    assert ground[scene.label == FACADE].mean() < 0.05


def test_both_sides_of_the_street_are_separate_buildings() -> None:
    scene = street_scene(seed=2, houses=2, spacing=0.08, both_sides=True, trees=False, cars=False)
    found = labels(find_buildings(scene.scan), len(scene.scan))
    side = np.array([h.s0 for h in scene.houses])
    facade = scene.label == FACADE
    across = {frozenset(np.unique(found[facade & (scene.house == h)])) for h in range(len(side))}
    owners = [set(np.unique(found[facade & (scene.house == h)])) - {-1} for h in range(len(side))]
    frames = [h.local_from_facade.R[:, 1] for h in scene.houses]
    for i, a in enumerate(frames):
        for j, b in enumerate(frames[:i]):
            if a @ b < 0:
                assert not owners[i] & owners[j]
    assert len(across) >= 2


def test_the_same_cloud_gives_the_same_split(street: Scene, split: BuildingSplit) -> None:
    again = find_buildings(street.scan)
    assert [b.index.tobytes() for b in again.buildings] == [b.index.tobytes() for b in split.buildings]
    assert again.occluders.tobytes() == split.occluders.tobytes()


@pytest.mark.parametrize(("turn", "shift"), [(0.7, (0, 0, 0)), (2.4, (-310.3, 47.7, 12.1))])
def test_a_rotated_and_shifted_world_gives_the_same_houses(
    street: Scene, turn: float, shift: tuple[float, ...]
) -> None:
    c, s = np.cos(turn), np.sin(turn)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    scan = street.scan
    moved = Scan(
        "turned",
        scan.xyz @ R.T + shift,
        scan.world,
        scan.origins @ R.T + shift,
        scan.origin_index,
        rgb=scan.rgb,
    )
    result = find_buildings(moved)
    assert best_iou(result, street).min() > 0.85


def test_a_wall_cut_out_without_ground_loses_nothing() -> None:
    scene = wall_scene(seed=0)
    keep = scene.label == FACADE
    split = find_buildings(scene.scan.take(keep))
    assert len(split.buildings) == 1
    assert len(split.buildings[0].index) == keep.sum()
    assert any("no ground" in note for note in split.notes)


def test_thirty_points_are_not_a_building() -> None:
    xyz = np.random.default_rng(0).normal(size=(30, 3))
    split = find_buildings(Scan("tiny.laz", xyz, WORLD))
    assert not split.buildings
    assert "30 points" in split.notes[0]


def test_flat_ground_is_not_a_building() -> None:
    rng = np.random.default_rng(0)
    xyz = np.column_stack([rng.uniform(0, 20, (20_000, 2)), rng.normal(0, 0.01, 20_000)])
    split = find_buildings(Scan("flat.laz", xyz, WORLD))
    assert not split.buildings
    assert len(split.ground) > 19_000
    assert any("no building" in note for note in split.notes)


@pytest.mark.parametrize("kind", KINDS)
def test_a_wide_house_is_not_cut(kind: Kind) -> None:
    scene = one_house(kind, seed=4)
    split = find_buildings(scene.scan)
    assert len(split.buildings) == 1
    found = labels(split, len(scene.scan))
    assert (found[scene.label == FACADE] == 0).mean() > 0.95


def test_a_wide_middle_of_another_colour_is_a_house_of_its_own() -> None:
    """A piece 8 m wide of another colour is a neighbour, even between equal flanks."""
    scene = one_house("attic", seed=4)
    rgb = np.array(scene.scan.rgb)
    middle = scene.house == 1
    rgb[middle] = (rgb[middle] * [0.55, 0.8, 1.2]).clip(0, 255).astype(np.uint8)
    split = find_buildings(replace(scene.scan, rgb=rgb))
    assert len(split.buildings) == 3
    assert best_iou(split, scene).min() > 0.9
