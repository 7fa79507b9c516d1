"""Thinned clouds do not depend on the order of the points."""

import numpy as np

from frontage.pipeline.clouds import thin


def test_every_voxel_keeps_the_same_point_in_whatever_order_they_come():
    rng = np.random.default_rng(1)
    xyz = rng.uniform(0.0, 1.0, (5000, 3))
    kept = thin(xyz, 0.2)
    order = rng.permutation(len(xyz))
    assert len(kept) == 125
    assert np.array_equal(np.sort(order[thin(xyz[order], 0.2)]), kept)
    assert len(thin(xyz[:0], 0.2)) == 0
