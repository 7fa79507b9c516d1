"""Rooms that were scanned from inside: the inner face of a wall shows where masonry is."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.openings import OpeningOptions, find_openings
from frontage.openings.observe import observe_wall
from frontage.openings.wall.beams import sort_beams
from frontage.openings.wall.evidence import weigh
from frontage.openings.wall.innerface import find_inner_face
from fronts import box_of, scan_wall

WINDOWS = [(1.0, 1.5, 2.0, 3.0), (3.0, 1.5, 4.0, 3.0), (5.0, 1.5, 6.0, 3.0)]
SHADED = (0.8, 3.0, 2.2, 3.7)  # above the first window, where the street saw little of the wall
SPLAY = 0.1  # m by which windows are wider inside
THICK = 0.36


def with_points(facade, scan, xyz):
    """Returns facade and scan with points (n, 3) m more, which the facade holds as well."""
    p = np.vstack([scan.xyz, xyz])
    index = np.arange(len(p))
    unknown = np.full(len(p), -1, np.int32)
    return replace(facade, support=index, inliers=index), replace(scan, xyz=p, origin_index=unknown)


def surface(depth, *, but=(), spacing=0.015, margin=SPLAY, seed=3):
    """Returns points (n, 3) m of a surface behind the whole wall, but not in and around the boxes `but`."""
    rng = np.random.default_rng(seed)
    x, z = (v.ravel() for v in np.meshgrid(np.arange(0, 7, spacing), np.arange(0.4, 4.8, spacing)))
    kept = np.ones(len(x), bool)
    for x0, z0, x1, z1 in but:
        kept &= (np.maximum(x0 - x, x - x1) > margin) | (np.maximum(z0 - z, z - z1) > margin)
    x, z = x[kept], z[kept]
    return np.column_stack([x, depth + rng.normal(0, 0.003, len(x)), z])


def lived_in(seed=0):
    """Returns a wall whose rooms were scanned, with a place that the street hardly saw."""
    facade, scan = scan_wall(WINDOWS, rays=False, returned=0.3, seed=seed)
    x0, z0, x1, z1 = SHADED
    x, _, z = scan.xyz.T
    shaded = (x > x0) & (x < x1) & (z > z0) & (z < z1)
    rare = np.random.default_rng(seed).random(len(x)) < 0.1
    scan = replace(scan, xyz=scan.xyz[~shaded | rare], origin_index=None)
    return with_points(facade, scan, surface(THICK, but=WINDOWS, seed=seed))


def inner_face_of(facade, scan):
    beams = sort_beams(facade, scan)
    return find_inner_face(facade, beams, weigh(facade, beams))


@pytest.mark.parametrize("seed", range(2))
def test_a_window_does_not_run_on_into_masonry_that_only_the_room_shows(seed):
    found = find_openings(*lived_in(seed)).openings
    assert len(found) == len(WINDOWS)
    for opening, window in zip(found, WINDOWS, strict=True):
        assert np.abs(box_of(opening) - window).max() < 0.03


def test_the_inner_face_tells_the_masonry_and_is_no_depth_of_the_openings():
    facade, scan = lived_in()
    wall = observe_wall(facade, scan, OpeningOptions())
    left_out = len(facade.support) - len(wall.facade.support)
    expected = len(surface(THICK, but=WINDOWS))
    assert 0.95 * expected < left_out < 1.02 * expected
    raster = wall.evidence.raster
    cells = raster.flat(np.array([1.5, 1.5]), np.array([3.4, 2.2]))
    above, pane = wall.evidence.llr.ravel()[cells]
    assert above <= 0.0 < pane


def test_a_second_wall_that_shows_behind_the_openings_as_well_is_no_inner_face():
    """Far from all openings nothing tells the two apart, and nothing depends on it."""
    facade, scan = scan_wall(WINDOWS, rays=False, returned=0.3)
    found = inner_face_of(*with_points(facade, scan, surface(0.6)))
    assert found is None or found.places[:, 1].min() > WINDOWS[0][3] + 1.0


def test_panes_and_known_lines_of_sight_make_no_inner_face():
    assert inner_face_of(*scan_wall(WINDOWS, rays=False)) is None
    assert inner_face_of(*scan_wall(WINDOWS)) is None


def test_points_of_a_room_count_no_more_than_the_beams_that_the_street_can_have_sent_there():
    facade, scan = scan_wall(WINDOWS, spacing=0.04, rays=False)
    x, _, z = scan.xyz.T
    rare = np.random.default_rng(0).random(len(x)) < 0.2  # of the wall above the windows
    scan = replace(scan, xyz=scan.xyz[(z < WINDOWS[0][3]) | rare], origin_index=None)
    room = surface(1.2, spacing=0.012)
    room[:, 1] += np.random.default_rng(0).uniform(0.0, 2.0, len(room))
    street, furnished = (
        weigh(seen, sort_beams(seen, cloud))
        for seen, cloud in (with_points(facade, scan, points) for points in (room[:0], room))
    )
    thin = street.raster.middles(np.ones(street.llr.shape, bool))[:, 1] > WINDOWS[0][3]
    more, due = (furnished.llr - street.llr).ravel()[thin].sum(), street.expected.ravel()[thin].sum()
    assert furnished.open.sum() > 5.0 * street.expected.sum()  # far more than came through the windows
    assert more < 0.1 * due
