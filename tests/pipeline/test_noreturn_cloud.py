"""A building's working cloud keeps the beams without return that look at it, and no others."""

import numpy as np

from frontage.model import merge_scans
from frontage.pipeline.clouds import Neighbourhoods, working_cloud
from raster_scans import scan_raster, within


def test_a_building_keeps_the_lost_beams_that_look_at_it():
    left, right = within((1.0, 1.0, 3.0, 4.0)), within((7.0, 1.0, 9.0, 4.0))
    scan = merge_scans([scan_raster(lambda x, z: left(x, z) | right(x, z), step=0.006)[0]])
    index = np.flatnonzero((scan.xyz[:, 1] > -0.1) & (scan.xyz[:, 0] > 6.0) & (scan.xyz[:, 2] > 0.1))
    cloud, own = working_cloud(scan, Neighbourhoods(scan.xyz), index)
    assert len(own) == len(index)
    (lost,) = cloud.no_returns
    d = lost.directions
    at = scan.origins[0] - d * (scan.origins[0, 1] / d[:, 1])[:, None]
    assert right(at[:, 0], at[:, 2]).any() and not left(at[:, 0], at[:, 2]).any()
    assert lost.ground == scan.no_returns[0].ground
    assert lost.lost.size < 0.6 * scan.no_returns[0].lost.size
