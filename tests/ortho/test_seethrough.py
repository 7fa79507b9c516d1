"""Where the scan puts something before the wall, the photos tell whether the wall shows all the same."""

import numpy as np
import pytest

from frontage.ortho.mosaic.seethrough import see_through

WALL, LEAF = np.array([0.62, 0.55, 0.45]), np.array([0.25, 0.35, 0.15])
NOISE = 0.02


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
    found = see_through(codes, standing, sigma, clear, behind, np.zeros((60, 120), bool))
    right = np.s_[:, :, 60:]
    assert not found[:, :, :60].any(), "where one photo is clear, the others are not asked"
    assert 0.85 < (found & shows)[right].sum() / shows[right].sum() <= 1.0
    assert (found & ~shows)[right].sum() < 0.03 * shows[right].sum()


def test_an_occluder_that_is_never_seen_through_stays_one():
    codes, standing, sigma, clear, behind, _ = scene(0.0)
    assert not see_through(codes, standing, sigma, clear, behind, np.zeros((60, 120), bool)).any()


def test_without_a_clear_photo_nothing_is_learned():
    codes, standing, sigma, clear, behind, _ = scene(0.4)
    nothing = np.zeros_like(clear)
    assert not see_through(codes, standing, sigma, nothing, behind | clear, nothing[0]).any()
