"""Every place of a front belongs to one of its planes, and none is lost between them."""

import numpy as np

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
    plane = WallPlane(
        np.array([0.0, 1.0, 0.0]), np.array([0.0, y, 0.0]), 0.005, 0.015, np.eye(3), np.arange(3), 100.0
    )
    cells = CellMap((0.0, 0.0), CELL, wall, np.ones_like(wall), wall)
    slab = Slab.__new__(Slab)  # `without_overlaps` looks at planes and cells only
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


def test_the_spacing_of_a_wall_that_is_scanned_unevenly_does_not_depend_on_the_draw() -> None:
    rng = np.random.default_rng(0)
    told = []
    for share in (1.0, 0.25):
        x = 20.0 * rng.random(round(400_000 * share)) ** 2  # denser towards the left
        q = np.column_stack([x, np.zeros(len(x)), 5.0 * rng.random(len(x))])
        cells = CellMap((0.0, 0.0), CELL, *np.ones((3, 50, 200), np.bool_))
        told.append(wall_spacing(q, cells.flat(q[:, 0], q[:, 2]), cells, 0.02))
    assert told[1] / told[0] == np.clip(told[1] / told[0], 1.9, 2.1)
