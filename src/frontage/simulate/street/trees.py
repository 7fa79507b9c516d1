"""Trees that let light through: a trunk, branches and thousands of loose leaves."""

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.simulate.meshing import Pen, loft
from frontage.simulate.scene import Part, SurfaceMaterial

_TURN = np.linspace(0, 2 * np.pi, 9)[:-1]


def draw_tree(pen: Pen, name: str, radius: float, rng: np.random.Generator) -> None:
    """Draw a tree whose crown has `radius` m; the origin of the pen's frame is the tree's foot."""
    bark = SurfaceMaterial(
        "bark",
        "wood",
        (0.13, 0.10, 0.075),
        (0.07, 0.05, 0.04),
        0.35,
        0.0,
        (0.08, 0.6),
        int(rng.integers(2**31)),
    )
    green = rng.uniform((0.05, 0.11, 0.02), (0.12, 0.21, 0.05))
    rgb = float(green[0]), float(green[1]), float(green[2])
    leaf = SurfaceMaterial("leaves", "leaves", rgb, (0.16, 0.2, 0.06), float(rng.uniform(0.35, 0.6)))
    clear = float(rng.uniform(2.2, 3.2))
    height = clear + radius * float(rng.uniform(2.0, 3.2))
    wood = pen.surface(f"{name}/wood", Part.TREE, bark)
    top = np.array([0.0, 0.0, height * 0.8])
    draw_limb(pen, wood, (np.zeros(3), top), (0.055 * radius + 0.05, 0.03))
    tips = _draw_branches(pen, wood, (clear, height), radius, rng)
    density = float(rng.uniform(0.35, 1.0))
    xyz, corners = scatter_leaves(tips, radius, int(density * 1500 * radius), rng)
    pen.triangles(pen.surface(f"{name}/leaves", Part.TREE, leaf), xyz, corners)


def draw_limb(pen: Pen, surface: int, ends: tuple[Float, Float], radii: tuple[float, float]) -> None:
    """Draw a tapering limb between two ends (3,) m, with the radii (m) that it has there."""
    (start, end), (r0, r1) = ends, radii
    axis = (end - start) / np.linalg.norm(end - start)
    u = np.cross(axis, [0.0, 1.0, 0.0] if abs(axis[1]) < 0.9 else [1.0, 0.0, 0.0])
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    ring = np.cos(_TURN)[:, None] * u + np.sin(_TURN)[:, None] * v
    pen.triangles(surface, *loft(np.stack([start + r0 * ring, end + r1 * ring])))


def _draw_branches(
    pen: Pen, surface: int, levels: tuple[float, float], radius: float, rng: np.random.Generator
) -> Float:
    """Draws the branches of a tree, and returns where they end (n, 3).

    `levels` are the height below which the trunk is bare and the height of the tree; m.
    """
    clear, height = levels
    count = int(rng.integers(9, 16))
    turn = np.arange(count) * 2.4 + rng.uniform(-0.4, 0.4, count)
    foot = np.linspace(clear * 0.85, height * 0.72, count)
    reach = (
        radius * rng.uniform(0.55, 0.85, count) * np.sqrt(np.clip(1.15 - np.linspace(0, 1, count), 0.2, 1))
    )
    tips = np.column_stack(
        [reach * np.cos(turn), reach * np.sin(turn), foot + reach * rng.uniform(0.5, 1.0, count)]
    )
    tips[:, 2] = np.minimum(tips[:, 2], height - 0.3)
    for z, tip in zip(foot, tips, strict=True):
        draw_limb(pen, surface, (np.array([0.0, 0.0, z]), tip), (0.035 * radius + 0.01, 0.012))
    return np.vstack([tips, [[0.0, 0.0, height - 0.4]]])


def scatter_leaves(tips: Float, radius: float, count: int, rng: np.random.Generator) -> tuple[Float, Int]:
    """Scatter n = `count` leaves around the tips of branches: vertices (4 n, 3), corners (2 n, 3).

    A quarter of them fills the crown between the tips; none is further from the axis than `radius` m.
    """
    at = tips[rng.integers(len(tips), size=count)] * np.where(
        rng.random((count, 1)) < 0.25, rng.random((count, 1)), 1
    )
    at[:, 2] = np.maximum(at[:, 2], tips[:, 2].min())
    centre = at + rng.normal(0, 0.24 * radius, (count, 3)) * [1.0, 1.0, 0.8]
    size = rng.uniform(0.04, 0.11, (count, 1))
    a = rng.normal(size=(count, 3))
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    b = np.cross(a, rng.normal(size=(count, 3)))
    b /= np.linalg.norm(b, axis=1, keepdims=True)
    a, b = a * size, b * size * 0.6
    away = np.hypot(centre[:, 0], centre[:, 1])
    centre[:, :2] *= np.minimum(1.0, (radius - 0.11) / np.maximum(away, 1e-9))[:, None]
    xyz = np.stack([centre - a, centre - b, centre + a, centre + b], axis=1).reshape(-1, 3)
    first = 4 * np.arange(count)[:, None]
    return xyz, np.concatenate([first + np.array([0, 1, 2]), first + np.array([0, 2, 3])])
