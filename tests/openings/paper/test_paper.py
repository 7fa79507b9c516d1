"""The published method, step by step, on walls whose points and openings are known."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.catalog import number_facade
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Facade, Failed, Layer, Scan, WorldRef
from frontage.model.opening import Elements
from frontage.openings.options import OpeningOptions
from frontage.openings.paper.availability import AvailabilityMap
from frontage.openings.paper.cells import FACADE, OUTSIDE, UNCERTAIN, WINDOW, classify, resolve_uncertain
from frontage.openings.paper.edges import edge_points, point_distance
from frontage.openings.paper.find import decompose, find_by_paper
from frontage.openings.paper.nouns import border_sigma

Box = tuple[float, float, float, float]
PITCH = 0.03
LEAST = (0.3, 0.3)
WIDTH, HEIGHT = 8.0, 6.0
OUTLINE = np.array([[0.0, 0.0], [WIDTH, 0.0], [WIDTH, HEIGHT], [0.0, HEIGHT]])
OPTIONS = OpeningOptions(method="paper")


def raster(box: Box = (0.0, 0.0, WIDTH, HEIGHT), pitch: float = PITCH, seed: int = 0) -> Float:
    """Points (n, 2) of a raster whose rows are not aligned with one another."""
    rng = np.random.default_rng(seed)
    z = np.arange(box[1] + pitch / 2, box[3], pitch)
    x = np.arange(box[0], box[2], pitch)
    phase = rng.uniform(0, pitch, len(z))
    xz = np.stack([x[None] + phase[:, None], np.broadcast_to(z[:, None], (len(z), len(x)))], -1).reshape(
        -1, 2
    )
    return xz[xz[:, 0] < box[2]] + rng.normal(0, 0.001, (int((xz[:, 0] < box[2]).sum()), 2))


def within(xz: Float, *boxes: Box) -> np.ndarray:
    mask = np.zeros(len(xz), bool)
    for x0, z0, x1, z1 in boxes:
        mask |= (xz[:, 0] > x0) & (xz[:, 0] < x1) & (xz[:, 1] > z0) & (xz[:, 1] < z1)
    return mask


def at(xz: Float, y: float, seed: int = 1) -> Float:
    """The points on a plane y, with 3 mm of noise."""
    return np.column_stack([xz[:, 0], y + np.random.default_rng(seed).normal(0, 0.003, len(xz)), xz[:, 1]])


def find(*parts: Float) -> Elements:
    """What the method finds among points in the facade frame, number_facade."""
    q = np.vstack(parts)
    world = WorldRef(np.array([500_000, 5_000_000, 100]))
    facade = Facade(
        "B01/F1", "B01", Estimate(Rigid3.identity("local", "facade"), np.eye(6) * 1e-8, 100.0), world,
        OUTLINE, (Layer(0.0, 0.001, 40.0, OUTLINE),), np.arange(len(q)),
        np.flatnonzero(np.abs(q[:, 1]) < 0.009), 0.003, PITCH, 1.0, "rays",
    )  # fmt: skip
    found = find_by_paper(facade, Scan("wall", q, world), OPTIONS)
    assert not isinstance(found, Failed), found
    elements, _ = found
    return replace(elements, openings=number_facade(facade.id, elements.openings))


def boxes_of(found: Elements) -> Float:
    return np.array([[*o.ring.min(0), *o.ring.max(0)] for o in found.openings])


GRID: list[Box] = [(x, z, x + 1.1, z + 1.6) for z in (0.9, 3.6) for x in (0.8, 3.4, 6.0)]


def test_the_point_distance_of_a_raster_is_its_pitch() -> None:
    assert point_distance(raster()) == pytest.approx(PITCH, rel=0.1)
    assert np.isnan(point_distance(raster()[:10]))


def test_edge_points_lie_at_the_border_of_their_type_and_nowhere_else() -> None:
    x = np.arange(40) / 32  # exact in binary: diagonals are diagonals
    grid = np.stack(np.meshgrid(x, x), -1).reshape(-1, 2)
    wall = grid[~within(grid, (0.36, 0.36, 0.77, 0.77))]  # columns and rows 12 to 24 are missing
    left, right, bottom, top = edge_points(wall, 2 / 32)
    side = x[13:24]  # next to the corners, the diagonal neighbour is there
    inner = wall[:, 0] < x[-1]
    assert sorted(wall[left & inner, 1]) == pytest.approx(side)
    assert wall[left & inner, 0] == pytest.approx(x[11])
    assert wall[right & (wall[:, 0] > 0), 0] == pytest.approx(x[25])
    assert wall[bottom & (wall[:, 1] < x[-1]), 1] == pytest.approx(x[11])
    assert wall[top & (wall[:, 1] > 0), 1] == pytest.approx(x[25])


def test_edge_points_do_not_depend_on_how_the_points_are_cut_into_strips(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    xz = raster()[~within(raster(), *GRID)]
    whole = edge_points(xz, 0.06)
    monkeypatch.setattr("frontage.openings.paper.edges._STRIP", 700)
    np.testing.assert_array_equal(edge_points(xz, 0.06), whole)


def test_a_grid_of_windows_is_found_within_the_point_distance() -> None:
    xz = raster()
    found = find(at(xz[~within(xz, *GRID)], 0.0))
    assert [o.id for o in found.openings] == [f"B01/F1/W{f}-{b}" for f in (0, 1) for b in (1, 2, 3)]
    error = boxes_of(found) - np.array(GRID)
    assert np.abs(error).max() <= PITCH + 0.004
    assert (error[:, :2] <= 0.004).all() and (error[:, 2:] >= -0.004).all()  # last wall points: never inside
    assert np.sqrt(np.mean(error**2)) == pytest.approx(border_sigma(PITCH), rel=0.35)
    sigma = np.sqrt(np.diag(found.openings[0].ring_covariance))
    assert sigma == pytest.approx(border_sigma(PITCH), rel=0.1)
    assert all(o.depth is None for o in found.openings) and len(found.notes) == 2


def test_borders_of_one_column_lie_in_one_partition_plane() -> None:
    xz = raster()
    got = boxes_of(find(at(xz[~within(xz, *GRID)], 0.0)))
    np.testing.assert_array_equal(got[:3, [0, 2]], got[3:, [0, 2]])
    np.testing.assert_array_equal(got[[0, 1], 1], got[[1, 2], 1])


def test_the_depth_plane_comes_from_points_on_the_crossbars() -> None:
    xz = raster()
    bars = [(x0, z, x1, z + 0.08) for x0, z0, x1, z1 in GRID for z in (z0 + 0.7,)]
    room = np.random.default_rng(3).uniform(0.3, 1.0, (400, 3)) * [7, 1, 5]
    found = find(at(xz[~within(xz, *GRID)], 0.0), at(xz[within(xz, *bars)], 0.14), room)
    assert len(found.openings) == 6
    for o in found.openings:
        assert o.depth is not None and abs(o.depth.value - 0.14) < 3 * o.depth.sigma[0] < 0.03


def test_the_map_counts_the_area_of_elements_that_a_plane_cuts() -> None:
    seen = AvailabilityMap.of(np.array([[0.5, 0.5]]), np.array([[0.0, 0], [3, 0], [3, 3], [0, 3]]), 1 / 1.5)
    share, within_outline = seen.share(np.array([0.0, 0.5, 3.0]), np.array([0.0, 1.0, 3.0]))
    np.testing.assert_allclose(share, [[1.0, 0.2], [0.0, 0.0]])
    np.testing.assert_allclose(within_outline, 1.0)


@pytest.mark.parametrize(
    ("share", "expected"),
    [(0.71, FACADE), (0.69, UNCERTAIN), (0.11, UNCERTAIN), (0.09, WINDOW), (np.nan, OUTSIDE)],
)
def test_cells_are_classed_at_70_and_10_percent(share: float, expected: int) -> None:
    ends = np.array([0.0, 1.0])
    assert classify(ends, ends, np.array([[share]]), np.array([[1.0]])).first[0, 0] == expected


def settled(rows: str, share: float = 0.3) -> list[str]:
    """Classes after the rules: "#" facade, "." window, "?" uncertain; rows from the top down."""
    first = np.array([["#.?".index(c) for c in row] for row in rows.split()], np.int8)
    return ["".join("#.?"[v] for v in row) for row in resolve_uncertain(first, np.full(first.shape, share))]


def test_an_uncertain_cell_between_two_windows_is_facade() -> None:
    assert settled("##### #.?.# #####")[1] == "#.#.#"
    assert [r[1] for r in settled("### #.# #?# #.# ###")] == list("#.#.#")


def test_an_uncertain_cell_beside_a_window_follows_the_windows_of_its_column() -> None:
    assert settled("#..# #### #.?# #### #..#", share=0.6)[2] == "#..#"
    assert settled("#.## #### #.?# #### #.##", share=0.2)[2] == "#.##"
    assert settled("#### #.?# ####", share=0.6)[1] == "#.##"  # none to follow: the nearer class
    assert settled("#### #.?# ####", share=0.2)[1] == "#..#"


def test_an_uncertain_cell_by_itself_is_a_window_only_where_row_and_column_have_some() -> None:
    assert settled("#.### ##### #?#.# #####", share=0.2)[2] == "#.#.#"
    assert settled("##### ##### #?#.# #####", share=0.2)[2] == "###.#"


def test_windows_are_convex() -> None:
    xz = raster()
    found = find(at(xz[~within(xz, (1, 1, 2, 3), (1, 1, 3, 2))], 0.0))  # an L
    got = boxes_of(found)
    assert len(got) >= 1 and all(len(o.ring) == 4 for o in found.openings)
    area = float(np.prod(got[:, 2:] - got[:, :2], axis=1).sum())
    assert 2.0 < area < 3.2  # parts that do not overlap


def test_two_close_windows_are_split_by_an_additional_facade_cell() -> None:
    xz = raster()
    pier = (2.98, 1.0, 3.05, 2.6)  # two or three points wide
    wall = xz[~within(xz, (1.9, 1.0, 4.1, 2.6)) | within(xz, pier)]
    assert len(find(at(wall, 0.0)).openings) == 2
    without = xz[~within(xz, (1.9, 1.0, 4.1, 2.6))]
    assert len(find(at(without, 0.0)).openings) == 1


def test_round_heads_are_curved_primitives() -> None:
    xz = raster(pitch=0.02)
    body = within(xz, (2.0, 0.0, 3.4, 2.0))
    arch = (np.hypot(xz[:, 0] - 2.7, xz[:, 1] - 2.0) < 0.7) & (xz[:, 1] >= 2.0)
    window = within(xz, (5.0, 1.0, 6.0, 2.4))
    door, other = sorted(find(at(xz[~(body | arch | window)], 0.0)).openings, key=lambda o: o.ring[0, 0])
    assert (door.kind, door.shape, other.kind, other.shape) == ("door", "round", "window", "rectangle")
    upper = door.ring[door.ring[:, 1] > 2.1]
    assert len(upper) > 8
    assert np.abs(np.hypot(upper[:, 0] - 2.7, upper[:, 1] - 2.0) - 0.7).max() < 0.05
    assert door.ring_covariance.shape == (2 * len(door.ring),) * 2


def test_protrusions_are_found_and_searched_again() -> None:
    xz = raster()
    bay, inner, outer = (3.0, 1.0, 6.0, 5.0), (4.0, 2.0, 5.0, 3.5), (1.0, 2.0, 2.0, 3.5)
    wall = at(xz[~within(xz, bay, outer)], 0.0)
    front = at(xz[within(xz, bay) & ~within(xz, inner)], -0.8)
    found = find(wall, front)
    (bay_found,) = found.protrusions
    assert np.abs(bay_found.ring.min(0) - bay[:2]).max() <= PITCH + 0.004
    assert np.abs(bay_found.ring.max(0) - bay[2:]).max() <= PITCH + 0.004
    assert bay_found.front.value == pytest.approx(-0.8, abs=0.002)
    got = boxes_of(found)[np.argsort(boxes_of(found)[:, 0])]
    np.testing.assert_allclose(got, [outer, inner], atol=PITCH + 0.004)


def test_a_blank_wall_has_no_opening() -> None:
    found = find(at(raster(), 0.0))
    assert not found.openings and not found.protrusions


def test_the_same_points_give_the_same_result() -> None:
    xz = raster()
    wall = at(xz[~within(xz, *GRID)], 0.0)
    first, second = find(wall), find(wall)
    for a, b in zip(first.openings, second.openings, strict=True):
        np.testing.assert_array_equal(a.ring, b.ring)


def test_a_facade_with_few_points_is_refused_in_one_sentence() -> None:
    world = WorldRef(np.zeros(3, np.int64))
    q = at(raster()[:30], 0.0)
    facade = Facade(
        "B01/F1", "B01", Estimate(Rigid3.identity("local", "facade"), np.eye(6), 1.0), world, OUTLINE, (),
        np.arange(30), np.arange(30), 0.003, PITCH, 0.1, "rays",
    )  # fmt: skip
    found = find_by_paper(facade, Scan("few", q, world), OPTIONS)
    assert isinstance(found, Failed) and "B01/F1 has 30 points" in found.message


def test_the_steps_can_be_drawn() -> None:
    """What the report draws like the paper's figures 6 and 7: edge points, lines, map and classes."""
    xz = raster()
    wall = xz[~within(xz, *GRID)]
    d = decompose(wall, OUTLINE, PITCH, LEAST)
    upright = {round(b.position, 1) for b in d.borders if b.upright}
    assert {0.8, 1.9, 3.4, 4.5, 6.0, 7.1} <= upright
    assert d.cells.final.shape == (len(d.cells.zs) - 1, len(d.cells.xs) - 1)
    assert set(np.unique(d.cells.final)) == {FACADE, WINDOW}
    assert d.edges.shape == (4, len(wall)) and d.seen.available.mean() > 0.7
