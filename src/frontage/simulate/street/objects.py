"""Objects that stand in a street: cars, lamps and pedestrians, drawn as lofts through rings."""

import numpy as np

from frontage.geometry.arrays import Float
from frontage.simulate.meshing import Pen, loft
from frontage.simulate.scene import Part, SurfaceMaterial

_CAR_COLOURS = ((0.02, 0.02, 0.025), (0.35, 0.36, 0.38), (0.75, 0.75, 0.75), (0.3, 0.02, 0.02),
                (0.03, 0.06, 0.2), (0.1, 0.11, 0.12), (0.05, 0.12, 0.08))  # fmt: skip
_CLOTHES = ((0.03, 0.03, 0.05), (0.3, 0.05, 0.05), (0.1, 0.15, 0.3), (0.45, 0.42, 0.35), (0.08, 0.1, 0.07))
_TURN = np.linspace(0, 2 * np.pi, 13)[:-1]
_FINE = np.linspace(0, 2 * np.pi, 41)[:-1]
# sections of a car from below: height, half length, half width, m
_BODY = (
    (0.2, 1.85, 0.74),
    (0.3, 2.05, 0.83),
    (0.5, 2.12, 0.87),
    (0.68, 2.12, 0.87),
    (0.8, 2.06, 0.84),
    (0.9, 1.9, 0.78),
)
_CABIN = ((0.88, 1.32, 0.76), (1.1, 1.13, 0.7), (1.36, 0.83, 0.6), (1.42, 0.74, 0.54), (1.45, 0.55, 0.42))


def draw_car(pen: Pen, name: str, rng: np.random.Generator) -> None:
    """Draw a parked car; the pen's frame has x along the car and its origin on the ground below it."""
    scale = rng.uniform(0.9, 1.1, 3)
    rgb = _CAR_COLOURS[int(rng.integers(len(_CAR_COLOURS)))]
    seed = int(rng.integers(2**31))
    paint = SurfaceMaterial("car", "paint", rgb, rgb, float(rng.uniform(0.1, 0.6)), 0.4, seed=seed)
    dark = SurfaceMaterial("car glass", "paint", (0.015, 0.018, 0.02), (0.015, 0.018, 0.02), 0.06, 0.6)
    tyre = SurfaceMaterial("tyre", "paint", (0.015, 0.015, 0.015), (0.03, 0.03, 0.03), 0.05)
    body = pen.surface(f"{name}/body", Part.CAR, paint)
    _loft(pen, body, np.array([_rounded(x, y, 0.0, z) for z, x, y in _BODY]) * scale)
    cabin = [_rounded(x, y, -0.2, z) for z, x, y in _CABIN]
    _loft(pen, pen.surface(f"{name}/windows", Part.CAR, dark), np.array(cabin[:3]) * scale)
    _loft(pen, body, np.array(cabin[2:]) * scale)
    wheels = pen.surface(f"{name}/wheels", Part.CAR, tyre)
    for x in (-1.3, 1.3):
        for y in (-0.82, 0.62):
            circle = np.column_stack([x + 0.31 * np.cos(_TURN), np.full(12, y), 0.31 + 0.31 * np.sin(_TURN)])
            far = circle + np.array([0.0, 0.2, 0.0])
            _loft(pen, wheels, np.array([far, circle]) * scale)


def draw_lamp(pen: Pen, name: str, rng: np.random.Generator) -> None:
    """Draw a street lamp; x of the pen's frame points along its arm."""
    metal = SurfaceMaterial("lamp", "metal", (0.08, 0.09, 0.09), (0.05, 0.05, 0.05), 0.3, 0.2)
    surface = pen.surface(f"{name}/post", Part.LAMP, metal)
    height, reach = float(rng.uniform(4.0, 7.0)), float(rng.uniform(0.4, 1.4))
    profile = ((0.0, 0.11), (0.9, 0.11), (0.95, 0.06), (height, 0.04))
    _loft(pen, surface, np.array([_circle(r, 0.0, 0.0, z) for z, r in profile]))
    pen.box(surface, (0.0, -0.025, height - 0.05), (reach, 0.025, height))
    pen.box(surface, (reach - 0.3, -0.13, height - 0.13), (reach + 0.25, 0.13, height - 0.03))


def draw_person(pen: Pen, name: str, rng: np.random.Generator) -> None:
    """Draw a pedestrian who walks along x of the pen's frame."""
    scale = float(rng.uniform(1.5, 1.95)) / 1.78
    coat, trousers = (_CLOTHES[int(k)] for k in rng.integers(len(_CLOTHES), size=2))
    upper = pen.surface(f"{name}/coat", Part.PERSON, _cloth("coat", coat, rng))
    lower = pen.surface(f"{name}/legs", Part.PERSON, _cloth("trousers", trousers, rng))
    skin = SurfaceMaterial("skin", "paint", (0.45, 0.28, 0.2), (0.4, 0.25, 0.18), 0.4)
    head = pen.surface(f"{name}/head", Part.PERSON, skin)
    stride = float(rng.uniform(0.05, 0.3))
    for sign in (-1.0, 1.0):
        levels = ((0.0, stride * sign, 0.06), (0.45, stride * sign * 0.5, 0.065), (0.88, 0.0, 0.085))
        _loft(pen, lower, scale * np.array([_circle(r, x, 0.09 * sign, z) for z, x, r in levels]))
        arm = ((0.8, -stride * sign, 0.04), (1.15, 0.0, 0.045), (1.42, 0.0, 0.05))
        _loft(pen, upper, scale * np.array([_circle(r, x, 0.25 * sign, z) for z, x, r in arm]))
    torso = ((0.84, 0.15), (1.1, 0.15), (1.35, 0.2), (1.47, 0.14), (1.52, 0.06))
    wide = np.array([1.0, 1.35, 1.0])
    _loft(pen, upper, scale * wide * np.array([_circle(r, 0.0, 0.0, z) for z, r in torso]))
    rise = np.linspace(-1, 1, 7)
    ball = [_circle(0.1 * np.sqrt(max(1 - t * t, 0.02)), 0.0, 0.0, 1.65 + 0.125 * t) for t in rise]
    _loft(pen, head, scale * np.array(ball))


def _cloth(name: str, rgb: tuple[float, float, float], rng: np.random.Generator) -> SurfaceMaterial:
    return SurfaceMaterial(
        name, "fabric", rgb, rgb, float(rng.uniform(0.1, 0.7)), seed=int(rng.integers(2**31))
    )


def _loft(pen: Pen, surface: int, rings: Float) -> None:
    pen.triangles(surface, *loft(rings))


def _circle(radius: float, x: float, y: float, z: float) -> Float:
    return np.column_stack([x + radius * np.cos(_TURN), y + radius * np.sin(_TURN), np.full(12, z)])


def _rounded(half_x: float, half_y: float, x: float, z: float) -> Float:
    """Returns a superellipse about (x, 0) in the plane z: nearly straight sides, round corners."""
    c, s = np.cos(_FINE), np.sin(_FINE)
    ring = np.column_stack([np.sign(c) * np.abs(c) ** 0.45, np.sign(s) * np.abs(s) ** 0.45])
    return np.column_stack([ring * [half_x, half_y] + [x, 0.0], np.full(len(ring), z)])
