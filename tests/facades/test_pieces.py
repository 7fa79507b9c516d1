"""Every place of a front belongs to one of its planes, and none is lost between them."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.facades.build import wall_spacing
from frontage.facades.candidate import FacadeCandidate
from frontage.facades.cells import CellMap
from frontage.facades.cloud import Slab
from frontage.facades.pieces import without_overlaps
from frontage.facades.plane.wall import WallPlane
from frontage.facades.street import StreetSide

CELL = 0.1


def _candidate(y: float, wall: np.ndarray) -> FacadeCandidate:
    """Returns a candidate in the plane y m, with `wall` (h, w) in an outline over all cells."""
    z, x = CELL * (np.argwhere(wall) + 0.5).T
    return _candidate_of(np.column_stack([x, np.full(len(x), y), z]), 0.0, y, wall.shape)


def _candidate_of(xyz: np.ndarray, turn: float, y: float, shape: tuple[int, int]) -> FacadeCandidate:
    """Returns a candidate with an outline over all cells of `shape`, and wall where points lie on its plane.

    The plane passes through (0, y, 0) m and is turned by `turn` rad about the vertical.
    """
    normal, point = np.array([-np.sin(turn), np.cos(turn), 0.0]), np.array([0.0, y, 0.0])
    plane = WallPlane(normal, point, 0.005, 0.015, np.eye(3), np.arange(3), 100.0)
    slab = Slab(np.arange(len(xyz)), (xyz - point) @ plane.axes, plane.axes, point)
    cells = CellMap((0.0, 0.0), CELL, *np.ones((3, *shape), np.bool_))
    wall = cells.marked(*slab.q[np.abs(slab.q[:, 1]) < plane.threshold][:, ::2].T)
    cells = CellMap((0.0, 0.0), CELL, wall, cells.whole, wall)
    return FacadeCandidate(plane, cells, slab, StreetSide.__new__(StreetSide))


def _fronts() -> tuple[FacadeCandidate, FacadeCandidate]:
    """Returns a tower 4 m wide, and beside it a wall whose portal shows the tower's plane behind it."""
    tower, beside = np.zeros((2, 60, 100), np.bool_)
    tower[:, :40] = True
    beside[:, 42:] = True
    beside[:35, 50:80] = False  # the portal; the post of its door lies in the plane of the tower
    tower[:35, 64:67] = True
    return _candidate(0.0, tower), _candidate(-0.4, beside)


def test_a_portal_in_one_wall_does_not_go_to_another_one_that_it_is_not_connected_with() -> None:
    first, second = without_overlaps(list(_fronts()))
    assert second.cells.whole[:35, 50:80].all()
    assert not first.cells.whole[:, 50:].any()


def test_panes_in_the_plane_of_the_next_wall_do_not_draw_it_over_the_wall_that_they_are_in() -> None:
    front, beside = np.zeros((2, 60, 120), np.bool_)
    front[:, :90] = True
    beside[:, 92:] = True  # set back by the depth of the panes
    for row in (4, 38):
        for column in (4, 44):
            front[row : row + 18, column : column + 18] = False
            beside[row + 1 : row + 17, column + 1 : column + 17] = True
    _, second = without_overlaps([_candidate(0.0, front), _candidate(0.3, beside)])
    assert not second.cells.whole[:, :75].any()
    assert second.cells.whole[:, 95:].all()


def test_a_layer_in_two_parts_within_the_outline_of_a_wall_is_no_wall_of_its_own() -> None:
    wall, layer = np.zeros((2, 120, 80), np.bool_)
    wall[:, :] = True
    for row in (10, 70):
        wall[row : row + 35, 10:70] = False
        layer[row : row + 35, 10:70] = True
    (found,) = without_overlaps([_candidate(0.0, wall), _candidate(-0.2, layer)])
    assert found.wall.point[1] == 0.0


def test_a_wall_of_which_hardly_anything_is_left_is_no_wall_of_its_own() -> None:
    walls = []
    for y, columns in ((0.0, slice(0, 80)), (0.2, slice(74, 82))):  # a front, and the side of a pilaster
        wall = np.zeros((60, 100), np.bool_)
        wall[:, columns] = True
        walls.append(replace(_candidate(y, wall), cells=CellMap((0.0, 0.0), CELL, wall, wall, wall)))
    (only,) = without_overlaps(walls)
    assert (only.cells.whole == walls[0].cells.whole).all()


def test_the_outline_of_one_column_of_cells_is_not_empty() -> None:
    wall = np.zeros((60, 10), np.bool_)
    wall[5:55, 5] = True
    outline = CellMap((0.0, 0.0), CELL, wall, wall, wall).outline
    assert np.ptp(outline[:, 1]) > 4.9


