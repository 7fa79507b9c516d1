"""The street is divided into its houses, and nothing is lost."""

import json
from dataclasses import replace

import numpy as np
import pytest

from frontage.buildings import BuildingOptions, BuildingSplit, find_buildings
from frontage.io.scans.read import read_scans
from frontage.model import Scan, WorldRef
from frontage.model.scan import merge_scans
from frontage.simulate.scene import Part
from realdata import data_path
from scanned_streets import ScannedStreet, terrace
from wide_houses import KINDS, Kind, wide_house

WORLD = WorldRef((0, 0, 0))


@pytest.fixture(scope="module")
def split(street: ScannedStreet) -> BuildingSplit:
    return find_buildings(street.scan)


def labels(split: BuildingSplit, n: int) -> np.ndarray:
    out = np.full(n, -1)
    for i, building in enumerate(split.buildings):
        out[building.index] = i
    return out


def best_iou(split: BuildingSplit, scene: ScannedStreet) -> np.ndarray:
    """The best IoU of the points on each true street front with those of a found building."""
    found = labels(split, len(scene.scan))
    out = []
    for house in range(len(scene.houses)):
        true, best = scene.front_of(house), 0.0
        for b in range(len(split.buildings)):
            both = scene.front & (true | (found == b))
            best = max(best, (true & (found == b)).sum() / both.sum())
        out.append(best)
    return np.array(out)


def test_every_point_has_exactly_one_place(street: ScannedStreet, split: BuildingSplit) -> None:
    parts = [b.index for b in split.buildings] + [split.ground, split.occluders, split.rest]
    assert np.array_equal(np.sort(np.concatenate(parts)), np.arange(len(street.scan)))


def test_a_terrace_is_cut_into_its_houses(street: ScannedStreet, split: BuildingSplit) -> None:
    assert len(split.buildings) == len(street.houses)
    assert best_iou(split, street).min() > 0.9
    assert [b.id for b in split.buildings] == ["B01", "B02", "B03", "B04"]


def test_the_papers_components_leave_the_terrace_in_one_piece(street: ScannedStreet) -> None:
    paper = find_buildings(street.scan, BuildingOptions(method="paper"))
    assert best_iou(paper, street).min() < 0.75


def test_trees_and_cars_are_occluders_and_the_street_is_ground(
    street: ScannedStreet, split: BuildingSplit
) -> None:
    n = len(street.scan)
    occluder, ground, building = np.zeros(n, bool), np.zeros(n, bool), labels(split, n) >= 0
    occluder[split.occluders] = True
    ground[split.ground] = True
    assert occluder[street.part == Part.TREE].mean() > 0.9
    assert building[street.part == Part.CAR].mean() < 0.05
    assert ground[street.part == Part.GROUND].mean() > 0.97
    assert building[street.front].mean() > 0.95


@pytest.mark.parametrize("percent", [1.0, 8.0])
def test_slopes_stay_ground(percent: float) -> None:
    scene = terrace(seed=5, houses=3, slope=percent)
    split = find_buildings(scene.scan)
    ground = np.zeros(len(scene.scan), bool)
    ground[split.ground] = True
    assert ground[scene.part == Part.GROUND].mean() > 0.95
    assert ground[scene.front].mean() < 0.05


def test_both_sides_of_the_street_stay_apart() -> None:
    scene = terrace(seed=2, houses=2, obstacles=False, opposite=True)
    found = labels(find_buildings(scene.scan), len(scene.scan))
    owners = [set(found[scene.front_of(h)]) - {-1} for h in range(len(scene.houses))]
    near, far = (set().union(*(o for o, h in zip(owners, scene.houses, strict=True) if h.side == side))
                 for side in (0, 1))  # fmt: skip
    assert near and far and not near & far


def test_the_same_cloud_gives_the_same_split(street: ScannedStreet, split: BuildingSplit) -> None:
    again = find_buildings(street.scan)
    assert [b.index.tobytes() for b in again.buildings] == [b.index.tobytes() for b in split.buildings]
    assert again.occluders.tobytes() == split.occluders.tobytes()


