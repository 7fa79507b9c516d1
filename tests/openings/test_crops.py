"""Pieces of real fronts show the openings that lie inside: the rest of a front tells much, but not all."""

import json

import numpy as np
import pytest
from shapely.geometry import Polygon, box

from frontage.buildings.find import find_buildings
from frontage.facades.find import find_facades
from frontage.io.scans.read import read_scans
from frontage.model import Facade
from frontage.model.scan import merge_scans
from frontage.openings import FoundOpenings, find_openings
from realdata import data_path


def found_in(scan):
    """Yields the rings (k, 3) m local of all openings."""
    for building in find_buildings(scan).buildings:
        for facade in (f for f in find_facades(scan, building) if isinstance(f, Facade)):
            openings = find_openings(facade, scan)
            for opening in openings.openings if isinstance(openings, FoundOpenings) else ():
                yield facade.frame.apply(np.insert(opening.ring, 1, 0.0, axis=1))


@pytest.mark.parametrize(("left", "right", "top"), [(18.5, 33.6, 11.8), (14.5, 31.6, 11.75)])
def test_the_lower_storey_of_the_museum_keeps_its_windows_without_the_upper_one(left, right, top):
    # a crop that ends among the windows of the upper storey, whose wall stands back
    truth = json.loads(data_path("truth/museum_south.json").read_text("utf-8"))
    scan = merge_scans(read_scans(data_path("museum_south/museum_south.laz")))
    axes, origin = np.array(truth["frame"]["axes_rows_XYZ"]), np.array(truth["frame"]["origin"])

    def flat(xyz):
        return (scan.world.to_world(xyz) - origin) @ axes.T

    x, _, z = flat(scan.xyz).T
    piece = scan.take(np.flatnonzero((x > left) & (x < right) & (z < z.min() + top)))
    rings = [Polygon(flat(ring)[:, [0, 2]]) for ring in found_in(piece)]
    asked = [o for o in truth["openings"] if left + 0.3 < o["x0"] and o["x1"] < right - 0.3]
    asked = [box(o["x0"], o["z0"], o["x1"], o["z1"]) for o in asked if o["z1"] < z.min() + top]
    assert len(asked) == 2
    for one in asked:
        best = max(one.intersection(ring).area / one.union(ring).area for ring in rings)
        assert best > 0.75
