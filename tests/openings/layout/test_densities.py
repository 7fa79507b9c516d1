"""Walls that are scanned more sparsely on one side: what is found there, and how well it is measured."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.openings import FoundOpenings, find_openings
from frontage.openings.borders.measure import measure
from frontage.openings.layout.densities import find_at_densities, spacing_at, wider_cells
from frontage.openings.options import OpeningOptions
from frontage.openings.wall.beams import sort_beams
from frontage.openings.wall.crossings import crossing_beams
from frontage.openings.wall.evidence import weigh
from openings.boxes import scanned, with_points
from openings.joinery import framed, wall

DENSE, SPARSE = (0.8, 4.0, 1.9, 6.0), (5.8, 4.0, 6.9, 6.0)
FINE, COARSE = 0.02, 0.12  # m between the points of the left half and of the right one


def _half_sparse(seed=0):
    """A wall with two windows, of which one lies where one point in 36 is left."""
    boxes = [b for w in (DENSE, SPARSE) for b in framed(w, 0.15)]
    solids = [*wall([DENSE, SPARSE]), *boxes]
    facade, scan = scanned(wall=solids, spacing=FINE, rays=False, eyes=((4.0, -10.0, 1.6),))
    x, rng = scan.xyz[:, 0], np.random.default_rng(seed)
    return with_points(facade, scan, (x < 4.0) | (rng.uniform(size=len(x)) < (FINE / COARSE) ** 2))


@pytest.mark.parametrize("seed", range(4))
def test_a_window_is_found_where_few_points_are_left(seed):
    found = find_openings(*_half_sparse(seed))
    assert isinstance(found, FoundOpenings)
    places = np.array([np.concatenate([o.ring.min(0), o.ring.max(0)]) for o in found.openings])
    assert len(places) == 2
    assert np.abs(places[0] - DENSE).max() < 0.02
    assert np.abs(places[1] - SPARSE).max() < 2.0 * COARSE


def test_cells_widen_only_where_a_part_of_the_wall_is_sparse():
    facade, scan = _half_sparse()
    found = find_openings(facade, scan)
    assert isinstance(found, FoundOpenings)
    evidence = found.evidence.evidence
    assert len(wider_cells(evidence)) > 0
    even = replace(evidence, expected_free=np.full_like(evidence.expected_free, 2.0))
    assert wider_cells(even) == []


def test_the_spacing_is_that_of_the_place():
    facade, scan = _half_sparse()
    found = find_openings(facade, scan)
    assert isinstance(found, FoundOpenings)
    left, right = spacing_at([DENSE, SPARSE], found.evidence.evidence, facade.spacing)
    assert left == pytest.approx(facade.spacing)
    assert right == pytest.approx(COARSE / 2, rel=0.3)
    assert spacing_at([], found.evidence.evidence, facade.spacing) == []


@pytest.mark.parametrize(("hidden", "expected"), [(SPARSE, 2), (DENSE, 1)])
def test_wide_cells_add_what_fine_ones_miss_where_the_wall_is_sparse(hidden, expected):
    facade, scan = _half_sparse()
    beams = sort_beams(facade, scan)
    fine, wide = weigh(facade, beams), weigh(facade, beams, scale=4.0)
    z, x = (np.indices(fine.llr.shape) + 0.5) * fine.raster.cell + np.reshape(
        fine.raster.corner[::-1], (2, 1, 1)
    )
    blind = (x > hidden[0] - 0.3) & (x < hidden[2] + 0.3) & (z > hidden[1] - 0.3) & (z < hidden[3] + 0.3)
    missed = replace(fine, llr=np.where(blind, 0.0, fine.llr))
    found = find_at_densities([[missed], [wide]], OpeningOptions(), 0.0)
    assert len(found) == expected
    seen = [p for p in found if p.evidence is missed]
    assert len(seen) == 1 and (seen[0].box[0] < 4.0) == (hidden is SPARSE)
    added = [p.box for p in found if p.evidence is wide]
    assert np.abs(np.reshape(added, (-1, 4)) - SPARSE).max(initial=0.0) < 0.25


@pytest.mark.parametrize("seed", range(4))
def test_borders_are_found_two_spacings_off_where_the_wall_is_sparse(seed):
    facade, scan = _half_sparse(seed)
    beams = crossing_beams(facade, scan, sort_beams(facade, scan))
    rough = (SPARSE[0] - 0.2, SPARSE[1], SPARSE[2] + 0.2, SPARSE[3])
    (measured,) = measure(beams, [rough], 2.0 * FINE, COARSE)
    assert abs(measured.place[0] - SPARSE[0]) < 0.1 and abs(measured.place[2] - SPARSE[2]) < 0.1
