"""Ties on what was not scanned may outnumber control points, but they do not outvote them."""

from types import SimpleNamespace

import numpy as np
import pytest

from frontage.geometry.rigid import Rigid3
from frontage.orientation.final import adjusted_orientation
from frontage.orientation.network import CONTROL, TIES, TiePoints
from frontage.orientation.outvoted import most_outvoted
from frontage.orientation.placed import Placed, Scene
from frontage.orientation.reflectance.surface import scanned_surface
from orientation.paintedwalls import LANDSCAPE, Wall, looking, paint, photograph, posed, scan_of

FRONT = Wall((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), paint(12.0, 4.0))


def moved(pose, metres):
    """A pose moved along x."""
    return Rigid3(pose.to, pose.frm, pose.R, pose.t + np.array([metres, 0.0, 0.0]))


def above_the_wall(photos, rng):
    """Tie points between photos on what stands above the wall and was not scanned."""
    xyz = rng.uniform((2.0, -2.0, 4.3), (10.0, 3.0, 7.0), (2500, 3))
    pixels = np.stack([p.project(xyz) for p in photos])
    seen = ((pixels > 0) & (pixels < (LANDSCAPE.width, LANDSCAPE.height))).all((0, 2))
    xyz, pixels = xyz[seen], pixels[:, seen]
    photo, point = (a.ravel() for a in np.indices(pixels.shape[:2]))
    return TiePoints(xyz, photo, point, pixels.reshape(-1, 2) + rng.normal(0, 0.1, (len(photo), 2)))


def test_a_photo_that_ties_hold_beside_its_place_is_brought_to_it_by_its_control():
    true = [posed(looking(x, -8.0), name=f"{x}.jpg") for x in (4.0, 6.0, 8.0)]
    images = {p.id: photograph((FRONT,), p, seed=k) for k, p in enumerate(true)}
    placed = [posed(moved(true[0].pose, 0.15), name=true[0].id), *true[1:]]
    ties = above_the_wall(placed, np.random.default_rng(5))
    assert len(ties.xyz) > 500
    scene = Scene(placed, scanned_surface(scan_of((FRONT,), 0.04)), images.__getitem__, (), 0, lambda _: None)
    got = adjusted_orientation(scene, Placed(np.arange(3), tuple(placed), ties), [])
    assert [o.photo.id for o in got.photos] == [p.id for p in true]
    for o, t in zip(got.photos, true, strict=True):
        assert np.linalg.norm(o.photo.pose.t - t.pose.t) < 0.01
    assert got.photos[0].ties == 0 and got.photos[1].ties > 500


def adjusted(share, *, ties=True, rig=False, templates=400):
    """A photo 15 cm beside its place, with which a share of its control points agrees, the others with it."""
    rng, true = np.random.default_rng(2), posed(looking(6.0, -8.0))
    photo = posed(moved(true.pose, 0.15))
    xyz = np.column_stack(
        [rng.uniform(3.0, 9.0, 400), rng.uniform(0.0, 3.0, 400), rng.uniform(0.2, 3.8, 400)]
    )
    there = np.arange(400) < share * 400
    pixels = np.where(there[:, None], true.project(xyz), photo.project(xyz)) + rng.normal(0, 0.3, (400, 2))
    images = SimpleNamespace(photo=np.zeros(400, int), group=np.full(400, CONTROL), sigma=np.full(400, 0.3))
    return SimpleNamespace(
        improved=SimpleNamespace(photos=[photo]),
        placed=SimpleNamespace(photos=[photo]),
        control=[SimpleNamespace(pixels=pixels, xyz=xyz, side=np.full(400, 4000.0 / templates))],
        network=SimpleNamespace(images=images),
        adjustment=SimpleNamespace(factors=np.ones(max(CONTROL, TIES) + 1)),
        ties_of=lambda k: np.arange(30 if ties else 0),
        fellows=lambda k: np.arange(2 if rig else 1),
    )


@pytest.mark.parametrize(("share", "found"), [(0.8, True), (0.6, True), (0.45, False), (0.0, False)])
def test_a_majority_of_control_points_outvotes_ties(share, found):
    one = most_outvoted(adjusted(share), 0)
    assert (one is not None) == found
    if one is not None:
        assert one.photo == 0 and np.linalg.norm(one.pose.t - [6.0, -8.0, 1.7]) < 0.01 and one.excess > 3.29


def test_points_within_a_few_templates_are_no_majority():
    assert most_outvoted(adjusted(0.8, templates=5), 0) is None


def test_poses_that_rest_on_control_or_on_a_rig_are_not_asked():
    assert most_outvoted(adjusted(0.8, ties=False), 0) is None
    assert most_outvoted(adjusted(0.8, rig=True), 0) is None
