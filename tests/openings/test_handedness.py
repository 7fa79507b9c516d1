"""Real scans that are mirrored or turned show the same openings: neither left nor north decides anything."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.buildings.find import find_buildings
from frontage.facades.find import find_facades
from frontage.io.scans.read import read_scans
from frontage.model import Facade
from frontage.model.scan import merge_scans
from frontage.openings import FoundOpenings, find_openings
from realdata import data_path

MIRRORED = np.diag([-1.0, 1.0, 1.0])
TURNED = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])


def corners(scan, axes):
    """Returns the lower and upper corners (n, 6) m of the openings of a moved scan, in its place before."""
    moved = replace(scan, xyz=scan.xyz @ axes.T, origins=scan.origins @ axes.T, grid=None, no_returns=())
    found = []
    for building in find_buildings(moved).buildings:
        for facade in (f for f in find_facades(moved, building) if isinstance(f, Facade)):
            openings = find_openings(facade, moved)
            if isinstance(openings, FoundOpenings):
                boxes = [np.insert(o.ring, 1, 0.0, axis=1) for o in openings.openings]
                places = [facade.frame.apply(ring) @ axes for ring in boxes]
                found += [[*p.min(0), *p.max(0)] for p in places]
    return np.array(sorted(np.round(found, 2).tolist()))


@pytest.mark.parametrize(
    ("path", "axes"),
    [
        ("lille_mobile/Lille_street_small.ply", TURNED),
        ("lille_mobile/Lille_street_small.ply", MIRRORED),
        ("church_tower/church_tower.laz", MIRRORED),
    ],
)
def test_a_moved_scan_shows_the_same_openings(path, axes):
    scan = merge_scans(read_scans(data_path(path)))
    before, after = corners(scan, np.eye(3)), corners(scan, axes)
    assert len(before) == len(after)
    assert all(np.abs(after - one).max(1).min() < 0.03 for one in before)
