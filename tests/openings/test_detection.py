"""Openings and their kinds on difficult walls: sparse, bent, all glass, at corners, behind steps."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3
from frontage.model.scan import Scan
from frontage.openings import FoundOpenings, find_openings
from frontage.openings.borders.agreement import with_supported_borders
from frontage.openings.borders.measure import measure
from frontage.openings.kinds import kind_of, with_doors
from frontage.openings.layout.framing import Framing
from frontage.openings.layout.selection import CellBox, best_layout
from frontage.openings.wall.beams import sort_beams
from frontage.openings.wall.crossings import crossing_beams
from frontage.openings.wall.evidence import weigh
from fronts import EYE, WINDOW, box_of, scan_wall
from opening_fakes import opening
from openings.boxes import box, scanned
from openings.joinery import holed


def of_points(facade, scan, xyz, rays=True):
    """The facade with other points."""
    known = {"origins": EYE[None], "origin_index": np.zeros(len(xyz), np.int32)} if rays else {}
    index = np.arange(len(xyz))
    return replace(facade, support=index, inliers=index), Scan("wall", xyz, scan.world, **known)


def of_points_sorted(facade, scan):
    """The facade and its beams without lines of sight."""
    facade, scan = of_points(facade, scan, scan.xyz, rays=False)
    return facade, sort_beams(facade, scan)


def is_framed(evidence, box):
    """Whether a box x0, z0, x1, z1 m can be an opening."""
    x0, z0, x1, z1 = box
    (x, z), cell = evidence.raster.corner, evidence.raster.cell
    cells = np.round(np.array([[z0 - z, x0 - x, z1 - z, x1 - x]]) / cell).astype(np.int64)
    return Framing(evidence, ground=-5.0)(cells)[0]


def overlap(opening, box):
    """Intersection over union of an opening's box and another."""
    a, b = box_of(opening), np.asarray(box)
    both = np.prod(np.maximum(np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2]), 0.0))
    return both / (np.prod(a[2:] - a[:2]) + np.prod(b[2:] - b[:2]) - both)


def found_in(facade, scan):
    found = find_openings(facade, scan)
    assert isinstance(found, FoundOpenings)
    return sorted(found.openings, key=lambda o: o.ring[0, 0])


@pytest.mark.parametrize("rays", [True, False])
def test_density_may_fall_twentyfold_along_a_wall(rays):
    holes = [(1.0, 2.0, 2.2, 3.6), (5.0, 2.0, 6.2, 3.6), (9.0, 2.0, 10.2, 3.6)]
    facade, scan = scan_wall(holes, size=(12.0, 5.0), returned=0.3)
    keep = np.random.default_rng(1).random(len(scan.xyz)) < 1.0 / (1.0 + 19.0 * scan.xyz[:, 0] / 12.0)
    openings = found_in(*of_points(facade, scan, scan.xyz[keep], rays))
    assert len(openings) == 3
    assert all(overlap(o, h) > 0.9 for o, h in zip(openings, holes, strict=True))


def test_a_pane_larger_than_the_wall_around_it_is_no_wall():
    pane = (1.5, 0.9, 5.0, 3.6)
    (opening,) = found_in(*scan_wall([pane], depth=0.3))
    assert overlap(opening, pane) > 0.95 and opening.kind == "shopfront"


def test_panes_in_a_row_are_not_a_set_back_wall():
    panes = [(x, 1.2, x + 2.6, 3.7) for x in (0.5, 3.5, 6.5)]
    openings = found_in(*scan_wall(panes, depth=0.1, size=(9.6, 5.0)))
    assert len(openings) == 3
    assert all(overlap(o, p) > 0.95 for o, p in zip(openings, panes, strict=True))


def test_a_bent_wall_keeps_its_windows():
    facade, scan = scan_wall([WINDOW, (4.5, 2.0, 5.7, 3.6)])
    bent = scan.xyz + np.outer(0.08 * ((scan.xyz[:, 0] - 3.5) / 3.5) ** 2, [0.0, 1.0, 0.0])
    openings = found_in(*of_points(facade, scan, bent))
    assert len(openings) == 2
    assert overlap(openings[0], WINDOW) > 0.9 and overlap(openings[1], (4.5, 2.0, 5.7, 3.6)) > 0.9


def test_another_facade_at_an_angle_adds_nothing():
    facade, scan = scan_wall([WINDOW])
    turned = Rigid3("local", "facade", np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([7.0, 0, 0]))
    side = turned.apply(scan_wall([WINDOW], seed=1)[1].xyz[::4])
    (opening,) = found_in(*of_points(facade, scan, np.vstack([scan.xyz, side])))
    assert overlap(opening, WINDOW) > 0.9


