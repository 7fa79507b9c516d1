"""Windows in a wall that lies behind columns: the wall is found at its own depth."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.openings import FoundOpenings, find_openings
from frontage.openings.wall.beams import sort_beams
from frontage.openings.wall.evidence import weigh
from frontage.openings.wall.raster import TILE, WallRaster
from frontage.openings.wall.recesses import with_recesses
from frontage.openings.wall.surface import recess_depth, value_at
from openings.boxes import box, scanned

COLUMNS = ((0.0, 0.5), (3.75, 4.25), (7.5, 8.0))
RECESS, PANE = 0.24, 0.42  # m behind the columns
SILL, HEAD = 3.0, 6.0


def portico(windows):
    """Columns, a plinth and an entablature at y = 0, and between them a wall with windows (x0, x1)."""
    front = [box(x0, x1, 0.0, 0.5, 0.0, 9.0) for x0, x1 in COLUMNS]
    front += [box(0.0, 8.0, 0.0, 0.5, 0.0, 1.0), box(0.0, 8.0, 0.0, 0.5, 8.2, 9.0)]
    x = [0.0, *np.ravel(windows), 8.0]
    piers = [box(a, b, RECESS, 0.5, SILL, HEAD) for a, b in zip(x[::2], x[1::2], strict=True)]
    bands = [box(0.0, 8.0, RECESS, 0.5, 0.0, SILL), box(0.0, 8.0, RECESS, 0.5, HEAD, 9.0)]
    return [*front, *piers, *bands, box(0.0, 8.0, PANE, 0.5, SILL, HEAD)]


@pytest.mark.parametrize("rays", [True, False])
def test_windows_between_columns_are_found_in_the_wall_behind(rays):
    windows = [(1.3, 2.9), (5.0, 6.6)]
    facade, scan = scanned(wall=portico(windows), rays=rays)
    found = find_openings(facade, scan)
    assert isinstance(found, FoundOpenings)
    boxes = sorted((*o.ring.min(0), *o.ring.max(0)) for o in found.openings)
    assert len(boxes) == 2
    true = [(x0, SILL, x1, HEAD) for x0, x1 in windows]
    assert np.abs(np.array(boxes) - true).max() < 0.03
    depths = [o.depth.value for o in found.openings]
    assert np.allclose(depths, PANE - RECESS, atol=0.01)


def test_a_recess_need_not_return_the_beams_that_are_not_due_there():
    facade, scan = scanned(wall=portico([(1.3, 2.9), (5.0, 6.6)]), rays=False)
    beams = sort_beams(facade, scan)
    evidence = weigh(facade, beams)
    hidden = beams.points[:, 2] > 2.0  # by what stands before it
    beams = replace(beams, points=beams.points[~hidden])
    assert with_recesses(beams, evidence, facade) is None
    rows = int(2.0 / evidence.raster.cell)
    expected = np.where(np.arange(len(evidence.expected))[:, None] < rows, evidence.expected, 0.0)
    depth = with_recesses(beams, replace(evidence, expected=expected), facade)
    assert depth is not None and depth.max() == pytest.approx(RECESS, abs=0.01)


def test_a_window_beside_a_recess_stays_in_its_own_wall():
    """A loggia of 3 x 7 m, and a window 0.3 m beside it, with a wall behind both."""
    (x0, z0, x1, z1), (edge, low, high) = (3.2, 4.0, 4.7, 5.5), (5.0, 1.0, 8.0)
    wall = [box(0.0, x0, 0.0, 0.5, 0.0, 9.0), box(x1, edge, 0.0, 0.5, 0.0, 9.0)]
    wall += [box(x0, x1, 0.0, 0.5, 0.0, z0), box(x0, x1, 0.0, 0.5, z1, 9.0), box(x0, x1, 0.2, 0.3, z0, z1)]
    wall += [box(edge, 8.0, 0.0, 0.5, 0.0, low), box(edge, 8.0, 0.0, 0.5, high, 9.0)]
    facade, scan = scanned(wall=[*wall, box(edge, 8.0, 0.8, 1.5, low, high)])
    beams = sort_beams(facade, scan)
    depth = with_recesses(beams, weigh(facade, beams), facade)
    assert depth is not None
    beams = sort_beams(facade, scan, depth)
    assert np.abs(beams.depth_at(np.linspace(x0, x1, 9), np.full(9, 4.7))).max() < 0.02
    assert beams.depth_at(np.array([6.5]), np.array([4.7])) == pytest.approx(0.8, abs=0.02)


@pytest.mark.parametrize(("right", "depth"), [(0.2, 0.2), (0.3, 0.5)])
def test_a_window_higher_than_others_has_a_frame_of_one_depth_all_round(right, depth):
    """A lattice of 3.8 x 7 m in a recess; between jambs that differ it may be a wall that is set back."""
    rng = np.random.default_rng(0)
    points = rng.uniform((0.0, 0.195, 0.0), (5.5, 0.205, 9.0), (60_000, 3))
    x, _, z = points.T
    lattice = (x > 0.85) & (x < 4.65) & (z > 1.0) & (z < 8.0)
    points[x >= 4.65, 1] += right - 0.2
    points[lattice, 1] = np.where(rng.random(lattice.sum()) < 0.7, 0.5, 0.4)
    raster = WallRaster((0.0, 0.0), TILE, (36, 22))
    points = points[~lattice | (rng.random(len(points)) < 0.6)]
    found = recess_depth(points, np.ones(len(points), np.int64), raster, 0.005)
    assert value_at(found, raster, np.array([2.75]), np.array([4.5])) == pytest.approx(depth, abs=0.02)


def test_the_wall_of_a_recess_with_one_window_between_columns_is_the_parapet_below_that():
    """The window reaches from column to column, and to the entablature: nothing of the wall is beside it."""
    rng = np.random.default_rng(0)
    points = rng.uniform((5.5, 0.295, 0.0), (10.0, 0.305, 8.0), (60_000, 3))
    window = points[:, 2] > 3.0
    points[window, 1] = rng.choice([0.4, 0.5, 0.6, 2.0], window.sum())  # bars, spandrels, panes, room
    raster = WallRaster((0.0, 0.0), TILE, (44, 60))  # the entablature is 3 m high
    found = recess_depth(points, np.ones(len(points), np.int64), raster, 0.005)
    x, z = np.meshgrid(np.linspace(6.0, 9.5, 8), np.linspace(0.5, 7.5, 15))
    assert value_at(found, raster, x.ravel(), z.ravel()) == pytest.approx(0.3, abs=0.02)
