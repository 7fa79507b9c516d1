"""Photos of one window in a wall, painted without a scene: every pixel is the mean of four rays."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from frontage.crossbars.window import Window, WindowView
from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Camera, Estimate, Opening, Photo, Provenance

Box = tuple[float, float, float, float]
DEPTH = 0.15
FRAME = 0.06
BAR = 0.04
HOLE: Box = (-0.5, 2.0, 0.5, 3.2)
EYES = ((-2.5, -6.0, 1.6), (-0.3, -6.5, 1.6), (2.0, -6.0, 1.7))
FRAME_OF_FACADE = Rigid3.identity("local", "facade")


def bar(axis: str, at: float, low: float, high: float, width: float = BAR) -> Box:
    """Returns the rectangle of a bar about x = `at` ("vertical") or z = `at` between two heights or sides."""
    if axis == "vertical":
        return (at - width / 2, low, at + width / 2, high)
    return (low, at - width / 2, high, at + width / 2)


def view(
    eye: tuple[float, float, float],
    bars: Sequence[Box] = (),
    hole: Box = HOLE,
    gsd: float = 0.005,
    curtain: bool = False,
    sigma_pose: float = 0.001,
) -> WindowView:
    """Returns a photo of the window from `eye`, on request with a striped curtain 0.4 m behind the glass."""
    return _view(eye, tuple(bars), hole, gsd, curtain, sigma_pose)


@lru_cache(maxsize=64)
def _view(
    eye: tuple[float, float, float],
    bars: tuple[Box, ...],
    hole: Box,
    gsd: float,
    curtain: bool,
    sigma_pose: float,
) -> WindowView:
    middle = np.array([(hole[0] + hole[2]) / 2, 0.0, (hole[1] + hole[3]) / 2])
    way = middle - np.array(eye)
    reach = float(np.linalg.norm(way))
    forward = way / reach
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    R = np.column_stack([right, np.cross(forward, right), forward])
    size = int(1.3 * max(hole[2] - hole[0], hole[3] - hole[1]) / gsd)
    camera = Camera("PINHOLE", size, size, np.array([reach / gsd, reach / gsd, size / 2, size / 2]))
    pose = Rigid3("local", "camera", R, np.array(eye))
    name = f"from {eye[0]:g} {eye[1]:g} {eye[2]:g}"
    photo = Photo(name, camera, Estimate(pose, np.diag([sigma_pose**2] * 3 + [1e-10] * 3), 100.0))
    pixels = _painted(photo, size, bars, hole, curtain)
    return WindowView(photo, pixels, (0, 0), 1.0, gsd, float(forward[1]))


def _painted(photo: Photo, size: int, bars: Sequence[Box], hole: Box, curtain: bool) -> Array:
    fine = (np.arange(2 * size) + 0.5) / 2
    column, row = np.meshgrid(fine, fine)
    start, rays = photo.ray(np.column_stack([column.ravel(), row.ravel()]))
    wall, frame, room = (_at(start, rays, y) for y in (0.0, DEPTH, DEPTH + 0.4))
    grey = np.full(len(rays), 60.0)
    if curtain:
        grey += 60.0 * (np.floor(room[:, 0] / 0.1) % 2)
    x0, z0, x1, z1 = hole
    wood = ~_inside(frame, (x0 + FRAME, z0 + FRAME, x1 - FRAME, z1 - FRAME))
    for box in bars:
        wood |= _inside(frame, box)
    grey[wood] = 200.0
    grey[~_inside(wall, hole)] = 140.0
    mean = grey.reshape(size, 2, size, 2).mean((1, 3))
    noise = np.random.default_rng(7).normal(0, 2, mean.shape)
    return np.repeat(np.clip(mean + noise, 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def _at(start: Float, rays: Float, y: float) -> Float:
    points = start + ((y - start[1]) / rays[:, 1])[:, None] * rays
    return points[:, [0, 2]]


def _inside(xz: Float, box: Box) -> Array:
    return ((xz > box[:2]) & (xz < box[2:])).all(1)


def window(
    views: Sequence[WindowView],
    hole: Box = HOLE,
    name: str = "B01/F1/W1-1",
    depth: float | None = DEPTH,
    sigma: float = 0.01,
) -> Window:
    """Returns a window as a scan gives it: its outline, and its depth with an error of 1 cm or None."""
    x0, z0, x1, z1 = hole
    ring = np.array([[x0, z0], [x1, z0], [x1, z1], [x0, z1]])
    opening = Opening(
        id=name,
        kind="window",
        ring=ring,
        ring_covariance=np.eye(8) * sigma**2,
        depth=None if depth is None else Estimate(depth, np.array([[0.01**2]]), 20.0),
        shape="rectangle",
        provenance=Provenance.MEASURED,
        evidence=100.0,
        confidence=1.0,
        floor=1,
        bay=1,
        photos=tuple(v.photo.id for v in views),
    )
    return Window(opening, FRAME_OF_FACADE, 0.0, tuple(views), np.empty((0, 3)), 0.01)


def centres(bars: Sequence[Box], upright: bool) -> list[float]:
    """Returns the positions of the upright or the level ones of rectangles."""
    some = [b for b in bars if (b[3] - b[1] > b[2] - b[0]) == upright]
    return sorted((b[0] + b[2]) / 2 if upright else (b[1] + b[3]) / 2 for b in some)


X0, Z0, X1, Z1 = HOLE
MULLION = bar("vertical", 0.02, Z0, Z1)
TRANSOM = bar("horizontal", 2.8, X0, X1)
DIVISIONS: dict[str, list[Box]] = {
    "mullion": [MULLION],
    "transom": [TRANSOM],
    "cross": [MULLION, TRANSOM],
    "grid": [bar("vertical", -0.2, Z0, Z1), bar("vertical", 0.2, Z0, Z1), bar("horizontal", 2.7, X0, X1)],
    "T": [TRANSOM, bar("vertical", 0.0, Z0, 2.8)],
    "one side divided": [
        bar("vertical", 0.2, Z0, Z1),
        bar("horizontal", 2.45, X0, 0.2),
        bar("horizontal", 2.8, X0, 0.2),
    ],
}
"""Windows by how they are divided."""
