"""What stands before a facade: found, boxed and named; what the wall holds is no occluder."""

from pathlib import Path

import numpy as np
import pytest

import ortho_wall as wall
from frontage.io.rasters.occluders import read_occluders, write_occluders
from frontage.model import Scan
from frontage.ortho import OrthoOptions
from frontage.ortho.occluders import find_occluders
from frontage.ortho.standing.find import find_standing
from frontage.ortho.standing.walls import is_building

GROUND = -3.0


def surface(low, high, step=0.04):
    """Points on the sides and the top of a box, all in the facade frame."""
    low, high = np.array(low, float), np.array(high, float)
    axes = [np.arange(a, b, step) for a, b in zip(low, high, strict=True)]
    faces = []
    for axis in range(3):
        for end in (low, high):
            rest = [axes[i] if i != axis else np.array([end[axis]]) for i in range(3)]
            faces.append(np.stack(np.meshgrid(*rest, indexing="ij"), -1).reshape(-1, 3))
    return np.concatenate(faces)


@pytest.fixture(scope="module")
def street():
    facade = wall.facade(14.0, 6.0, spacing=0.04)
    rng = np.random.default_rng(0)
    crown = rng.normal(0.0, 0.8, (4000, 3)) * [1, 1, 1.2] + [5.0, -4.0, 1.5]
    ground = np.stack(np.meshgrid(np.arange(-7, 7, 0.1), np.arange(-10, 0, 0.1), [GROUND]), -1).reshape(-1, 3)
    front = np.stack(np.meshgrid(np.arange(-7, 7, 0.05), [0.0], np.arange(-3, 3, 0.05)), -1).reshape(-1, 3)
    turn, height = rng.uniform(0, 2 * np.pi, 1500), rng.uniform(0, 1.72, 1500)
    radius = 0.22 * np.sqrt(1.0 - (height / 1.72 - 0.5) ** 2) + rng.normal(0.0, 0.02, 1500)
    person = np.column_stack(
        [0.75 + radius * np.cos(turn), -1.8 + 0.7 * radius * np.sin(turn), GROUND + height]
    )
    things = {
        "car": surface((-6.0, -5.0, GROUND), (-1.8, -3.2, GROUND + 1.5)),
        "person": person,
        "tree": np.concatenate([crown, surface((4.9, -4.1, GROUND), (5.1, -3.9, 0.5))]),
        "balcony": surface((1.5, -1.2, 0.0), (3.5, -0.2, 1.1)),
        "doorstep": surface((-1.0, -0.7, GROUND), (0.3, 0.0, GROUND + 0.34)),
    }
    xyz = np.concatenate([ground, front, *things.values()])
    return facade, Scan("street", facade.frame.apply(xyz), facade.world), things | {"front": front}


def test_things_are_named_and_the_balcony_is_none(street):
    found = find_standing(*street[:2]).occluders
    assert [one.kind for one in found] == ["car", "person", "tree"]
    assert all(0.7 < one.confidence <= 1.0 for one in found)
    assert [one.id for one in found] == ["B01/F1/X1", "B01/F1/X2", "B01/F1/X3"]


def test_the_box_of_a_car_is_that_of_the_car(street):
    car = find_standing(*street[:2]).occluders[0]
    assert np.allclose(car.centre, [-3.9, -4.1, GROUND + 0.75], atol=0.1)
    assert np.allclose(car.size, [4.2, 1.8, 1.5], atol=0.15)
    assert abs(np.sin(car.heading)) < 0.02
    assert np.allclose(car.corners.min(0), [-6.0, -5.0, GROUND], atol=0.15)


@pytest.mark.parametrize("thing", ["car", "person", "tree", "balcony", "doorstep", "front"])
def test_points_belong_to_what_stands_free_or_to_the_facade(street, thing):
    facade, scan, things = street
    own = things[thing][things[thing][:, 2] > GROUND + 0.03]
    held = find_standing(facade, scan).holds(own)
    free = thing in ("car", "person", "tree")
    assert held.mean() > 0.98 if free else not held.any(), "a few leaves stand alone"


def test_a_street_without_anything_has_no_occluders(street):
    facade, *_ = street
    assert find_standing(facade, wall.wall_cloud(facade)).occluders == ()


def test_occluders_are_written_and_read_back(street, tmp_path: Path):
    facade, scan, _ = street
    found = find_standing(facade, scan).occluders
    write_occluders(tmp_path / "occluders.json", found, facade)
    again = read_occluders(tmp_path / "occluders.json")
    assert [one.kind for one in again] == [one.kind for one in found]
    assert np.allclose(again[0].corners, found[0].corners, atol=1e-3)


def upright(x0, y0, x1, y1, height, step=0.06):
    """Points (n, 3) on a wall between two places, from the ground up."""
    along, up = np.meshgrid(
        np.linspace(0, 1, int(np.hypot(x1 - x0, y1 - y0) / step)), np.arange(0, height, step)
    )
    return np.column_stack(
        [x0 + along.ravel() * (x1 - x0), y0 + along.ravel() * (y1 - y0), GROUND + up.ravel()]
    )


def test_a_wing_with_a_corner_is_a_building_and_a_tree_and_a_car_are_none(street):
    wing = np.concatenate([upright(3, -1, 3, -7, 6.0), upright(3, -7, 7, -7, 6.0)])
    assert is_building(wing)
    assert not is_building(street[2]["tree"]) and not is_building(street[2]["car"])


def test_a_wing_hides_the_wall_for_good_and_is_no_occluder():
    facade = wall.facade(14.0, 6.0, spacing=0.06)
    wing = np.concatenate([upright(3, -0.9, 3, -7, 6.0), upright(3, -7, 7, -7, 6.0)])
    ground = np.stack(np.meshgrid(np.arange(-7, 7, 0.1), np.arange(-10, 0, 0.1), [GROUND]), -1).reshape(-1, 3)
    front = np.stack(np.meshgrid(np.arange(-7, 7, 0.06), [0.0], np.arange(-3, 3, 0.06)), -1).reshape(-1, 3)
    scan = Scan("street", facade.frame.apply(np.concatenate([ground, front, wing])), facade.world)
    standing = find_standing(facade, scan)
    assert not standing.occluders
    assert standing.parted(wing[wing[:, 2] > GROUND + 0.3])[2].mean() > 0.99
    xyz = facade.frame.inverse.apply(scan.xyz)
    cloud = find_occluders(facade, xyz, standing, None, OrthoOptions())
    assert (cloud.part[0][:, 1] < -2.0).sum() > 1000, "the wing is a part that stays"
    for free in (cloud.light, cloud.solid):
        assert not (free[0][:, 2] > GROUND + 0.3).any()


def test_points_in_one_place_are_no_building():
    with np.errstate(all="raise"):
        assert not is_building(np.tile([3.0, -2.0, 1.0], (40, 1)))
