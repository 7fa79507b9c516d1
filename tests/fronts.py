"""A flat wall with rectangular openings, scanned from one place.

This analytic toy stays beside `frontage.simulate` because unit tests of the openings need holes of chosen
size, spacing, reveal and share of returns at once, in milliseconds and without anything else in the scene.
"""

import numpy as np

from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.model.estimate import Estimate
from frontage.model.facade import Facade
from frontage.model.scan import Scan
from frontage.model.world import WorldRef

WINDOW = (1.0, 2.0, 2.2, 3.6)
DOOR = (4.0, 0.0, 5.1, 2.2)
EYE = np.array([3.0, -8.0, 1.7])


def scan_wall(holes, *, spacing=0.02, depth=0.15, rays=True, returned=1.0, seed=0, size=(7.0, 5.0)):
    """Returns the facade y = 0 and its scan from EYE; points in the facade frame, m.

    Beams end on the wall, on a pane `depth` m behind each of the `holes` (x0, z0, x1, z1), or on the reveal.
    `returned` is the share of the beams into holes that come back; without `rays` the scan has no station.
    """
    rng = np.random.default_rng(seed)
    x, z = np.meshgrid(np.arange(0, size[0], spacing), np.arange(0, size[1], spacing))
    p = np.column_stack([x.ravel(), np.zeros(x.size), z.ravel()])
    p[:, [0, 2]] += rng.uniform(-spacing / 2, spacing / 2, (len(p), 2))
    inside, step = np.zeros(len(p), bool), np.zeros(len(p))
    for x0, z0, x1, z1 in holes:
        inside |= (p[:, 0] > x0) & (p[:, 0] < x1) & (p[:, 2] > z0) & (p[:, 2] < z1)
        # A beam ends on the reveal where it meets the reveal before the pane.
        way = p[:, [0, 2]] - EYE[[0, 2]]
        wall = np.where(way > 0, [x1, z1], [x0, z0]) - p[:, [0, 2]]
        here = (p[:, 0] > x0) & (p[:, 0] < x1) & (p[:, 2] > z0) & (p[:, 2] < z1)
        step = np.where(here, np.minimum(depth / 8.0, (wall / way).min(1)), step)
    p += (p - EYE) * step[:, None]
    p[:, 1] += rng.normal(0, 0.003, len(p))
    p = p[~inside | (rng.random(len(p)) < returned)]
    world = WorldRef(np.zeros(3, np.int64))
    known = {"origins": EYE[None], "origin_index": np.zeros(len(p), np.int32)} if rays else {}
    pose = Estimate(Rigid3("local", "facade", np.eye(3), np.zeros(3)), np.eye(6) * 1e-8, 100.0)
    index = np.arange(len(p))
    facade = Facade(
        "B01/F1", "B01", pose, world, rectangle(0, 0, *size), (), index, index, 0.003, spacing, 0.9, "rays"
    )
    return facade, Scan("wall", p, world, **known)


def box_of(opening):
    """Returns the bounding box x0, z0, x1, z1 (4,) of an opening, m."""
    return np.concatenate([opening.ring.min(0), opening.ring.max(0)])
