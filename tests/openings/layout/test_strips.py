"""Narrow strips of wall between openings, and bars of joinery that are level with the wall."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.openings import FoundOpenings, find_openings
from frontage.openings.layout.candidates import _bars
from frontage.openings.layout.joinery import joinery_planes
from frontage.openings.layout.strips import find_strips
from frontage.openings.wall.beams import sort_beams
from frontage.openings.wall.evidence import weigh
from openings.boxes import box, scanned
from openings.joinery import framed, wall

LEFT, RIGHT, MIDDLE = 2.0, 5.0, 3.5
LOW, HIGH = 2.5, 4.0


def pair(strip, lying=False):
    """Two equal openings with a strip m between them, in a field of 3.0 x 1.5 m."""
    if lying:
        z = (LOW + HIGH) / 2
        return [(LEFT, LOW, RIGHT, z - strip / 2), (LEFT, z + strip / 2, RIGHT, HIGH)]
    return [(LEFT, LOW, MIDDLE - strip / 2, HIGH), (MIDDLE + strip / 2, LOW, RIGHT, HIGH)]


def found_in(boxes):
    found = find_openings(*scanned(wall=boxes, spacing=0.02))
    assert isinstance(found, FoundOpenings)
    return np.array(sorted([*o.ring.min(0), *o.ring.max(0)] for o in found.openings))


def between(holes):
    """The strips of wall between holes, which `wall` leaves open where they lie above one another."""
    (x0, _, _, z0), (_, z1, x1, _) = holes
    return [box(x0, x1, 0.0, 0.3, z0, z1)]


@pytest.mark.parametrize("deep", [0.06, 0.15, 0.25])
@pytest.mark.parametrize(("strip", "off"), [(0.07, 0.08), (0.09, 0.02), (0.11, 0.02)])
def test_a_strip_level_with_the_wall_parts_windows_whose_frames_lie_behind_it(strip, off, deep):
    holes = pair(strip)
    places = found_in([*wall(holes), *(b for hole in holes for b in framed(hole, deep))])
    assert len(places) == 2
    assert np.abs(places - holes).max() < off  # frames beside the narrowest are taken for its borders


def test_four_windows_in_a_cross_of_narrow_strips_are_four():
    columns = pair(0.09)
    rows = [(LOW, 3.205), (3.295, HIGH)]
    holes = [(x0, z0, x1, z1) for x0, _, x1, _ in columns for z0, z1 in rows]
    strips = [box(x0, x1, 0.0, 0.3, 3.205, 3.295) for x0, _, x1, _ in columns]
    places = found_in([*wall(columns), *strips, *(b for hole in holes for b in framed(hole, 0.12))])
    assert len(places) == 4
    assert np.abs(places - sorted(holes)).max() < 0.02


def test_a_strip_parts_low_windows_whose_rails_fill_half_of_their_height():
    columns, rows, edge = pair(0.1), [(2.5, 2.94), (3.03, 3.47), (3.56, 4.0)], 0.12
    holes = [(x0, z0, x1, z1) for x0, _, x1, _ in columns for z0, z1 in rows]
    strips = [
        box(x0, x1, 0.0, 0.3, a, b) for x0, _, x1, _ in columns for a, b in [(2.94, 3.03), (3.47, 3.56)]
    ]
    rails = [
        box(x0, x1, 0.1, 0.16, a, b)
        for x0, z0, x1, z1 in holes
        for a, b in [(z0, z0 + edge), (z1 - edge, z1)]
    ]
    frames = [b for hole in holes for b in framed(hole, 0.1)]
    places = found_in([*wall(columns), *strips, *rails, *frames])
    assert len(places) == 6
    order = np.lexsort((places[:, 1], places[:, 0].round(1)))
    assert np.abs(places[order] - holes).max() < 0.02


def test_a_lying_strip_parts_windows_above_one_another():
    holes = pair(0.09, lying=True)
    field = (LEFT, LOW, RIGHT, HIGH)
    places = found_in([*wall([field]), *between(holes), *(b for hole in holes for b in framed(hole, 0.15))])
    assert len(places) == 2
    assert np.abs(places - sorted(holes)).max() < 0.02


def test_a_wall_that_nothing_is_expected_of_has_no_strips():
    holes = pair(0.09)
    facade, scan = scanned(wall=[*wall(holes), *(b for h in holes for b in framed(h, 0.15))], spacing=0.02)
    beams = sort_beams(facade, scan)
    evidence = weigh(facade, beams)
    planes = list(joinery_planes(beams, evidence))
    assert len(find_strips(beams, planes, [evidence])) == 1
    assert find_strips(beams, planes, [replace(evidence, expected=np.zeros_like(evidence.expected))]) == ()


@pytest.mark.parametrize("lying", [False, True])
@pytest.mark.parametrize("deep", [0.0, 0.02])
def test_a_bar_in_the_plane_of_its_frame_parts_nothing(deep, lying):
    field, middle = (LEFT, LOW, RIGHT, HIGH), (LOW + HIGH) / 2
    upright = (MIDDLE - 0.045, MIDDLE + 0.045, deep, deep + 0.06, LOW, HIGH)
    transom = (LEFT, RIGHT, deep, deep + 0.06, middle - 0.045, middle + 0.045)
    room = box(LEFT, RIGHT, 0.8, 0.9, LOW, HIGH)
    (only,) = found_in([*wall([field]), *framed(field, deep), box(*(transom if lying else upright)), room])
    assert only[0] < LEFT + 0.1 and only[2] > RIGHT - 0.1
    assert only[1] < LOW + 0.1 and only[3] > HIGH - 0.1


def test_a_bar_beside_a_column_of_noise_is_a_bar():
    open_ = np.zeros((60, 40), np.bool_)
    open_[5:55, 4:19], open_[5:55, 22:37] = True, True
    open_[18:34, 18] = False  # leaves of a plant behind the pane, right beside the bar
    bars = _bars(open_, 4)[5:55, 19:22]
    assert bars[:13].all() and bars[29:].all()
    open_[5:30, 22:37] = False  # a window beside a door
    assert not _bars(open_, 4)[5:55, 19:22].any()


def test_a_strip_that_noise_interrupts_is_one_strip():
    holes = pair(0.09)
    facade, scan = scanned(wall=[*wall(holes), *(b for h in holes for b in framed(h, 0.15))], spacing=0.02)
    beams = sort_beams(facade, scan)
    evidence = weigh(facade, beams)
    z = evidence.raster.corner[1] + (np.arange(len(evidence.llr)) + 0.5) * evidence.raster.cell
    noise = np.abs(z - (LOW + HIGH) / 2) < 0.1
    noisy = replace(evidence, llr=np.where(noise[:, None], 6.0, evidence.llr))
    (strip,) = find_strips(beams, list(joinery_planes(beams, evidence)), [noisy])
    assert strip.z1 - strip.z0 > 0.9 * (HIGH - LOW)


@pytest.mark.parametrize("shut", [0, 1])
def test_a_strip_in_line_with_another_one_needs_no_frame_of_its_own(shut):
    rows = [(LOW, 3.205), (3.295, HIGH)]
    columns = [(1.5, 3.4), (4.6, 6.5)]
    holes = [(x0, z0, x1, z1) for x0, x1 in columns for z0, z1 in rows]
    strips = [box(x0, x1, 0.0, 0.3, 3.205, 3.295) for x0, x1 in columns]
    fields = [(x0, LOW, x1, HIGH) for x0, x1 in columns]
    x0, x1 = columns[shut]
    curtain = [box(x0, x1, 0.13, 0.17, LOW, HIGH)]  # so near behind the frames that they do not stand out
    joinery = [b for hole in holes for b in framed(hole, 0.12)]
    places = found_in([*wall(fields), *strips, *joinery, *curtain])
    assert len(places) == 4
    assert max(np.abs(places - hole).max(1).min() for hole in holes) < 0.03
