"""What only touches a part of the building stands free: a tree beside a bay."""

import numpy as np
import pytest

import ortho_wall as wall
from frontage.model import Scan
from frontage.ortho.standing.find import find_standing
from frontage.ortho.standing.walls import wall_points

GROUND = -4.0
FRONT = 0.9  # m, of the bay before the wall


def grid(x, y, z, step=0.05):
    return wall.grid(x, y, z, step)


@pytest.fixture(scope="module")
def street():
    """A wall with a bay on the left, whose right corner the crown of a tree touches."""
    facade = wall.facade(14.0, 8.0, spacing=0.05)
    rng = np.random.default_rng(0)
    bay = grid((-5.0, 0.0), -FRONT, (-1.5, 3.5))
    panes = np.abs((bay[:, 0] + 5.0) % 1.6 - 0.8) < 0.4
    panes &= np.abs((bay[:, 2] + 1.5) % 2.4 - 1.2) < 0.7
    sides = np.concatenate([grid(x, (-FRONT, 0.0), (-1.5, 3.5)) for x in (-5.0, 0.0)])
    turn = rng.normal(size=(9000, 3))
    turn *= rng.uniform(0.3, 1.0, (9000, 1)) ** (1 / 3) / np.linalg.norm(turn, axis=1, keepdims=True)
    crown = turn * [1.6, 1.6, 2.0] + [1.4, -2.0, 0.0]
    crown = crown[(crown[:, 1] < -0.1) & ((crown[:, 0] > 0.0) | (crown[:, 1] < -FRONT))]
    trunk = grid((1.35, 1.45), (-2.05, -1.95), (GROUND, -1.5), 0.03)
    ground = grid((-7.0, 7.0), (-10.0, 0.0), GROUND, 0.1)
    parts = {"bay": np.concatenate([bay[~panes], sides]), "tree": np.concatenate([crown, trunk])}
    front = grid((-7.0, 7.0), 0.0, (GROUND, 4.0))
    front = front[(front[:, 0] < -5.0) | (front[:, 0] > 0.0) | (front[:, 2] < -1.5)]
    scan = Scan("street", facade.frame.apply(np.concatenate([ground, front, *parts.values()])), facade.world)
    return facade, scan, parts


def test_a_tree_that_touches_a_bay_is_a_tree_and_the_bay_is_none(street):
    facade, scan, parts = street
    standing = find_standing(facade, scan)
    assert [one.kind for one in standing.occluders] == ["tree"]
    tree = standing.occluders[0]
    assert np.allclose(tree.centre[:2], [1.4, -2.1], atol=0.4) and 2.3 < tree.size[0] < 3.8
    assert standing.holds(parts["bay"]).mean() < 0.01
    free = standing.holds(parts["tree"])
    assert free[parts["tree"][:, 1] < -1.6].mean() > 0.97
    assert free.mean() > 0.65, "what lies within half a metre of the bay stays with it"


def test_the_wall_of_a_bay_is_found_among_leaves_and_a_tree_has_none(street):
    parts = street[2]
    both = np.concatenate(list(parts.values()))
    found = wall_points(both)
    bay = np.abs(both[:, 1] + FRONT) < 1e-6
    assert found[bay].mean() > 0.95
    assert found[len(parts["bay"]) :].mean() < 0.1
    assert not wall_points(parts["tree"]).any()


def test_a_lorry_is_no_wall():
    side = grid((0.0, 12.0), -3.0, (0.5, 3.9))
    assert not wall_points(side).any()
