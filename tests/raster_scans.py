"""A wall y = 0 scanned by polar rasters, where the test decides which beams come back.

This analytic toy stays beside `frontage.simulate` because tests of lost beams choose each of them.
"""

import numpy as np

from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.model.estimate import Estimate, Provenance
from frontage.model.facade import Facade
from frontage.model.scan import Grid, Scan
from frontage.model.world import WorldRef

SIZE = (10.0, 6.0)
EYE = (4.0, -9.0, 1.6)
WORLD = WorldRef(np.zeros(3, np.int64))


def tilted(eye=EYE, degrees=4.0):
    """Returns the pose of a badly levelled scanner that looks at the wall."""
    a = np.radians(degrees)
    R = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(a), -np.sin(a)], [0.0, np.sin(a), np.cos(a)]])
    return Rigid3("local", "scanner", R, np.array(eye))


def beams(pose, step=0.004):
    """Returns unit directions (h, w, 3) of a polar raster, local frame; `step` rad."""
    azimuth = np.radians(90) + np.arange(np.radians(50), -np.radians(50), -step)
    elevation = np.arange(np.radians(-20), np.radians(42), step)
    e, a = np.meshgrid(elevation, azimuth, indexing="ij")
    return pose.rotate(
        np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], -1).reshape(-1, 3)
    ).reshape(*e.shape, 3)


def scan_raster(lost, pose=None, step=0.004, noise=0.002, seed=0, street=True):
    """Returns a structured scan of the wall and the directions of its lost beams, where `lost(x, z)`.

    Without `street` the points on the ground are cut away.
    """
    pose = pose or tilted()
    d = beams(pose, step)
    with np.errstate(divide="ignore"):
        way = np.where(d[..., 1] > 1e-3, -pose.t[1] / d[..., 1], np.inf)
    x, z = pose.t[0] + way * d[..., 0], pose.t[2] + way * d[..., 2]
    met = (x > 0) & (x < SIZE[0]) & (z > 0) & (z < SIZE[1]) & np.isfinite(way)
    ground = (z <= 0) | (d[..., 2] < 0) & ~met
    with np.errstate(divide="ignore"):
        way = np.where(ground, -pose.t[2] / d[..., 2], way)
    back = (met & ~lost(x, z)) | (ground & street)
    index = np.full(back.shape, -1, np.int64)
    index[back] = np.arange(back.sum())
    far = way[back] + np.random.default_rng(seed).normal(0, noise, back.sum())
    given = Estimate(pose, np.zeros((6, 6)), 0.0, Provenance.GIVEN)
    scan = Scan(
        "station", pose.t + far[:, None] * d[back], WORLD, pose.t[None], np.zeros(back.sum(), np.int32),
        grid=Grid(index), local_from_scanner=given,
    )  # fmt: skip
    return scan, d[met & ~back]


def facade_of(scan, spacing=0.05):
    """Returns the wall as a facade of the scan."""
    pose = Estimate(Rigid3("local", "facade", np.eye(3), np.zeros(3)), np.eye(6) * 1e-8, 100.0)
    index = np.flatnonzero((np.abs(scan.xyz[:, 1]) < 0.1) & (scan.xyz[:, 2] > 0.0))
    ring = rectangle(0, 0, *SIZE)
    return Facade("B01/F1", "B01", pose, WORLD, ring, (), index, index, 0.003, spacing, 0.9, "rays")


def within(box):
    """Returns a function that tells whether places (x, z) lie in the box x0, z0, x1, z1."""
    return lambda x, z: (x > box[0]) & (x < box[2]) & (z > box[1]) & (z < box[3])
