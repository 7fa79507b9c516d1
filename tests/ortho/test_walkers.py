"""A walker as near to the wall as a narrow pavement makes him: the scan saw him, no photo paints him."""

import cv2
import numpy as np
import pytest

import ortho_wall as wall
from frontage.model import Scan
from frontage.ortho import OrthoOptions, make_ortho

GROUND, AWAY = -3.0, 0.65  # m
CLOTHES = (255, 0, 255)
STEP = (1.4, 2.6, 0.5, 0.32)  # x0, x1, how far it stands out, how high: m


def walker(x: float) -> np.ndarray:
    """Points (n, 3) m on an upright ellipsoid at x."""
    rng = np.random.default_rng(1)
    turn, height = rng.uniform(0, 2 * np.pi, 9000), rng.uniform(0.0, 1.72, 9000)
    radius = 0.27 * np.sqrt(np.maximum(1.0 - (2.0 * height / 1.72 - 1.0) ** 4, 0.02))
    return np.column_stack([x + radius * np.cos(turn), -AWAY + 0.8 * radius * np.sin(turn), GROUND + height])


def doorstep(x, z):
    """The relief y (n,) m of a wall with a doorstep."""
    x0, x1, out, high = STEP
    return np.where((x > x0) & (x < x1) & (z < GROUND + high), -out, 0.0)


@pytest.fixture(scope="module")
def made():
    facade = wall.facade(8.0, 6.0)
    grey = (wall.texture(8.0, 6.0)[..., :1] * 0.7).astype(np.uint8)
    picture = np.repeat(grey, 3, axis=2)
    thing = walker(-0.5)
    photos = [
        wall.photo(facade, wall.camera(1000, 800), (x, -7.0, -1.4), (0.3 * x, 0, -0.6), f"{n}.jpg")
        for n, x in enumerate((-3.0, 3.0))
    ]
    shots = {p.id: shown(p, facade, picture, thing) for p in photos}
    cloud = wall.wall_cloud(facade, depth=doorstep)
    floor = np.stack(np.meshgrid(np.arange(-4, 4, 0.05), np.arange(-6, 0, 0.05), [GROUND]), -1)
    xyz = facade.frame.apply(np.concatenate([thing, floor.reshape(-1, 3)]))
    scan = Scan("street", np.concatenate([cloud.xyz, xyz]), facade.world)
    options = OrthoOptions(margin=0.0)
    ortho = make_ortho(facade, scan, photos, shots.__getitem__, options=options)
    return facade, ortho, photos, thing


def shown(photo, facade, picture, thing):
    """What a photo shows of the wall behind the walker."""
    image = wall.render(photo, facade, picture, depth=doorstep)
    at = photo.project(facade.frame.apply(thing))
    for u, v in np.rint(at - 0.5).astype(int):
        cv2.circle(image, (int(u), int(v)), 4, CLOTHES, -1)
    return image


def clothes(ortho):
    """Which pixels (h, w) show the walker, rather than wall or nothing."""
    code = ortho.pixels.astype(int)
    return (code[..., 3] > 0) & (code[..., 0] - code[..., 1] > 90) & (code[..., 2] - code[..., 1] > 90)


def test_the_walker_is_known_and_not_painted(made):
    _, ortho, _, _ = made
    assert [one.kind for one in ortho.occluders] == ["person"]
    assert clothes(ortho).sum() < 10, "square centimetres"


def test_the_wall_that_a_photo_sees_behind_him_is_painted(made):
    facade, ortho, photos, thing = made
    h, w = ortho.source.shape
    hidden = np.ones((h, w), bool)
    for photo in photos:
        centre = facade.frame.inverse.apply(photo.pose.t[None])[0]
        share = centre[1] / (centre[1] - thing[:, 1])
        shadow = centre + (thing - centre) * share[:, None]
        one = np.zeros((h, w), np.uint8)
        column = (shadow[:, 0] - ortho.corner[0]) / ortho.gsd
        row = (ortho.corner[1] - shadow[:, 2]) / ortho.gsd
        for c, r in np.rint(np.column_stack([column, row])).astype(int):
            cv2.circle(one, (int(c), int(r)), 10, 1, -1)  # a disc of the spacing, and a cell
        hidden &= one > 0
    painted = ortho.source > 0
    assert (~painted & ~hidden).sum() < 0.005 * (~hidden).sum()
    assert (~painted).sum() < 1.2 * hidden.sum() + 0.005 * painted.size


def test_the_doorstep_stays_where_it_is(made):
    _, ortho, _, _ = made
    x = ortho.corner[0] + (np.arange(ortho.size[0]) + 0.5) * ortho.gsd
    z = ortho.corner[1] - (np.arange(ortho.size[1]) + 0.5) * ortho.gsd
    x0, x1, out, high = STEP
    inner = np.ix_(z < GROUND + high - 0.08, (x > x0 + 0.08) & (x < x1 - 0.08))
    depth = ortho.depth[inner]
    assert np.isfinite(depth).mean() > 0.9
    assert np.nanmedian(depth) == pytest.approx(-out, abs=0.01)
    before = np.nan_to_num(ortho.depth) < -0.1
    before[:, (x > x0 - 0.1) & (x < x1 + 0.1)] = False
    assert before.mean() < 0.002, "nothing else stands before the wall"
