"""The simulated street itself is right: what every other test stands on."""

import numpy as np
import pytest

from frontage.model import Photo
from frontage.model.estimate import Estimate
from scene_files import default_camera, default_poses
from scenes import CAR, FACADE, GROUND, INTERIOR, TREE, Scene, render_photo, street_scene, wall_scene


def facade_points(scene: Scene, number: int, label: int = FACADE) -> np.ndarray:
    keep = (scene.house == number) & (scene.label == label)
    return scene.houses[number].local_from_facade.inverse.apply(scene.scan.xyz[keep])


def test_walls_lie_on_their_planes_with_the_noise_that_was_asked(street: Scene) -> None:
    for k, house in enumerate(street.houses):
        p = facade_points(street, k)
        wall = p[(np.abs(p[:, 1]) < 0.03) & (house.opening_at(p[:, 0], p[:, 2]) < 0)]
        assert abs(np.median(wall[:, 1])) < 5e-4
        assert 0.003 < wall[:, 1].std() < 0.007


def test_no_wall_point_floats_in_an_opening(street: Scene) -> None:
    house = street.houses[1]
    p = facade_points(street, 1)
    for o in house.openings:
        m = 0.03
        inside = (p[:, 0] > o.x0 + m) & (p[:, 0] < o.x1 - m) & (p[:, 2] > o.z0 + m) & (p[:, 2] < o.z1 - m)
        depth = p[inside, 1]
        assert ((depth > o.depth - 0.05) | (depth < -0.5)).all()  # recessed, or a rail well in front


def test_rooms_are_seen_through_windows_only(street: Scene) -> None:
    keep = (street.label == INTERIOR) & (street.house == 0)
    house = street.houses[0]
    to = house.local_from_facade.inverse
    p, eye = to.apply(street.scan.xyz[keep]), to.apply(street.scan.sensor_of(np.flatnonzero(keep)))
    assert len(p) > 100
    share = -eye[:, 1] / (p[:, 1] - eye[:, 1])
    cross = eye + share[:, None] * (p - eye)
    opening = house.opening_at(cross[:, 0], cross[:, 2])
    assert (opening >= 0).mean() > 0.97  # noise moves a few across the border
    assert {GROUND, CAR, TREE} <= set(np.unique(street.label).tolist())


def test_the_same_seed_gives_the_same_points() -> None:
    a, b, c = (street_scene(seed=s, houses=1, spacing=0.1) for s in (3, 3, 4))
    assert a.scan.xyz.tobytes() == b.scan.xyz.tobytes()
    assert a.scan.xyz.tobytes() != c.scan.xyz.tobytes()


def test_a_photo_shows_the_mark_where_the_camera_projects_it() -> None:
    """The dark F on the wall is found where `Photo.project` says, upright and not mirrored."""
    scene = street_scene(houses=2, spacing=0.2, trees=False, cars=False)
    camera, pose = default_camera(900), default_poses(scene, 2)[0]
    image = render_photo(scene, camera, pose).mean(2)
    photo = Photo("p", camera, Estimate(pose, np.eye(6), 1.0))
    h = scene.houses[0]
    x, z = 0.12 + 0.05, h.height - 1.05  # stem of the F; the arms leave it to the right
    spots = {
        "stem": (x, z + 0.3),
        "arm": (x + 0.25, z + 0.54),
        "below": (x + 0.3, z + 0.1),
        "left": (0.05, z + 0.5),
    }
    local = h.local_from_facade.apply(np.array([[u, 0.0, v] for u, v in spots.values()]))
    pixels = photo.project(local)
    value = dict(zip(spots, image[pixels[:, 1].astype(int), pixels[:, 0].astype(int)], strict=True))
    assert value["stem"] < 60 and value["arm"] < 60
    assert value["below"] > 90 and value["left"] > 90


def test_photo_and_points_agree_on_colour() -> None:
    scene = street_scene(houses=2, spacing=0.06, noise=0.0, trees=False, cars=False)
    camera, pose = default_camera(1200), default_poses(scene, 2)[0]
    image = render_photo(scene, camera, pose, supersample=3).astype(float)
    keep = np.flatnonzero((scene.label == FACADE) & (scene.house == 0))
    p = scene.houses[0].local_from_facade.inverse.apply(scene.scan.xyz[keep])
    keep = keep[(np.abs(p[:, 1]) < 1e-6) & (p[:, 2] > 1.0) & (p[:, 2] < 10)]
    uv = Photo("p", camera, Estimate(pose, np.eye(6), 1.0)).project(scene.scan.xyz[keep])
    ok = (uv > 10).all(1) & (uv < (1199, 1599)).all(1)
    told, (u, v) = scene.scan.rgb[keep][ok].mean(1), uv[ok].astype(int).T
    assert ok.sum() > 500
    right, shifted = (np.corrcoef(image[v, u + du].mean(1), told)[0, 1] for du in (0, -9))
    assert right > 0.5 > 0.25 > shifted  # half a brick away the bricks no longer match


@pytest.mark.parametrize("share", [0.0, 0.6])
def test_the_wall_scene_has_the_clutter_that_was_asked(share: float) -> None:
    scene = wall_scene(spacing=0.1, clutter=share)
    assert (scene.label != FACADE).mean() == pytest.approx(share, abs=0.01)
    wall = scene.houses[0].local_from_facade.inverse.apply(scene.scan.xyz[scene.label == FACADE])
    assert np.ptp(wall[:, 0]) == pytest.approx(20, abs=0.3) and np.ptp(wall[:, 2]) == pytest.approx(
        12, abs=0.3
    )