def test_neither_order_nor_direction_nor_handedness_changes_the_split(
    street: ScannedStreet, split: BuildingSplit
) -> None:
    c, s = np.cos(0.6), np.sin(0.6)
    scan, order = street.scan, np.random.default_rng(3).permutation(len(street.scan))
    for axes in (np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]), np.diag([-1.0, 1.0, 1.0])):
        xyz, origins = scan.xyz[order] @ axes.T, scan.origins @ axes.T
        moved = Scan("moved", xyz, scan.world, origins, scan.origin_index[order], rgb=scan.rgb[order])
        found = [set(order[b.index]) for b in find_buildings(moved).buildings]
        if axes[0, 0] < 0:
            found.reverse()  # from left to right
        same = [len(a & set(b.index)) / len(b.index) for a, b in zip(found, split.buildings, strict=True)]
        assert min(same) > 0.9999


@pytest.mark.parametrize(("turn", "shift"), [(0.7, (0, 0, 0)), (2.4, (-310.3, 47.7, 12.1))])
def test_a_turned_and_shifted_world_gives_the_same_houses(
    street: ScannedStreet, turn: float, shift: tuple[float, ...]
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


def test_a_wall_cut_out_without_ground_loses_nothing(street: ScannedStreet) -> None:
    keep = street.front_of(1)
    split = find_buildings(street.scan.take(keep))
    assert len(split.buildings) == 1
    assert len(split.buildings[0].index) == keep.sum()
    assert any("no ground" in note for note in split.notes)


def test_thirty_points_are_no_building() -> None:
    xyz = np.random.default_rng(0).normal(size=(30, 3))
    split = find_buildings(Scan("tiny.laz", xyz, WORLD))
    assert not split.buildings
    assert "30 points" in split.notes[0]


def test_a_flat_ground_is_no_building() -> None:
    rng = np.random.default_rng(0)
    xyz = np.column_stack([rng.uniform(0, 20, (20_000, 2)), rng.normal(0, 0.01, 20_000)])
    split = find_buildings(Scan("flat.laz", xyz, WORLD))
    assert not split.buildings
    assert len(split.ground) > 19_000
    assert any("no building" in note for note in split.notes)


@pytest.mark.parametrize("kind", KINDS)
def test_a_wide_house_is_not_shredded(kind: Kind) -> None:
    scene = wide_house(kind, seed=4)
    split = find_buildings(scene.scan)
    assert len(split.buildings) == 1
    found = labels(split, len(scene.scan))
    assert (found[scene.front] == 0).mean() > 0.95


@pytest.mark.parametrize("seed", [8402, 8408])
def test_a_middle_with_an_attic_is_no_house_where_the_line_of_the_front_runs_askew(seed: int) -> None:
    # a line fitted through three planes turns by up to two degrees from all of them
    assert len(find_buildings(wide_house("attic", seed).scan).buildings) == 1


def test_other_relief_and_other_heights_of_windows_alone_part_no_front() -> None:
    # a crop of an apartment house with trees before its lower storeys was cut through a column of windows
    truth = json.loads(data_path("truth/manhattan_apartment.json").read_text("utf-8"))
    scan = merge_scans(read_scans(data_path("manhattan_apartment/street_front.laz")))
    axes, origin = np.array(truth["frame"]["axes_rows_XYZ"]), np.array(truth["frame"]["origin"])
    x, _, z = ((scan.world.to_world(scan.xyz) - origin) @ axes.T).T
    piece = scan.take(np.flatnonzero((x > -4.564) & (x < 27.03) & (z < 3.39)))
    assert len(find_buildings(piece).buildings) == 1


def test_a_middle_of_another_colour_and_height_is_a_house() -> None:
    """The counterpart: between equal flanks too, a piece 8 m wide of another colour is the neighbour's."""
    scene = wide_house("attic", seed=4)
    rgb = np.array(scene.scan.rgb)
    middle = scene.house == 1
    rgb[middle] = (rgb[middle] * [0.55, 0.8, 1.2]).clip(0, 255).astype(np.uint8)
    split = find_buildings(replace(scene.scan, rgb=rgb))
    assert len(split.buildings) == 3
    assert best_iou(split, scene).min() > 0.9


def test_a_side_wall_whose_first_metres_the_front_takes_is_no_house_of_its_own() -> None:
    rng = np.random.default_rng(0)

    def wall(start: tuple[float, float], end: tuple[float, float], count: int) -> np.ndarray:
        along = rng.random((count, 1))
        plan = np.array(start) + along * (np.array(end) - np.array(start))
        return np.column_stack([plan + rng.normal(0.0, 0.005, (count, 2)), rng.uniform(0.0, 10.0, count)])

    front, side = wall((0.0, 0.0), (20.0, 0.0), 60000), wall((20.0, 0.0), (21.6, 12.0), 30000)
    plan = rng.uniform((-5.0, -15.0), (40.0, 15.0), (40000, 2))
    street = plan[(plan[:, 1] < -0.1) | (plan[:, 0] > 20.1 + 0.14 * plan[:, 1])]
    ground = np.column_stack([street, rng.normal(0.0, 0.01, len(street))])
    found = find_buildings(Scan("corner", np.vstack([front, side, ground]), WORLD))
    assert len(found.buildings) == 1
    assert len(found.buildings[0].index) > 0.95 * (len(front) + len(side))


def test_a_column_of_wide_windows_does_not_part_a_house() -> None:
    rng = np.random.default_rng(0)
    wall = np.column_stack([rng.uniform(0, 24, 70000), rng.normal(0, 0.005, 70000), rng.uniform(0, 7, 70000)])
    low, high = np.array([0.8, 4.0]), np.array([2.8, 6.0])  # of two windows, one above the other
    in_window = ((wall[:, 2, None] > low) & (wall[:, 2, None] < high)).any(1)
    wall = wall[~(in_window & (np.abs(wall[:, 0] - 11.0) < 1.45))]
    plan = rng.uniform((-5.0, -15.0), (30.0, -0.1), (30000, 2))
    ground = np.column_stack([plan, rng.normal(0.0, 0.01, len(plan))])
    found = find_buildings(Scan("wide windows", np.vstack([wall, ground]), WORLD))
    assert len(found.buildings) == 1


def test_a_storey_that_is_mostly_glass_is_a_building() -> None:
    rng = np.random.default_rng(0)
    x, y, z = rng.uniform(0, 9, 60000), rng.normal(0, 0.005, 60000), rng.uniform(0, 4.2, 60000)
    wall = np.column_stack([x, y, z])
    glass = (np.abs(x - 4.5) < 4.2) & (z > 0.9) & (z < 3.0)
    plan = rng.uniform((-5.0, -12.0), (14.0, -0.1), (30000, 2))
    ground = np.column_stack([plan, rng.normal(0.0, 0.01, len(plan))])
    found = find_buildings(Scan("pavilion", np.vstack([wall[~glass], ground]), WORLD))
    assert len(found.buildings) == 1
    assert len(found.buildings[0].index) > 0.9 * (~glass).sum()


@pytest.mark.parametrize("lintel", [True, False])
def test_a_front_goes_on_below_a_lintel_however_wide_the_opening_is(lintel: bool) -> None:
    rng = np.random.default_rng(0)
    x, y, z = rng.uniform(0, 30, 90000), rng.normal(0, 0.005, 90000), rng.uniform(0, 10.0, 90000)
    wall = np.column_stack([x, y, z])
    glass = (np.abs(x - 15.0) < 3.5) & (z > 1.0) & ((z < 8.6) | (not lintel))
    plan = rng.uniform((-5.0, -12.0), (35.0, -0.1), (30000, 2))
    ground = np.column_stack([plan, rng.normal(0.0, 0.01, len(plan))])
    found = find_buildings(Scan("hall", np.vstack([wall[~glass], ground]), WORLD))
    assert len(found.buildings) == (1 if lintel else 2)
    if lintel:
        assert len(found.buildings[0].index) > 0.95 * (~glass).sum()
