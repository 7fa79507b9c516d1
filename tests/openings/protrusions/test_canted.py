"""Bays with slanting faces, shop fronts under a fascia, surrounds, pilasters: which are walls."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from frontage.openings import FoundOpenings, OpeningOptions, find_openings
from frontage.openings.protrusions.beams import FacadeBeams
from frontage.openings.protrusions.find import find_protrusions
from frontage.openings.protrusions.pieces import Piece, _cheek
from frontage.openings.protrusions.resolution import Resolution
from frontage.openings.wall.beams import sort_beams
from frontage.openings.wall.evidence import weigh
from openings.boxes import box, scanned
from openings.faces import face, scanned_faces

WALL = box(0, 8, 0.0, 0.3, 0, 9)


def canted(out, run):
    """A wall with a bay of three faces from 2.4 to 5.6 m: 'out' m before it, cheeks `run` m wide in plan."""
    a, b = 2.4 + run, 5.6 - run
    window = (b - a) / 2 - 0.4, 3.6, (b - a) / 2 + 0.4, 5.2
    wide = float(np.hypot(out, run))
    cheek = (0.25, 3.6, wide - 0.25, 5.2)
    bay = [face((a, -out), (b, -out), 0, 6.5, [window]), face((2.4, 0), (a, -out), 0, 6.5, [cheek])]
    bay += [
        face((b, -out), (5.6, 0), 0, 6.5, [cheek]),
        face((a + 0.1, 0.12 - out), (b - 0.1, 0.12 - out), 3.5, 3.7),
    ]
    room = [face((2.5, 3.0), (5.5, 3.0), 0, 6.5)]
    walls = [face((0, 0), (2.4, 0), 0, 9), face((5.6, 0), (8, 0), 0, 9), face((2.4, 0), (5.6, 0), 6.5, 9)]
    return [q for f in (*bay, *room, *walls) for q in f], (a + window[0], 3.6, a + window[2], 5.2)


@pytest.mark.parametrize(("out", "run"), [(0.8, 0.8), (0.6, 0.9)])
def test_a_bay_of_three_faces_with_windows_in_all_of_them(out, run):
    faces, window = canted(out, run)
    result = find_openings(*scanned_faces(faces, (8.0, 9.0)), OpeningOptions(ground_z=0.0))
    assert isinstance(result, FoundOpenings)
    (bay,) = [p for p in result.protrusions if p.kind == "bay"]
    x0, z0, x1, z1 = np.ravel([bay.ring.min(0), bay.ring.max(0)])
    assert (x0, x1, z1) == pytest.approx((2.4, 5.6, 6.5), abs=0.02)
    assert 0.0 <= z0 < 0.12  # no beam aims lower
    assert bay.front.value == pytest.approx(-out, abs=0.01)
    (found,) = result.openings
    assert found.on == bay.id
    assert np.ravel([found.ring.min(0), found.ring.max(0)]) == pytest.approx(window, abs=0.02)


def test_a_fascia_is_no_tier_of_the_shop_front_below_it():
    parts = [box(0.5, 7.5, -0.12, 0, 0, 3.0), box(0.5, 7.5, -0.3, 0, 3.0, 3.5)]
    facade, scan = scanned(parts)
    found = find_protrusions(facade, FacadeBeams.of(facade, scan), (), 0.0)
    fronts = {p.kind: float(p.front.value) for p in found}
    assert fronts == {"risalit": pytest.approx(-0.12, abs=0.01), "band": pytest.approx(-0.3, abs=0.01)}


def test_the_surround_of_a_window_is_no_oriel():
    sides = [box(3, 3.2, -0.12, 0, 3, 5.4), box(4.4, 4.6, -0.12, 0, 3, 5.4)]
    ends = [box(3, 4.6, -0.12, 0, 3, 3.2), box(3, 4.6, -0.12, 0, 5.2, 5.4)]
    wall = [box(0, 3.2, 0, 0.3, 0, 9), box(4.4, 8, 0, 0.3, 0, 9), box(3.2, 4.4, 0, 0.3, 0, 3.2)]
    wall += [box(3.2, 4.4, 0, 0.3, 5.2, 9), box(3.2, 4.4, 0.15, 0.3, 3.2, 5.2)]
    result = find_openings(*scanned([*sides, *ends], wall=wall), OpeningOptions(ground_z=0.0))
    assert isinstance(result, FoundOpenings)
    assert [p.kind for p in result.protrusions] == ["protrusion"]
    (found,) = result.openings
    assert np.ravel([found.ring.min(0), found.ring.max(0)]) == pytest.approx((3.2, 3.2, 4.4, 5.2), abs=0.02)


def test_pilasters_under_a_cornice_are_no_bay_with_the_wall_between_them():
    parts = [box(2.0, 2.3, -0.13, 0, 0, 8.6), box(5.4, 5.7, -0.13, 0, 0, 8.6), box(0, 8, -0.16, 0, 8.6, 9)]
    facade, scan = scanned(parts, spacing=0.09)
    found = find_protrusions(facade, FacadeBeams.of(facade, scan), (), 0.0)
    assert not {"bay", "oriel", "risalit"} & {p.kind for p in found}


def test_pilasters_that_a_sill_joins_are_no_avant_corps():
    parts = [box(x, x + 0.5, -0.12, 0, 0, 7.0) for x in (0.8, 3.8, 6.8)]
    parts += [box(0.8, 7.3, -0.12, 0, 2.0, 2.12)]
    facade, scan = scanned(parts)
    found = find_protrusions(facade, FacadeBeams.of(facade, scan), (), 0.0)
    pilasters = [p for p in found if p.kind == "pilaster"]
    assert [float(p.ring[:, 0].min()) for p in pilasters] == pytest.approx([0.8, 3.8, 6.8], abs=0.02)
    assert not any(p.kind.is_wall for p in found)


def test_pilasters_of_a_mirrored_wall_have_the_same_borders():
    parts = [box(x, x + wide, -0.12, 0, 0, 7.0) for x, wide in ((0.83, 0.47), (3.71, 0.61), (6.84, 0.4))]
    parts += [box(0.83, 7.24, -0.12, 0, 2.0, 2.12)]
    facade, scan = scanned(parts)
    side = np.array([-1.0, 1.0, 1.0])
    mirror = replace(scan, xyz=scan.xyz * side, origins=scan.origins * side)
    swapped = replace(facade, outline=facade.outline[::-1] * side[:2])
    before = find_protrusions(facade, FacadeBeams.of(facade, scan), (), 0.0)
    after = find_protrusions(swapped, FacadeBeams.of(swapped, mirror), (), 0.0)
    borders = [np.ravel([p.ring.min(0), p.ring.max(0)]) for p in before]
    mirrored = [np.ravel([p.ring.min(0), p.ring.max(0)])[[2, 1, 0, 3]] * [-1, 1, -1, 1] for p in after]
    assert np.allclose(sorted(map(tuple, borders)), sorted(map(tuple, mirrored)), atol=1e-6)


@pytest.mark.parametrize(("hidden", "is_cheek"), [((-1.5, -1.2), True), ((-1.7, -0.4), False)])
def test_a_cheek_shows_on_most_of_its_way_to_the_wall(hidden, is_cheek):
    """The receding side of a column and a pier far behind it may lie on one line by chance."""
    rng = np.random.default_rng(0)
    y = rng.uniform(-1.9, -0.1, 4000)
    y = y[(y < hidden[0]) | (y > hidden[1])]
    s = 0.2 + 0.6 * (y + 1.9) + rng.normal(0.0, 0.002, len(y))
    piece = Piece(np.arange(0), np.arange(0), (-0.2, 0.0, 0.2, 6.0), -1.9)
    resolution = Resolution(0.02, 0.004, 0.02, np.empty((0, 3)))
    assert (_cheek(y, s, piece, 0.2, resolution) is not None) == is_cheek


def test_the_shadow_of_a_hood_is_unknown_not_open():
    facade, scan = scanned([box(2, 6, -0.25, 0, 6.0, 6.15)], eyes=((4.0, -4.0, 1.6),))
    evidence = weigh(facade, sort_beams(facade, scan))
    shadow, wall = (
        slice(*(int(z / evidence.raster.cell) for z in rows)) for rows in ((6.2, 6.4), (6.5, 6.8))
    )
    columns = slice(int(2.5 / evidence.raster.cell), int(5.5 / evidence.raster.cell))
    assert abs(evidence.llr[shadow, columns].mean()) < 0.1  # a nat a cell where missing beams count
    assert evidence.llr[wall, columns].mean() < -2.0


def test_windows_under_an_awning_that_hides_no_wall_keep_their_height():
    # nothing comes back from their panes, and without sensors the awning might hide all below it
    awning = box(1.0, 7.0, -0.9, 0.0, 5.3, 5.4)
    holes = [(1.6, 2.6), (3.5, 4.5), (5.4, 6.4)]
    x = [0.0, *np.ravel(holes), 8.0]
    wall = [box(a, b, 0, 0.3, 3.0, 5.0) for a, b in zip(x[::2], x[1::2], strict=True)]
    wall += [box(0, 8, 0, 0.3, 0, 3.0), box(0, 8, 0, 0.3, 5.0, 9)]
    frames = [box(a, b, 0.1, 0.15, 4.9, 5.0) for a, b in holes]
    facade, scan = scanned([awning], wall=wall + frames, rays=False, eyes=((4.0, -9.0, 1.6),))
    result = find_openings(facade, scan, OpeningOptions(ground_z=0.0))
    assert isinstance(result, FoundOpenings)
    rings = sorted((*o.ring.min(0), *o.ring.max(0)) for o in result.openings)
    assert np.allclose(rings, [(a, 3.0, b, 5.0) for a, b in holes], atol=0.05)


def test_a_shop_front_of_ten_metres_is_found():
    posts = (0.8, 3.3, 5.8, 8.3, 10.8)
    holes = [(a + 0.04, 0.6, b - 0.04, 2.9) for a, b in pairwise(posts)]
    faces = face((0, 0), (11.6, 0), 0, 6, holes) + face((0, 1.5), (11.6, 1.5), 0.1, 3.2)
    facade, scan = scanned_faces(faces, (11.6, 6.0), spacing=0.06, eyes=((3.0, -8.0, 1.6), (8.0, -8.0, 1.6)))
    result = find_openings(facade, scan, OpeningOptions(ground_z=0.0))
    assert isinstance(result, FoundOpenings)
    rings = [np.ravel([o.ring.min(0), o.ring.max(0)]) for o in result.openings]
    assert min(r[0] for r in rings) == pytest.approx(0.84, abs=0.05)
    assert max(r[2] for r in rings) == pytest.approx(10.76, abs=0.05)
    assert sum((r[2] - r[0]) * (r[3] - r[1]) for r in rings) > 0.9 * 9.92 * 2.3