@pytest.mark.parametrize("glass", [(1.0, 0.1, 6.0, 4.0), (0.8, 0.1, 6.2, 4.2)])
def test_a_front_of_glass_is_one_opening(glass):
    (found,) = found_in(*scan_wall([glass], returned=0.3))
    assert overlap(found, glass) > 0.95 and found.kind == "garage"


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_front_of_glass_that_returns_hardly_anything_is_reported_as_unseen(seed):
    found = find_openings(*scan_wall([(0.1, 0.1, 6.9, 4.9)], returned=0.05, seed=seed))
    assert isinstance(found, FoundOpenings) and all(o.confidence == 0.0 for o in found.openings)
    assert any("of the facade was not seen" in note for note in found.notes)


def test_an_empty_patch_in_a_shadow_is_no_window():
    facade, scan = scan_wall([])
    x, z = scan.xyz[:, 0], scan.xyz[:, 2]
    shadow = (x > 2.0) & (x < 4.0) & (z > 2.0) & (z < 2.4)  # above a ledge
    assert found_in(*of_points(facade, scan, scan.xyz[~shadow], rays=False)) == []


def test_a_shallow_panel_is_no_window():
    facade, scan = scan_wall([(2.0, 1.0, 3.2, 1.4)], depth=0.035)
    assert found_in(facade, scan) == []


@pytest.mark.parametrize("share", [0.3, 0.8])
def test_dusty_panes_are_no_wall_where_other_beams_pass_them(share):
    """Weak echoes of panes lie some cm too near, right behind the wall; as many beams end in the room."""
    windows, rng = [(1.0, 3.0, 2.4, 4.6), (4.0, 3.0, 5.4, 4.6)], np.random.default_rng(0)
    wall = [box(0, 8, 0, 0.3, 0, 3.0), box(0, 8, 0, 0.3, 4.6, 9.0), box(0, 8, 0.9, 1.0, 2.5, 5.0)]
    wall += holed(0, 8, 3.0, 4.6, 0, 0.3, windows)
    number = int(share * 5000)
    panes = [(rng.uniform(x0, x1, number), rng.uniform(z0, z1, number)) for x0, z0, x1, z1 in windows]
    dust = [np.column_stack([x, rng.normal(0.022, 0.01, number), z]) for x, z in panes]
    facade, scan = scanned(wall=wall, extra=np.vstack(dust))
    found = [(*o.ring.min(0), *o.ring.max(0)) for o in find_openings(facade, scan).openings]
    assert len(found) == 2 and np.abs(np.array(found) - windows).max() < 0.05


def test_steps_lead_to_a_door():
    hole = (3.0, 1.2, 4.0, 3.7)
    facade, scan = scan_wall([hole])
    rng = np.random.default_rng(2)
    steps = np.column_stack(
        [rng.uniform(2.8, 4.2, 4000), rng.uniform(-1.2, -0.4, 4000), rng.uniform(0.0, 1.15, 4000)]
    )
    behind = (scan.xyz[:, 0] > 2.7) & (scan.xyz[:, 0] < 4.3) & (scan.xyz[:, 2] < 1.1)
    without = found_in(facade, scan)
    (with_steps,) = found_in(*of_points(facade, scan, np.vstack([scan.xyz[~behind], steps])))
    assert [o.kind for o in without] == ["window"] and with_steps.kind == "door"


def test_borders_return_where_the_evidence_speaks_against_them():
    facade, scan = scan_wall([WINDOW])
    beams = sort_beams(facade, scan)
    evidence = weigh(facade, beams)
    (good,) = measure(crossing_beams(facade, scan, beams), [WINDOW], evidence.raster.cell, facade.spacing)
    assert with_supported_borders(good, WINDOW, evidence) is good
    x0, z0, x1, z1 = good.place
    kept = with_supported_borders(replace(good, place=(x0 - 0.3, z0, x1 - 0.3, z1)), WINDOW, evidence)
    assert kept.place == (WINDOW[0], z0, WINDOW[2], z1)
    either = np.hypot(2.0 * evidence.raster.cell, 0.3 / np.sqrt(2.0))  # here or there
    assert np.sqrt(np.diag(kept.covariance))[:2] == pytest.approx([either, either], rel=0.03)
    dark = replace(evidence, llr=np.zeros_like(evidence.llr))  # nothing is known: nothing is against it
    assert (
        with_supported_borders(replace(good, place=(x0 - 0.3, z0, x1, z1)), WINDOW, dark).place[0] == x0 - 0.3
    )


@pytest.mark.parametrize(("band", "one"), [(0.25, True), (0.6, False)])
def test_masonry_from_side_to_side_parts_two_openings(band, one):
    facade, scan = scan_wall([(2.0, 0.6, 3.2, 2.2), (2.0, 2.2 + band, 3.2, 4.2)])
    assert is_framed(weigh(*of_points_sorted(facade, scan)), (2.0, 0.6, 3.2, 4.2)) == one


