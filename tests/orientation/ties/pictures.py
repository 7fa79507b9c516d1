"""Rendered photos of textured boards at several depths, whose cameras and poses are known exactly."""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.rigid import Rigid3
from frontage.model import Camera

PER_METRE = 80.0  # texture px


@dataclass(frozen=True)
class Board:
    """A textured rectangle at depth z (m), its left upper corner at x, y (m)."""

    texture: np.ndarray
    x: float
    y: float
    z: float


def noise(width, height, seed):
    """A texture (h, w, 3) uint8 of `width` x `height` m with detail of several sizes."""
    rng = np.random.default_rng(seed)
    h, w = round(height * PER_METRE), round(width * PER_METRE)
    total = np.zeros((h, w), np.float32)
    for step, weight in ((1, 1.0), (3, 1.0), (8, 1.2), (24, 1.0)):
        grain = rng.normal(size=(h // step + 4, w // step + 4)).astype(np.float32)
        layer = cv2.resize(cv2.GaussianBlur(grain, (0, 0), 1.3), (w + 4 * step, h + 4 * step))[:h, :w]
        total += weight * layer / layer.std()
    grey = np.clip(128 + 38 * total, 0, 255)
    return np.repeat(grey[..., None], 3, axis=2).astype(np.uint8)


def windows(width, height, pitch, *, plaster=None, columns=None):
    """A texture of identical windows every `pitch` m on an even wall, or on a wall of texture `plaster`."""
    h, w = round(height * PER_METRE), round(width * PER_METRE)
    wall = np.full((h, w, 3), 170, np.uint8) if plaster is None else plaster[:h, :w].copy()
    pane = noise(0.45 * pitch, 0.6 * pitch, 7)
    cv2.rectangle(pane, (0, 0), (pane.shape[1] - 1, pane.shape[0] - 1), (240, 240, 240), 6)
    cv2.line(pane, (pane.shape[1] // 2, 0), (pane.shape[1] // 2, pane.shape[0]), (240, 240, 240), 5)
    for i in range(int(width / pitch) if columns is None else columns):
        for j in range(int(height / pitch)):
            y, x = (round((k + 0.25) * pitch * PER_METRE) for k in (j, i))
            wall[y : y + pane.shape[0], x : x + pane.shape[1]] = pane[: h - y, : w - x]
    return wall


def relief(seed=0):
    """A wall 14 x 9 m at 10 m, with boards up to 2 m before it."""
    rng = np.random.default_rng(seed)
    boards = [Board(noise(14, 9, seed), -7, -4.5, 10.0)]
    for k in range(10):
        x, y = rng.uniform(-6, 4.5), rng.uniform(-4, 2.5)
        boards.append(Board(noise(1.5, 1.5, 100 * seed + k + 1), x, y, 10 - rng.uniform(0.3, 2.0)))
    return boards


def camera(width=640, height=480, focal=540.0):
    return Camera("PINHOLE", width, height, np.array([focal, focal, width / 2 + 3.0, height / 2 - 2.0]))


def pose(x, *, y=0.0, z=0.0, turn=0.0, roll=0.0):
    """local_from_camera at (x, y, z) m, turned to the right and rolled by degrees."""
    a, b = np.radians([turn, roll])
    yaw = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    spin = np.array([[np.cos(b), -np.sin(b), 0], [np.sin(b), np.cos(b), 0], [0, 0, 1]])
    return Rigid3("local", "camera", yaw @ spin, np.array([x, y, z]))


def render(boards, view, lens, *, seed=0, blur=0.0):
    """The picture (h, w, 3) uint8 that a pinhole camera takes at the pose `view`."""
    f, g, cx, cy = lens.params
    K = np.array([[f, 0, cx], [0, g, cy], [0, 0, 1.0]])
    turn, centre = view.R.T, view.t
    size = (lens.width * 2, lens.height * 2)  # twice the resolution, against aliasing
    picture = np.full((size[1], size[0], 3), 90, np.uint8)
    double = np.diag([2.0, 2.0, 1.0])
    whole = np.array([[1, 0, -0.5], [0, 1, -0.5], [0, 0, 1.0]])  # cv2 counts from the first centre
    for board in sorted(boards, key=lambda b: -b.z):
        corner = np.array([board.x, board.y, board.z]) - centre
        board_px = np.column_stack([turn[:, 0] / PER_METRE, turn[:, 1] / PER_METRE, turn @ corner])
        H = whole @ double @ K @ board_px @ np.linalg.inv(whole)
        layer = cv2.warpPerspective(board.texture, H, size, flags=cv2.INTER_CUBIC)
        mask = cv2.warpPerspective(np.full(board.texture.shape[:2], 255, np.uint8), H, size)
        picture[mask > 127] = layer[mask > 127]
    small = cv2.resize(picture, (lens.width, lens.height), interpolation=cv2.INTER_AREA).astype(np.float32)
    if blur:
        small = cv2.GaussianBlur(small, (0, 0), blur)
    small += np.random.default_rng(seed).normal(0, 1.5, small.shape)
    return np.clip(np.round(small), 0, 255).astype(np.uint8)
