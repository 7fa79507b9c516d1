"""Beams without return: told from the raster alone, kept through merging, cropping and motions."""

import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3
from frontage.model.noreturns import no_returns
from frontage.model.scan import merge_scans
from raster_scans import EYE, scan_raster, tilted, within

WINDOW = within((3.0, 1.0, 6.0, 4.0))


def nearest(directions, wanted):
    """The largest angle, rad, from any wanted direction (m, 3) to the nearest of the directions (k, 3)."""
    return max(np.linalg.norm(directions - w, axis=1).min() for w in wanted)


def test_lost_beams_point_where_a_tilted_scanner_looked():
    scan, lost = scan_raster(WINDOW)
    (found,) = scan.lost_beams()
    assert nearest(found.directions, lost[::29]) < 1e-6
    assert len(found.directions) == (scan.grid.index < 0).sum()


@pytest.mark.parametrize("rows", [slice(60, 70), slice(0, 12), slice(-25, None)])
def test_rows_without_any_return_lie_at_the_steps_of_the_others(rows):
    scan, _ = scan_raster(WINDOW)
    band = scan.grid.index.copy()
    band[rows] = -1
    found = no_returns(scan.xyz, scan.origins[0], band)
    (whole,) = scan.lost_beams()
    assert found is not None
    np.testing.assert_allclose(found.elevation, whole.elevation, atol=1e-9)
    assert found.lost[rows].all() and not whole.lost[60:70].all()


def test_indices_that_are_not_a_polar_raster_give_none():
    scan, _ = scan_raster(WINDOW)
    index = scan.grid.index.copy()
    held = index >= 0
    index[held] = np.random.default_rng(0).permutation(index[held])
    assert no_returns(scan.xyz, scan.origins[0], index) is None
    assert no_returns(scan.xyz, scan.origins[0], index[:1]) is None


def test_merged_clouds_keep_lost_beams_with_their_stations():
    one, a = scan_raster(WINDOW)
    two, b = scan_raster(WINDOW, tilted((7.0, -8.0, 1.7), -3.0))
    merged = merge_scans([one, two])
    assert merged.grid is None and [lost.origin for lost in merged.no_returns] == [0, 1]
    for lost, wanted in zip(merged.no_returns, (a, b), strict=True):
        assert nearest(lost.directions, wanted[::97]) < 1e-6
    again = merge_scans([merged, one])
    assert [lost.origin for lost in again.no_returns] == [0, 1, 2]
    assert again.take(np.arange(10)).no_returns == again.no_returns
    assert merge_scans([one]).grid is None and len(merge_scans([one]).no_returns) == 1


def test_lost_ground_beams_show_that_points_were_cut_out():
    whole, _ = scan_raster(WINDOW)
    cut, _ = scan_raster(WINDOW, street=False)
    assert whole.lost_beams()[0].ground == 0.0
    assert cut.lost_beams()[0].ground > 0.5


def test_lost_beams_move_with_their_station():
    scan, lost = scan_raster(WINDOW)
    turn = Rigid3(
        "local", "local", np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.ones(3)
    )
    (found,) = (n.moved(turn) for n in scan.lost_beams())
    assert nearest(found.directions, turn.rotate(lost[::97])) < 1e-6


def test_only_lost_beams_towards_a_place_are_kept():
    scan, lost = scan_raster(WINDOW)
    (whole,) = scan.lost_beams()
    corners = np.array([[x, 0.0, z] for x in (3.0, 6.0) for z in (1.0, 4.0)])
    part = whole.towards(corners - np.array(EYE))
    assert part.lost.size < 0.5 * whole.lost.size
    assert nearest(part.directions, lost[::29]) < 1e-6
    behind = whole.towards(np.array([[0.0, -5.0, 0.0], [1.0, -5.0, 0.5]]))
    assert not len(behind.directions)