def test_no_place_belongs_to_two_walls() -> None:
    first, second = without_overlaps(list(_fronts()))
    assert not (first.cells.whole & second.cells.whole).any()


def test_the_middle_of_a_colonnade_goes_to_the_wall_under_it_and_not_to_the_pavilion_beside_it() -> None:
    pavilion, middle = np.zeros((2, 150, 300), np.bool_)
    pavilion[:, :60] = True
    middle[:50, 60:240] = middle[148:, 60:240] = True  # the lower storey and a cornice
    pavilion[70:120, 149:151] = True  # a flagpole that happens to stand in the plane of the pavilion
    first, second = without_overlaps([_candidate(0.0, pavilion), _candidate(0.4, middle)])
    assert not first.cells.whole[:, 70:].any()
    assert second.cells.whole[:, 70:].all()


def test_a_front_that_bends_is_divided_at_a_pier_and_not_through_its_windows() -> None:
    turn, bay, rng = np.radians(5.0), 3.0, np.random.default_rng(3)
    x, z = rng.uniform(0.0, 3 * bay, 200_000), rng.uniform(0.0, 6.0, 200_000)
    is_wall = (np.abs(x % bay - bay / 2) > 0.6) | (np.abs(z % 3.0 - 1.5) > 0.8)
    x, z = x[is_wall], z[is_wall]
    # three flat bays: the first lies on the first plane, the last on the second one, the middle on neither
    step = np.clip(x[:, None] - bay * np.arange(3), 0.0, bay)
    heading = turn * np.arange(3)
    xyz = np.column_stack([step @ np.cos(heading), step @ np.sin(heading), z])
    first = _candidate_of(xyz, 0.0, 0.0, (60, 90))
    corner = bay * np.array([1 + np.cos(turn), np.sin(turn)])
    second = _candidate_of(xyz, 2 * turn, corner[1] - corner[0] * np.tan(2 * turn), (60, 90))
    first, second = without_overlaps([first, second])
    end = CELL * np.flatnonzero(first.cells.whole.any(0))[-1]
    assert min(abs(end - bay), abs(end - corner[0])) < 0.4
    assert not (first.cells.whole & second.cells.whole)[:, :60].any()


def test_walls_that_meet_at_a_flat_corner_end_there() -> None:
    turn, wide, rng = np.radians(30.0), 4.0, np.random.default_rng(4)
    s, z = rng.uniform(0.0, 2 * wide, 100_000), rng.uniform(0.0, 6.0, 100_000)
    step = np.clip(s[:, None] - [0.0, wide], 0.0, wide)
    heading = np.array([0.0, turn])
    xyz = np.column_stack([step @ np.cos(heading), step @ np.sin(heading), z])
    first = _candidate_of(xyz, 0.0, 0.0, (60, 60))  # both outlines run on past the corner
    second = _candidate_of(xyz, turn, -wide * np.tan(turn), (60, 90))
    corner = wide / np.cos(turn)
    first, second = without_overlaps([first, second])
    assert abs(CELL * first.cells.whole.any(0).sum() - wide) < 0.15
    assert abs(CELL * np.flatnonzero(second.cells.whole.any(0))[0] - corner) < 0.15


def test_the_spacing_of_a_wall_that_is_scanned_unevenly_does_not_depend_on_the_draw() -> None:
    rng = np.random.default_rng(0)
    told = []
    for share in (1.0, 0.25):
        x = 20.0 * rng.random(round(400_000 * share)) ** 2  # denser towards the left
        q = np.column_stack([x, np.zeros(len(x)), 5.0 * rng.random(len(x))])
        cells = CellMap((0.0, 0.0), CELL, *np.ones((3, 50, 200), np.bool_))
        told.append(wall_spacing(q, cells.flat(q[:, 0], q[:, 2]), cells, 0.02))
    assert told[1] / told[0] == np.clip(told[1] / told[0], 1.9, 2.1)


@pytest.mark.parametrize(("offset", "high", "number"), [(-0.2, 18, 1), (-0.2, 30, 2), (-0.6, 18, 2)])
def test_a_plinth_is_relief_of_its_wall_unless_it_is_a_storey_or_stands_far_out(
    offset: float, high: int, number: int
) -> None:
    wall, plinth = np.zeros((2, 90, 120), np.bool_)
    wall[high:], plinth[:high] = True, True
    kept = without_overlaps([_candidate(0.0, wall), _candidate(offset, plinth)])
    assert len(kept) == number
    assert kept[0].cells.whole[:high].any() == (number == 1)
