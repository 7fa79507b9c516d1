"""Openings side by side without masonry between them."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from frontage.openings import OpeningOptions, find_openings
from fronts import EYE, box_of, scan_wall

BOTH = (1.0, 0.4, 5.0, 3.0)
FRAME = 0.06  # m, width of a frame
NEAR, FAR = 0.08, 0.22  # m, depths


def found(depth_of, rays=True, mirrored=False):
    """Returns the boxes of what is found where beams end `depth_of(x, z)` m behind the wall in one hole."""
    walls = {d: scan_wall([BOTH], depth=d, rays=rays, spacing=0.02) for d in (NEAR, FAR, 0.6)}
    facade, scan = walls[NEAR]
    xyz = []
    for d, (_, cloud) in walls.items():
        p = cloud.xyz
        way = (0.0 - EYE[1]) / (p[:, 1] - EYE[1])  # to where a beam crosses the wall
        x, _, z = (EYE + (p - EYE) * way[:, None]).T
        xyz.append(p[depth_of(x, z) == d])
    points = np.vstack(xyz)
    known = {"origin_index": np.zeros(len(points), np.int32)} if rays else {"origin_index": None}
    if mirrored:
        points = points * [-1.0, 1.0, 1.0] + [7.0, 0.0, 0.0]
    origins = scan.origins * [-1.0, 1.0, 1.0] + [7.0, 0.0, 0.0] if mirrored else scan.origins
    index = np.arange(len(points))
    facade = replace(facade, support=index, inliers=index)
    openings = find_openings(facade, replace(scan, xyz=points, origins=origins, **known), OpeningOptions())
    boxes = [box_of(o) for o in openings.openings]
    return sorted(([7.0 - b[2], b[1], 7.0 - b[0], b[3]] if mirrored else b.tolist()) for b in boxes)


def framed(x, z):
    """Tells which places lie on the frame around the hole."""
    x0, z0, x1, z1 = BOTH
    return (x < x0 + FRAME) | (x > x1 - FRAME) | (z > z1 - FRAME) | (z < z0 + FRAME)


@pytest.mark.parametrize("rays", [True, False])
@pytest.mark.parametrize("mirrored", [True, False])
@pytest.mark.parametrize("steps", [(3.8,), (2.0, 3.4)])
def test_units_whose_frames_lie_at_different_depths_are_parted(steps, mirrored, rays):
    boxes = found(lambda x, _: np.where(np.searchsorted(steps, x) == 1, NEAR, FAR), rays, mirrored)
    ends = [BOTH[0], *steps, BOTH[2]]
    expected = [(a, BOTH[1], b, BOTH[3]) for a, b in pairwise(ends)]
    np.testing.assert_allclose(boxes, expected, atol=0.03)


@pytest.mark.parametrize("rays", [True, False])
def test_an_open_casement_or_a_curtain_does_not_part_a_window(rays):
    boxes = found(lambda x, z: np.where(framed(x, z) | (x < 3.0), NEAR, 0.6), rays)
    np.testing.assert_allclose(boxes, [BOTH], atol=0.03)
