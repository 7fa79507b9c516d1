"""Equal windows come out as one or as two together, whatever each of them shows by itself."""

import numpy as np
import pytest

from frontage.openings.layout.densities import Place
from frontage.openings.layout.division import divided_alike
from frontage.openings.wall.beams import sort_beams
from frontage.openings.wall.evidence import weigh
from openings.boxes import box, scanned
from openings.joinery import holed

FLOORS, COLUMNS, HIGH = (0.8, 2.9, 5.0, 7.1), (0.4, 2.95, 5.5), 1.3
LIGHT, BAR = 1.0, 0.15  # m, the two lights of a window and the bar between them


def _evidence(barred):
    """The evidence of a wall with twelve windows, with bars level with the wall where asked."""
    ends = [0.0, *(z + d for z in FLOORS for d in (0.0, HIGH)), 9.0]
    solids = [box(0, 8, 0, 0.3, low, high) for low, high in zip(ends[::2], ends[1::2], strict=True)]
    for z in FLOORS:
        lights = [(x, z, x + LIGHT, z + HIGH) for c in COLUMNS for x in (c, c + LIGHT + BAR)]
        panes = [(x, z, x + 2 * LIGHT + BAR, z + HIGH) for x in COLUMNS]
        solids += holed(0, 8, z, z + HIGH, 0.0, 0.3, lights if barred else panes)
    facade, scan = scanned(wall=solids, spacing=0.03, rays=False, eyes=((4.0, -10.0, 1.6),))
    return weigh(facade, sort_beams(facade, scan))


def _places(evidence, divided):
    """The places of the windows (12), row by row, as one or as two each."""
    found, corners = [], [(x, z) for z in FLOORS for x in COLUMNS]
    for (x, z), is_divided in zip(corners, divided, strict=True):
        wide = LIGHT if is_divided else 2 * LIGHT + BAR
        starts = (x, x + LIGHT + BAR) if is_divided else (x,)
        found += [Place((a, z, a + wide, z + HIGH), 1.0, evidence) for a in starts]
    return found


def _boxes(places):
    return np.array([p.box for p in places])


@pytest.mark.parametrize("odd", [0, 7])
@pytest.mark.parametrize("barred", [False, True])
def test_one_odd_window_becomes_like_all_others(barred, odd):
    evidence, own = _evidence(barred), np.arange(12) == odd
    found = divided_alike(_places(evidence, own != barred))
    told = _places(evidence, [barred] * 12)
    assert len(found) == len(told) and np.abs(_boxes(found) - _boxes(told)).max() < 1e-9


def test_most_of_them_against_the_evidence_change_nothing():
    before = _places(_evidence(True), np.arange(12) == 3)
    assert _boxes(divided_alike(before)).tolist() == _boxes(before).tolist()


def test_a_few_like_windows_tell_nothing():
    before = _places(_evidence(False), np.arange(12) == 0)[:6]
    assert _boxes(divided_alike(before)).tolist() == _boxes(before).tolist()


def test_windows_of_other_widths_tell_nothing():
    before = _places(_evidence(False), [True] * 12)[:-2]
    before.append(Place((5.5, 7.1, 6.9, 8.4), 1.0, before[0].evidence))
    assert len(divided_alike(before)) == len(before)
    assert divided_alike([]) == []


def test_places_two_cells_wider_are_alike_wherever_they_stand():
    evidence = _evidence(True)
    raster, cells = evidence.raster, [evidence.raster.cells(p.box) for p in _places(evidence, [True] * 12)]
    lights = [(r.start, c.start, r.stop, c.stop) for r, c in cells]
    width = lights[1][3] - lights[0][1]
    pairs = [raster.box(*light) for light in lights[:22]]
    for start in range(1, 60):
        wider = raster.box(lights[22][0], start, lights[22][2], start + width + 2)
        places = [Place(b, 1.0, evidence) for b in [*pairs, wider]]
        assert wider not in [p.box for p in divided_alike(places)], start


def test_lights_as_wide_as_other_windows_are_still_joined():
    evidence = _evidence(False)
    wide = _places(evidence, np.arange(12) == 5)
    narrow = _places(evidence, [True] * 12)[2::2]  # the left lights of all others but the first
    del narrow[4]
    x, z, half = COLUMNS[0], FLOORS[0], (LIGHT - BAR) / 2
    pair = [Place((a, z, a + half, z + HIGH), 1.0, evidence) for a in (x, x + half + BAR)]
    found = _boxes(divided_alike([*wide, *narrow, *pair]))
    assert (np.ptp(found[:, ::2], axis=1) > 2 * LIGHT).sum() == 12
