"""A car goes on beyond the part of it that the scan saw, and hides the wall there, too."""

from types import SimpleNamespace

import numpy as np

from frontage.ortho.mosaic.extent import goes_on

WALL, GLASS = np.array([0.62, 0.55, 0.45]), np.array([0.3, 0.33, 0.38])
DOOR, BOOT = np.array([0.2, 0.28, 0.5]), np.array([0.28, 0.36, 0.6])
NOISE = 0.02


def scene():
    """Photos (2) of 100 x 160 cells of 4 cm: a wall with windows, and a car of which the scan saw the door.

    Only photo 0 is clear where it shows the boot; photo 1 looks past the car at the right half of the wall.
    """
    rng = np.random.default_rng(1)
    glass = np.zeros((100, 160), bool)
    glass[50:80, 50:64] = True  # right above the boot
    glass[10:40, 100:114] = True
    seen = np.zeros((100, 160), bool)
    seen[80:, 20:45] = True
    boot = np.zeros_like(seen)
    boot[80:, 45:70] = True
    codes = np.tile(np.where(glass[..., None], GLASS, WALL), (2, 1, 1, 1))
    codes[0, seen], codes[0, boot] = DOOR, BOOT
    codes += rng.normal(0.0, NOISE, codes.shape)
    clear = np.stack([~seen, np.broadcast_to(np.arange(160) >= 90, seen.shape)])
    behind = np.stack([seen, np.zeros_like(seen)])
    plan = SimpleNamespace(clear=clear, behind=behind, solid=behind, cells=SimpleNamespace(gsd=0.04))
    return codes.astype(np.float32), plan, glass, boot


def test_what_touches_a_known_car_and_is_no_wall_belongs_to_it():
    codes, plan, glass, boot = scene()
    found = goes_on(codes, SimpleNamespace(wall=codes[0]), plan, glass)
    assert found[0][boot].mean() > 0.9
    assert found[0][~boot].mean() < 0.002, "neither the wall nor the window above the boot"
    assert not found[1].any()


def test_what_another_photo_sees_between_the_two_parts_does_not_part_them():
    codes, plan, glass, boot = scene()
    plan.clear[1] |= boot & (np.arange(160) < 52)
    rest = boot & (np.arange(160) >= 52)
    found = goes_on(
        codes, SimpleNamespace(wall=np.where(plan.clear[1, ..., None], codes[1], codes[0])), plan, glass
    )
    assert found[0][rest].mean() > 0.85
    assert not found[0][boot & ~rest].any(), "there, the photos decide"


def test_where_another_photo_is_clear_the_photos_decide():
    codes, plan, glass, boot = scene()
    plan.clear[1] |= boot
    assert not goes_on(codes, SimpleNamespace(wall=codes[1]), plan, glass)[0][boot].any()


def test_a_car_that_has_left_goes_on_nowhere():
    codes, plan, glass, _ = scene()
    plan.behind = np.zeros_like(plan.behind)
    assert not goes_on(codes, SimpleNamespace(wall=codes[1]), plan, glass).any()
