"""Where the scan puts something before the wall, the photos tell whether the wall shows all the same."""

from types import SimpleNamespace

import numpy as np
import pytest

from frontage.ortho.mosaic.seethrough import see_through

WALL, LEAF = np.array([0.62, 0.55, 0.45]), np.array([0.25, 0.35, 0.15])
NOISE = 0.02


def seen(codes, standing, sigma, clear, behind, solid=None):
    """What `see_through` finds on a wall without openings."""
    plan = SimpleNamespace(
        clear=clear, behind=behind, solid=np.zeros_like(behind) if solid is None else solid
    )
    found = SimpleNamespace(wall=standing, sigma=sigma, distance=np.linalg.norm(codes - standing, axis=-1))
    return see_through(codes, found, plan, np.zeros(standing.shape[:2], bool))


def scene(open_share: float, wall: np.ndarray = WALL, seed: int = 0):
    """Four photos of 60 x 120 cells; the right half is behind a tree in all, the left half in three of them.

    Through a share of the tree, in blocks of six cells, the wall shows, in other places from every photo.
    """
    rng = np.random.default_rng(seed)
    shows = rng.random((4, 10, 20)).repeat(6, axis=1).repeat(6, axis=2) < open_share
    behind = np.ones((4, 60, 120), bool)
    behind[0, :, :60] = False
    shows |= ~behind
    codes = np.where(shows[..., None], wall, LEAF) + rng.normal(0.0, NOISE, (4, 60, 120, 3))
    standing = np.where((~behind).any(0)[..., None], codes[0], 0.0)
    return codes.astype(np.float32), standing, np.full((60, 120), NOISE), ~behind, behind, shows


@pytest.mark.parametrize("open_share", [0.1, 0.4])
def test_the_wall_between_leaves_is_found_and_leaves_are_not(open_share):
    codes, standing, sigma, clear, behind, shows = scene(open_share)
    found = seen(codes, standing, sigma, clear, behind)
    right = np.s_[:, :, 60:]
    assert not found[:, :, :60].any(), "where one photo is clear, the others are not asked"
    assert 0.85 < (found & shows)[right].sum() / shows[right].sum() <= 1.0
    assert (found & ~shows)[right].sum() < 0.03 * shows[right].sum()


def test_an_occluder_that_is_never_seen_through_stays_one():
    codes, standing, sigma, clear, behind, _ = scene(0.0)
    assert not seen(codes, standing, sigma, clear, behind).any()


def test_without_a_clear_photo_nothing_is_learned():
    codes, standing, sigma, clear, behind, _ = scene(0.4)
    nothing = np.zeros_like(clear)
    assert not seen(codes, standing, sigma, nothing, behind | clear).any()


def test_a_walker_in_a_coat_of_the_colour_of_the_wall_is_not_painted():
    """A third of him looks like the wall; a car that has left shows wall in its whole outline."""
    codes, standing, sigma, clear, behind, _ = scene(0.0)
    walker, left = np.zeros_like(behind), np.zeros_like(behind)
    walker[:, 10:50, 70:85] = left[:, 10:50, 95:115] = True
    rng = np.random.default_rng(1)
    coat = walker & (np.arange(60) < 24)[None, :, None]
    look = coat | left
    codes[look] = (WALL + rng.normal(0.0, NOISE, (int(look.sum()), 3))).astype(np.float32)
    found = seen(codes, standing, sigma, clear, behind, walker | left)
    assert not found[walker].any() and found[left].mean() > 0.9
    assert seen(codes, standing, sigma, clear, behind)[coat].mean() > 0.8, "as it would be among leaves"


def test_a_car_is_judged_as_a_whole_and_by_what_another_photo_shows_behind_it():
    """Its boot has the colour of the wall; most of it can be compared with a clear photo and is no wall."""
    codes, standing, sigma, clear, behind, _ = scene(0.0)
    car = np.zeros_like(behind)
    car[1, 20:40, 30:80] = True  # from where photo 0 is clear into where none is
    boot = car & (np.arange(120) >= 60)
    rng = np.random.default_rng(2)
    codes[boot] = (WALL + rng.normal(0.0, NOISE, (int(boot.sum()), 3))).astype(np.float32)
    assert not seen(codes, standing, sigma, clear, behind, car)[boot].any()
    codes[car] = (WALL + rng.normal(0.0, NOISE, (int(car.sum()), 3))).astype(np.float32)
    assert seen(codes, standing, sigma, clear, behind, car)[boot].mean() > 0.9, "it has left"


def test_leaves_as_small_as_a_cell_are_not_painted_with_the_wall_around_them():
    codes, standing, sigma, clear, behind, _ = scene(0.4)
    rows, columns = np.mgrid[30:36, 80:86]
    codes[2, rows, columns] = WALL
    codes[2, 32, 82] = LEAF
    found = seen(codes, standing, sigma, clear, behind)
    assert found[2, 33:35, 83:85].all() and not found[2, 32, 82]
