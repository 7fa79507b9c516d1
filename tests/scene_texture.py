"""What the surfaces of a simulated street look like: one colour for a place, in points and in photos."""

import numpy as np

from frontage.geometry.arrays import Array
from scene_parts import BAR, FRAME, HouseTruth, OpeningTruth

BRICK = (0.25, 0.083)
MORTAR = 0.012


def hash01(a: Array, b: Array, seed: int) -> Array:
    """A repeatable pseudo-random number 0..1 (float32) for integer pairs (a, b)."""
    h = (a.astype(np.uint32) * np.uint32(0x9E3779B1)) ^ (b.astype(np.uint32) * np.uint32(0x85EBCA77))
    h ^= np.uint32(seed & 0xFFFFFFFF)
    h = (h ^ (h >> np.uint32(15))) * np.uint32(0x2C1B3C6D)
    return ((h ^ (h >> np.uint32(12))) & np.uint32(0xFFFF)).astype(np.float32) / np.float32(65535)


def _scaled(colour: tuple[float, float, float], tone: Array) -> Array:
    return tone[:, None] * np.asarray(colour, np.float32)


def wall_colour(house: HouseTruth, x: Array, z: Array) -> Array:
    """Bricks each of its own tone, mortar, and an F-shaped mark that a mirror would betray: (n, 3) 0..1."""
    row = np.floor(z / BRICK[1])
    shifted = x / BRICK[0] + 0.5 * (row % 2)
    column = np.floor(shifted)
    tone = 0.78 + 0.3 * hash01(
        column.astype(np.int32), row.astype(np.int32), house.seed + 7 * int(house.id[1:])
    )
    mortar = ((shifted - column) * BRICK[0] < MORTAR) | (z - row * BRICK[1] < MORTAR)
    tone = np.where(mortar, np.float32(1.15), tone.astype(np.float32))
    tone = np.where(f_mark(house, x, z), np.float32(0.12), tone)
    return _scaled(house.colour, tone)


def f_mark(house: HouseTruth, x: Array, z: Array) -> Array:
    """Where the painted F is: 0.45 x 0.6 m, beside the top left window, under the cornice."""
    u, v = (x - 0.12) / 0.45, (z - (house.height - 1.05)) / 0.6
    stem = (u > 0) & (u < 0.25) & (v > 0) & (v < 1)
    arms = (u > 0) & (((u < 1) & (v > 0.8) & (v < 1)) | ((u < 0.7) & (v > 0.4) & (v < 0.58)))
    return stem | arms


def pane_is_solid(opening: OpeningTruth, x: Array, z: Array) -> Array:
    """True on frame, bars and door leaves; False on glass."""
    if opening.kind == "door":
        return np.ones(np.shape(x), bool)
    near = [
        (x < opening.x0 + FRAME) | (x > opening.x1 - FRAME),
        (z < opening.z0 + FRAME) | (z > opening.z1 - FRAME),
    ]
    near += [np.abs(x - b) < BAR / 2 for b in opening.bars_vertical]
    near += [np.abs(z - b) < BAR / 2 for b in opening.bars_horizontal]
    return np.logical_or.reduce(near)


def pane_colour(opening: OpeningTruth, x: Array, z: Array) -> Array:
    """Frame, bars, glass or door leaf: (n, 3) 0..1."""
    if opening.kind == "door":
        panel = (np.abs((x - opening.x0) % 0.37 - 0.18) < 0.13) & (
            np.abs((z - opening.z0) % 0.8 - 0.4) < 0.33
        )
        return _scaled((0.30, 0.38, 0.28), np.where(panel, np.float32(0.8), np.float32(1.1)))
    shade = (0.6 + 0.4 * (z - opening.z0) / (opening.z1 - opening.z0)).astype(np.float32)
    glass = _scaled((0.16, 0.20, 0.26), shade)
    frame = np.float32([0.93, 0.93, 0.90])
    return np.where(pane_is_solid(opening, x, z)[:, None], frame, glass)


def stone_colour(x: Array, z: Array, seed: int = 3) -> Array:
    """Light stone with grain, for cornices, sills, balconies and reveals: (n, 3) 0..1."""
    grain = hash01(np.floor(x / 0.05).astype(np.int32), np.floor(z / 0.05).astype(np.int32), seed)
    return _scaled((0.80, 0.79, 0.75), 0.88 + 0.15 * grain)


def ground_colour(s: Array, d: Array) -> Array:
    """Paving near the walls, asphalt in the road: (n, 3) 0..1, street frame."""
    tile = hash01(np.floor(s / 0.5).astype(np.int32), np.floor(d / 0.5).astype(np.int32), 11)
    fine = hash01(np.floor(s / 0.04).astype(np.int32), np.floor(d / 0.04).astype(np.int32), 5)
    road = (d < -3.0) & (d > -11.0)
    return np.where(road[:, None], _scaled((0.28, 0.28, 0.30), 0.8 + 0.3 * fine),
                    _scaled((0.58, 0.57, 0.55), 0.8 + 0.25 * tile))  # fmt: skip


def leaf_colour(xyz: Array) -> Array:
    q = np.floor(xyz / 0.07).astype(np.int32)
    return _scaled((0.28, 0.48, 0.20), 0.5 + 0.8 * hash01(q[:, 0] + 131 * q[:, 2], q[:, 1], 17))


def car_colour(xyz: Array, number: int) -> Array:
    base = ((0.55, 0.08, 0.08), (0.10, 0.18, 0.45), (0.75, 0.75, 0.78))[number % 3]
    band = np.where((xyz[:, 2] % 1.5 > 0.85) & (xyz[:, 2] % 1.5 < 1.3), np.float32(0.35), np.float32(1.0))
    return _scaled(base, band)