@pytest.mark.parametrize(
    ("lit", "returned", "rays", "one"),
    [(0.1, 0.1, False, True), (0.3, 0.1, False, False), (0.3, 0.1, True, True), (0.3, 0.4, False, True)],
)
def test_wall_that_shines_through_leaves_is_no_opening(lit, returned, rays, one):
    facade, scan = scan_wall([(2.0, 1.6, 3.2, 3.6)], returned=returned)
    wall = scan_wall([], seed=1)[1].xyz
    x, z = wall[:, 0], wall[:, 2]
    flecks = np.random.default_rng(0).random((50, 70))[(z / 0.1).astype(int), (x / 0.1).astype(int)] < lit
    flecks &= (x > 2.0) & (x < 3.2) & (z > 1.6) & (z < 3.6)
    facade, scan = of_points(facade, scan, np.vstack([scan.xyz, wall[flecks]]), rays)
    assert is_framed(weigh(facade, sort_beams(facade, scan)), (2.0, 1.6, 3.2, 3.6)) == one


def test_between_two_openings_is_a_pier():
    body, cap = CellBox(0, 0, 20, 10, 90.0), CellBox(20, 1, 25, 9, 30.0)
    assert best_layout([[body, cap]]) == [body, cap]
    assert best_layout([[body, cap]], pier=2) == [body]
    assert best_layout([[body, CellBox(22, 1, 27, 9, 30.0)]], pier=2)[1].r0 == 22


@pytest.mark.parametrize(("gap", "number"), [(0.08, 1), (0.16, 2)])
def test_what_is_thinner_than_half_a_brick_is_a_bar(gap, number):
    panes = [(1.5, 1.0, 2.3, 2.6), (2.3 + gap, 1.0, 3.1 + gap, 2.6)]
    openings = found_in(*scan_wall(panes))
    assert len(openings) == number
    whole = [(1.5, 1.0, 3.1 + gap, 2.6)] if number == 1 else panes
    assert all(overlap(o, box) > 0.9 for o, box in zip(openings, whole, strict=True))


def test_openings_of_different_height_are_two_however_near():
    door, gate = (1.0, 0.0, 2.0, 2.2), (2.09, 0.0, 4.6, 3.2)
    openings = found_in(*scan_wall([door, gate]))
    assert len(openings) == 2
    assert overlap(openings[0], door) > 0.9 and overlap(openings[1], gate) > 0.9


@pytest.mark.parametrize(
    ("width", "height", "sill", "passes", "stands", "kind"),
    [
        (1.0, 2.2, 0.1, 0.0, False, "door"),
        (1.0, 2.4, 4.2, 0.0, True, "door"),
        (1.0, 1.6, 4.2, 0.0, True, "window"),
        (1.0, 2.4, 4.2, 0.0, False, "window"),
        (2.6, 2.6, 0.1, 0.05, False, "garage"),
        (2.6, 3.0, 0.0, 0.9, False, "passage"),
        (2.6, 2.6, 0.6, 0.4, False, "shopfront"),
        (1.7, 2.6, 1.2, 0.4, False, "shopfront"),
        (1.3, 2.6, 1.2, 0.4, False, "window"),
        (2.6, 2.0, 4.0, 0.4, False, "window"),
        (0.8, 0.4, 0.4, 0.0, False, "basement"),
        (0.8, 0.4, 2.4, 0.0, False, "window"),
    ],
)
def test_kinds(width, height, sill, passes, stands, kind):
    assert kind_of(width, height, sill, passes, stands) == kind


@pytest.mark.parametrize(
    ("foot", "sill", "kind"), [(0.6, 1.3, "door"), (0.6, 1.0, "window"), (1.2, 2.0, "window")]
)
def test_what_begins_a_parapet_below_the_windows_beside_it_is_a_door(foot, sill, kind):
    boxes = [(0.0, foot, 1.0, foot + 2.2), (2.0, sill, 3.0, foot + 2.2), (4.0, sill, 5.0, foot + 2.2)]
    high, *others = with_doors([opening(box=box) for box in boxes], 0.0)
    assert high.kind == kind and all(o.kind == "window" for o in others)


@pytest.mark.parametrize(("pier", "framed"), [(0.2, True), (0.0, False)])
def test_a_narrow_pier_frames_a_window_on_wide_cells(pier, framed):
    facade, scan = scan_wall([WINDOW], spacing=0.06, returned=0.0)
    end = WINDOW[2] + pier
    dark = (scan.xyz[:, 0] > end) & (scan.xyz[:, 0] < end + 2.0)
    facade, scan = of_points(facade, scan, scan.xyz[~dark], rays=False)
    evidence = weigh(facade, sort_beams(facade, scan))
    assert evidence.raster.cell > 0.1
    assert is_framed(evidence, WINDOW) == framed
