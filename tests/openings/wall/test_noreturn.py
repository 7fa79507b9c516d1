"""Beams without return as evidence: glass that swallows all of them, walls that lose some."""

from dataclasses import replace

import numpy as np

from frontage.model.scan import merge_scans
from frontage.openings import find_openings
from frontage.openings.wall.beams import sort_beams
from frontage.openings.wall.evidence import weigh
from frontage.openings.wall.noreturn import lost_beam_places, with_lost_beams
from raster_scans import facade_of, scan_raster, within

FRONT = (1.5, 0.2, 8.0, 5.0)  # m, wider than what is taken for the end of a scan


def evidence_of(scan):
    facade = facade_of(scan)
    beams = sort_beams(facade, scan)
    return with_lost_beams(weigh(facade, beams), facade, scan, beams)


def amid(evidence, box):
    """The cells well within a box."""
    (x, z), g = evidence.raster.corner, evidence.raster.cell
    x0, z0, x1, z1 = (int((v - o) / g) for v, o in zip(box, (x, z, x, z), strict=True))
    return slice(z0 + 3, z1 - 3), slice(x0 + 3, x1 - 3)


def test_lost_beams_lie_where_nothing_came_back():
    scan = merge_scans([scan_raster(within(FRONT), step=0.006)[0]])
    facade = facade_of(scan)
    places = lost_beam_places(facade, scan, sort_beams(facade, scan))
    inner = places[((places > 0.1) & (places < (9.9, 5.9))).all(1)]  # not those that passed beside the wall
    assert len(inner) > 1000
    assert (np.abs(inner - np.clip(inner, FRONT[:2], FRONT[2:])) < 0.01).all()


def test_a_front_of_glass_that_returns_nothing_is_open_not_unseen():
    scan = merge_scans([scan_raster(within(FRONT), step=0.006)[0]])
    cells = amid(evidence_of(scan), FRONT)
    known, unknown = evidence_of(scan), evidence_of(replace(scan, no_returns=()))
    assert (known.llr[cells] > 0).mean() > 0.95 and known.seen[cells].mean() > 0.8
    assert not unknown.llr[cells].any() and not unknown.seen[cells].any()
    (opening,) = find_openings(facade_of(scan), scan).openings
    assert np.abs(np.r_[opening.ring.min(0), opening.ring.max(0)] - FRONT).max() < 0.05
    assert not find_openings(facade_of(scan), replace(scan, no_returns=())).openings


def test_what_a_wall_loses_everywhere_is_no_evidence():
    rng = np.random.default_rng(0)
    scan = merge_scans([scan_raster(lambda x, z: rng.random(x.shape) < 0.4, step=0.006)[0]])
    told, quiet = evidence_of(scan), evidence_of(replace(scan, no_returns=()))
    np.testing.assert_allclose(told.llr, quiet.llr, atol=0.5)
    assert not find_openings(facade_of(scan), scan).openings


def test_where_points_were_cut_out_lost_beams_tell_nothing():
    scan = merge_scans([scan_raster(within(FRONT), step=0.006, street=False)[0]])
    quiet = evidence_of(replace(scan, no_returns=()))
    told = evidence_of(scan)
    for name in ("llr", "expected", "expected_free", "seen"):
        np.testing.assert_array_equal(getattr(told, name), getattr(quiet, name))
    assert not find_openings(facade_of(scan), scan).openings


def test_clouds_without_raster_are_weighed_as_before():
    scan = merge_scans([scan_raster(within((3.0, 1.0, 4.2, 2.8)), step=0.006)[0]])
    bare = replace(scan, no_returns=())
    facade = facade_of(bare)
    beams = sort_beams(facade, bare)
    assert len(lost_beam_places(facade, bare, beams)) == 0
    before = weigh(facade, beams)
    assert with_lost_beams(before, facade, bare, beams) is before
