"""Protrusions before small walls: found with honest borders, told from trees and cars, walls of their own."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.model.estimate import Provenance
from frontage.model.opening import Opening, OpeningKind
from frontage.openings import FoundOpenings, OpeningOptions, find_openings
from frontage.openings.fronts import FrontSearch
from frontage.openings.protrusions.beams import FacadeBeams
from frontage.openings.protrusions.doors import with_balcony_doors
from frontage.openings.protrusions.find import find_protrusions, number_protrusions
from frontage.openings.protrusions.mouldings import common_profile
from frontage.openings.protrusions.resolution import Resolution
from openings.boxes import balcony, box, oriel, scanned

WINDOW = (3.5, 4.3, 4.6, 5.9)
ORIEL = oriel(3.0, 5.1, 3.5, 6.6, -0.7, WINDOW, 0.12)


def protrusions(facade, scan, ground):
    return number_protrusions(facade.id, find_protrusions(facade, FacadeBeams.of(facade, scan), (), ground))


def box_of(found):
    return np.concatenate([found.ring.min(0), found.ring.max(0)])


@pytest.mark.parametrize("spacing", [0.02, 0.04])
def test_oriel_is_found_with_its_borders_and_its_front(spacing):
    (found,) = protrusions(*scanned(ORIEL, spacing=spacing), ground=0.0)
    assert (found.id, found.kind) == ("B01/F1/P1", "oriel")
    error = box_of(found) - (3.0, 3.5, 5.1, 6.6)
    assert np.abs(error).max() < 0.6 * spacing
    assert np.sqrt(np.mean(error**2)) < 3.0 * found.sigma
    assert found.front.value == pytest.approx(-0.7, abs=3.0 * float(found.front.sigma[0]) + 0.001)
    assert 0.0 < found.front.sigma[0] < 0.005


def test_openings_on_an_oriel_sit_on_it_and_their_depth_counts_from_its_front():
    result = find_openings(*scanned(ORIEL), OpeningOptions(ground_z=0.0))
    assert isinstance(result, FoundOpenings)
    on = [o for o in result.openings if o.on == "B01/F1/P1"]
    assert len(on) == 1
    assert box_of(on[0]) == pytest.approx(WINDOW, abs=0.03)
    assert on[0].depth.value == pytest.approx(0.12, abs=0.015)
    behind = [o for o in result.openings if not o.on and 3.0 < o.ring[:, 0].mean() < 5.1]
    assert all(o.ring[:, 1].max() < 3.6 or o.ring[:, 1].min() > 6.5 for o in behind)


def test_a_front_ends_where_the_outline_of_its_facade_does():
    """Capitals below an entablature widen its rectangle into the air between them."""
    facade, scan = scanned(ORIEL)
    (own,) = find_protrusions(facade, FacadeBeams.of(facade, scan), (), 0.0)
    fronts = []
    for low in (4.0, 6.0):
        cut = replace(facade, outline=np.array([[0, low], [8, low], [8, 9], [0, 9]], float))
        FrontSearch(cut, scan, lambda front, _: fronts.append(front) or ()).openings(own)
    # a gap in the outline of the facade is no end of a front
    assert [f.outline[:, 1].min() for f in fronts] == pytest.approx([4.0, 3.5], abs=0.03)
    assert all(f.outline[:, 1].max() == pytest.approx(6.6, abs=0.03) for f in fronts)


@pytest.mark.parametrize("bars", [False, True])
def test_balcony_with_a_parapet_and_with_a_railing(bars):
    (found,) = protrusions(*scanned(balcony(2.0, 4.5, 4.0, -1.0, bars)), ground=0.0)
    assert found.kind == "balcony"
    assert box_of(found) == pytest.approx((2.0, 3.85, 4.5, 5.0), abs=0.02)
    assert found.front.value == pytest.approx(-1.0, abs=0.006)


def test_the_door_of_a_balcony_reaches_down_to_its_floor():
    door = [box(0, 2.6, 0, 0.3, 0, 9), box(3.8, 8, 0, 0.3, 0, 9), box(2.6, 3.8, 0, 0.3, 0, 4.05)]
    wall = [*door, box(2.6, 3.8, 0, 0.3, 6.2, 9), box(2.6, 3.8, 0.15, 0.3, 4.05, 6.2)]
    result = find_openings(*scanned(balcony(2.0, 4.5, 4.0, -1.0), wall=wall), OpeningOptions(ground_z=0.0))
    assert isinstance(result, FoundOpenings)
    (found,) = result.openings
    assert found.kind == "door"
    assert box_of(found) == pytest.approx((2.6, 4.05, 3.8, 6.2), abs=0.04)
    sigma = np.sqrt(np.diag(found.ring_covariance)).reshape(-1, 2)
    assert sigma[found.ring[:, 1].argmin(), 1] > 5 * sigma[found.ring[:, 1].argmax(), 1]


def window(place, sigma, provenance="measured"):
    """Returns a window at a place x0, z0, x1, z1 m whose borders are known to sigma m."""
    x0, z0, x1, z1 = place
    return Opening(
        id="", kind=OpeningKind.WINDOW, ring=np.array([(x0, z0), (x1, z0), (x1, z1), (x0, z1)]),
        ring_covariance=np.eye(8) * sigma**2, depth=None, shape="rectangle",
        provenance=Provenance(provenance), evidence=99.0, confidence=1.0, floor=0, bay=0,
    )  # fmt: skip


def test_a_window_above_another_one_leads_to_no_balcony_below_that():
    """What stands before the upper half of the lower window is an awning."""
    facade, scan = scanned(balcony(2.0, 4.5, 4.0, -1.0), wall=[box(0, 2.2, 0, 0.3, 0, 9)])
    (awning,) = protrusions(facade, scan, ground=0.0)
    windows = [window((2.6, 5.2, 3.8, 6.5), 0.3), window((2.6, 3.2, 3.8, 4.9), 0.3)]
    told = with_balcony_doors(windows, [awning], FacadeBeams.of(facade, scan), facade)
    np.testing.assert_array_equal(told[0].ring, windows[0].ring)


@pytest.mark.parametrize(
    ("sigma", "sides", "provenance", "kind"),
    [
        (0.3, [(2.6, 3.8)], "measured", "door"),
        (0.02, [(2.6, 3.8)], "pooled", "door"),  # known from its row, but a balcony has a door
        (0.3, [(2.2, 3.1), (3.4, 4.3)], "pooled", "door"),
        (0.02, [(2.2, 3.1), (3.4, 4.3)], "pooled", "window"),  # either may be the door
        (0.02, [(2.2, 3.1), (3.4, 4.3)], "measured", "window"),
    ],
)
def test_openings_with_hidden_feet_lead_to_the_balcony_unless_rows_tell_their_sills(
    sigma, sides, provenance, kind
):
    facade, scan = scanned(balcony(2.0, 4.5, 4.0, -1.0), wall=[box(0, 2.2, 0, 0.3, 0, 9)])
    (rail,) = protrusions(facade, scan, ground=0.0)
    windows = [window((a, 5.0, b, 6.2), sigma, provenance) for a, b in sides]
    told = with_balcony_doors(windows, [rail], FacadeBeams.of(facade, scan), facade)
    assert [o.kind for o in told] == [kind] * len(sides)
    assert all((o.ring[:, 1].min() < 4.5) == (kind == "door") for o in told)
    if kind == "window":  # a foot that only the row tells may lie on the floor, 0.95 m below
        feet = np.sqrt([o.ring_covariance[1, 1] for o in told])
        np.testing.assert_allclose(feet, 0.02 if provenance == "measured" else 0.67, atol=0.02)


@pytest.mark.parametrize(
    ("seen", "head", "foot", "sigma"),
    [(5.0, 5.78, 4.05, 0.06), (5.0, 5.5, 5.0, 0.67), (4.01, 6.1, 4.01, 0.001)],
)
def test_the_only_opening_of_a_balcony_is_its_door_or_its_foot_is_unknown(seen, head, foot, sigma):
    """Its row tells the foot to 1 mm, but the parapet hides it, unless it stands on the floor as it is."""
    facade, scan = scanned(balcony(2.0, 4.5, 4.0, -1.0), wall=[box(0, 2.2, 0, 0.3, 0, 9)])
    (rail,) = protrusions(facade, scan, ground=0.0)
    beams = FacadeBeams.of(facade, scan)
    (told,) = with_balcony_doors([window((2.6, seen, 3.8, head), 0.001)], [rail], beams, facade)
    assert told.ring[:, 1].min() == pytest.approx(foot, abs=0.01)
    assert np.sqrt(told.ring_covariance[1, 1]) == pytest.approx(sigma, rel=0.05)


def test_a_low_window_beside_the_door_of_a_balcony_leaves_it_a_door():
    facade, scan = scanned(balcony(2.0, 4.5, 4.0, -1.0), wall=[box(0, 2.2, 0, 0.3, 0, 9)])
    (rail,) = protrusions(facade, scan, ground=0.0)
    both = [window((2.2, 5.0, 3.1, 6.2), 0.001), window((3.4, 5.0, 4.3, 5.6), 0.001)]
    told = with_balcony_doors(both, [rail], FacadeBeams.of(facade, scan), facade)
    assert [o.kind for o in told] == ["door", "window"]


def test_a_window_above_a_balcony_that_shows_its_wall_stays_one():
    hole = [box(0, 2.6, 0, 0.3, 0, 9), box(3.8, 8, 0, 0.3, 0, 9), box(2.6, 3.8, 0, 0.3, 0, 5.2)]
    wall = [*hole, box(2.6, 3.8, 0, 0.3, 6.4, 9), box(2.6, 3.8, 0.15, 0.3, 5.2, 6.4)]
    low = balcony(2.0, 4.5, 4.0, -0.6, bars=True, high=0.9)
    result = find_openings(*scanned(low, wall=wall), OpeningOptions(ground_z=0.0))
    assert isinstance(result, FoundOpenings)
    assert [o.kind for o in result.openings] == ["window"]
    assert result.openings[0].ring[:, 1].min() == pytest.approx(5.2, abs=0.03)


def test_cornice_band_and_pilaster_are_told_apart():
    parts = [box(0, 8, -0.3, 0, 8.6, 8.8), box(0, 8, -0.15, 0, 3.0, 3.2), box(6, 6.5, -0.2, 0, 3.6, 8.2)]
    found = protrusions(*scanned(parts), ground=0.0)
    assert sorted(p.kind for p in found) == ["band", "cornice", "pilaster"]


def test_tiers_of_a_cornice_are_one():
    tiers = [box(0, 8, -0.36, 0, 8.5, 8.6), box(0, 8, -0.24, 0, 8.4, 8.5), box(0, 8, -0.12, 0, 8.3, 8.4)]
    (found,) = protrusions(*scanned(tiers, spacing=0.02), ground=0.0)
    assert found.kind == "cornice"
    assert box_of(found)[[1, 3]] == pytest.approx((8.3, 8.6), abs=0.02)
    assert found.front.value == pytest.approx(-0.36, abs=0.01)


def test_what_stands_out_less_than_a_decimetre_is_none():
    assert protrusions(*scanned([box(2, 4, -0.07, 0, 3, 6)]), ground=0.0) == ()


def test_foliage_and_a_car_before_the_wall_are_none():
    rng = np.random.default_rng(1)
    leaves = rng.normal((4.0, -0.7, 5.0), (0.9, 0.35, 0.9), (6000, 3))
    car = [box(1.0, 5.0, -1.45, -0.6, 0.3, 1.4)]
    assert protrusions(*scanned(car, extra=leaves), ground=0.0) == ()


def test_steps_stand_on_the_ground():
    steps = [box(3, 4.5, -0.3 * k, 0, 0, 0.6 - 0.17 * (k - 1)) for k in (1, 2, 3)]
    assert {p.kind for p in protrusions(*scanned(steps), ground=0.0)} == {"steps"}


def test_awning_slopes_without_an_upright_front():
    n = 12_000
    rng = np.random.default_rng(0)
    out = rng.uniform(0.0, 1.2, n)
    awning = np.column_stack([rng.uniform(2, 5, n), -out, 3.4 - 0.4 * out + rng.normal(0, 0.002, n)])
    (found,) = protrusions(*scanned(extra=awning, rays=False), ground=0.0)
    assert found.kind == "awning"
    assert found.front.value == pytest.approx(-1.2, abs=0.05)


def test_a_cornice_goes_on_behind_a_post():
    post = box(3.9, 4.2, -4.2, -4.0, 0, 9)
    parts = [box(0, 8, -0.3, 0, 8.0, 8.25), post]
    (found,) = protrusions(*scanned(parts, eyes=((4.0, -10.0, 1.6),)), ground=0.0)
    assert box_of(found)[[0, 2]] == pytest.approx((0.0, 8.0), abs=0.03)


def test_a_border_that_something_hides_says_so():
    hide = box(3.8, 5.0, -4.2, -4.0, 0, 9)
    parts = [*balcony(2.0, 5.5, 4.0, -1.0)]
    seen, hidden = (
        protrusions(*scanned([*parts, *other], eyes=((1.0, -10.0, 1.6),)), ground=0.0)[0]
        for other in ([], [hide])
    )
    assert hidden.sigma > 10 * seen.sigma
    assert hidden.confidence < 1.0


def test_without_rays_the_oriel_is_still_there():
    found = [p for p in protrusions(*scanned(ORIEL, rays=False), ground=0.0) if p.kind == "oriel"]
    assert len(found) == 1
    assert box_of(found[0]) == pytest.approx((3.0, 3.5, 5.1, 6.6), abs=0.04)


def test_a_bay_shows_one_cheek_where_the_scanner_stood_on_one_side_of_it():
    facade, scan = scanned(oriel(3.0, 5.1, 0.0, 6.6, -1.0, WINDOW, 0.12), rays=False)
    x, y, z = scan.xyz.T
    hidden = (x > 4.95) | (z > 6.5) | (z < 0.9)  # by the bay itself, and by a car
    seen = np.flatnonzero(~(hidden & (y > -0.97) & (y < -0.03)))
    facade = replace(facade, support=np.arange(len(seen)), inliers=np.arange(len(seen)))
    (found,) = [p for p in protrusions(facade, scan.take(seen), ground=0.0) if p.kind == "bay"]
    assert found.front.value == pytest.approx(-1.0, abs=0.01)


def test_a_part_set_back_is_a_wall_of_its_own():
    back = [box(0, 5.5, 0, 0.8, 0, 9), box(5.5, 8, 0.6, 0.8, 0, 9)]
    found = protrusions(*scanned(wall=back, layers=(0.0, 0.6)), ground=0.0)
    assert [p.kind for p in found] == ["setback"]
    assert found[0].front.value == pytest.approx(0.6, abs=0.01)
    assert found[0].ring[:, 0].min() == pytest.approx(5.5, abs=0.03)


def test_profiles_are_common_along_mouldings_not_in_foliage():
    rng = np.random.default_rng(2)
    turn = rng.uniform(0, np.pi / 2, 4000)
    curve = np.column_stack([rng.uniform(0, 6, 4000), -0.1 - 0.3 * np.sin(turn), 5 + 0.3 * np.cos(turn)])
    resolution = Resolution(0.02, 0.003, 0.02, np.empty((0, 3)))
    assert common_profile(curve, 0, resolution).mean() > 0.95
    cloud = rng.uniform((0, -1.2, 4), (6, -0.1, 6), (4000, 3))
    assert common_profile(cloud, 0, resolution).mean() < 0.05


def test_ids_run_from_left_to_right_and_upwards():
    parts = [*balcony(5.0, 7.0, 6.0, -0.9), *balcony(1.0, 3.0, 6.0, -0.9), *balcony(1.0, 3.0, 3.0, -0.9)]
    found = protrusions(*scanned(parts), ground=0.0)
    assert [p.id for p in found] == ["B01/F1/P1", "B01/F1/P2", "B01/F1/P3"]
    assert found[0].ring[:, 1].min() < found[1].ring[:, 1].min()
    assert found[2].ring[:, 0].min() > 4.0


def test_the_published_method_reports_protrusions_as_well():
    result = find_openings(*scanned(ORIEL, spacing=0.04), OpeningOptions(method="paper"))
    assert isinstance(result, FoundOpenings)
    assert any(p.front.value == pytest.approx(-0.7, abs=0.02) for p in result.protrusions)


def test_same_input_same_result():
    a, b = (protrusions(*scanned(ORIEL), ground=0.0)[0] for _ in range(2))
    assert np.array_equal(a.ring, b.ring)
    assert (a.sigma, a.front.value) == (b.sigma, b.front.value)


def test_a_wall_that_slants_is_no_stair_of_fronts():
    facade, scan = scanned(wall=[box(0, 12, 0, 0.3, 0, 9)], spacing=0.02)
    xyz = scan.xyz.copy()
    xyz[:, 1] -= 0.035 * np.maximum(xyz[:, 0] - 4.0, 0.0)  # houses in a bend: 28 cm on 8 m
    assert protrusions(facade, replace(scan, xyz=xyz), ground=0.0) == ()
