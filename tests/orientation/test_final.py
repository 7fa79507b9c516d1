"""Placed photos are adjusted together with control from the scan, and each is judged."""

import numpy as np

from frontage.geometry.rigid import rotation_angle
from frontage.orientation.final import adjusted_orientation
from frontage.orientation.network import TiePoints
from frontage.orientation.placed import Placed, Scene
from frontage.orientation.reflectance.surface import scanned_surface
from orientation.paintedwalls import LANDSCAPE, corner_of_two, looking, photograph, posed, scan_of


def test_ties_that_the_scan_contradicts_are_not_in_the_final_network():
    walls, rng = corner_of_two(), np.random.default_rng(4)
    photos = [posed(looking(x, y), name=f"{x}.jpg") for x, y in ((2.5, -7.5), (5.0, -8.0))]
    images = {p.id: photograph(walls, p, seed=k) for k, p in enumerate(photos)}
    xyz = np.concatenate([wall.points(0.3, rng, 0.0)[0] for wall in walls])
    false = rng.random(len(xyz)) < 0.1
    xyz[false] += 0.1 * (photos[0].pose.t - xyz[false])  # before the wall; their rays meet all the same
    pixels = np.stack([p.project(xyz) for p in photos])
    seen = ((pixels > 0) & (pixels < (LANDSCAPE.width, LANDSCAPE.height))).all((0, 2))
    xyz, pixels = xyz[seen], pixels[:, seen]
    photo, point = (a.ravel() for a in np.indices(pixels.shape[:2]))
    ties = TiePoints(xyz, photo, point, pixels.reshape(-1, 2) + rng.normal(0, 0.1, (len(photo), 2)))
    scene = Scene(photos, scanned_surface(scan_of(walls, 0.04)), images.__getitem__, (), 0, lambda _: None)
    got = adjusted_orientation(scene, Placed(np.array([0, 1]), tuple(photos), ties), [])
    assert [o.photo.id for o in got.photos] == [p.id for p in photos] and false[seen].sum() > 10
    before_wall = np.minimum(-got.points[:, 1], 12.0 - got.points[:, 0])
    assert len(got.points) > 0.9 * (~false[seen]).sum() and before_wall.max() < 0.1
    for o, true in zip(got.photos, photos, strict=True):
        assert np.linalg.norm(o.photo.pose.t - true.pose.t) < 0.01
        assert rotation_angle(o.photo.pose.R @ true.pose.R.T) < np.radians(0.05)
