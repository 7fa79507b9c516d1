"""Painted upright walls, their scan, and photos of them: everything is known exactly."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import map_coordinates

from frontage.geometry.rigid import Rigid3
from frontage.model import Camera, Estimate, Photo, Scan, WorldRef

PIXEL = 0.02  # m, of the paint
WORLD = WorldRef(np.zeros(3, np.int64))
LANDSCAPE = Camera("OPENCV", 800, 600, np.array([600.0, 603.0, 404.0, 296.0, -0.05, 0.01, 1e-3, -5e-4]))
PORTRAIT = Camera("PINHOLE", 600, 800, np.array([610.0, 610.0, 297.0, 405.0]))
EXACT = np.zeros((6, 6))


def paint(width, height, seed=1, steps=(4, 9, 25)):
    """Grey tones 0.05..1 of a wall of so many metres, with detail of so many pixels of 2 cm."""
    rng = np.random.default_rng(seed)
    h, w = round(height / PIXEL), round(width / PIXEL)
    total = np.zeros((h, w), np.float32)
    for step in steps:
        grain = rng.normal(size=(h // step + 3, w // step + 3)).astype(np.float32)
        total += cv2.resize(grain, (w, h), interpolation=cv2.INTER_CUBIC)
    return np.clip(0.5 + 0.15 * total, 0.05, 1.0)


def windows(width, height, pitch=2.0):
    """Grey tones of an even wall with equal windows `pitch` m apart."""
    tones = np.full((round(height / PIXEL), round(width / PIXEL)), 0.6, np.float32)
    side, step = round(0.5 * pitch / PIXEL), round(pitch / PIXEL)
    for row in range(step // 4, tones.shape[0] - side, step):
        for column in range(step // 4, tones.shape[1] - side, step):
            tones[row : row + side, column : column + side] = 0.95
            tones[row + 5 : row + side - 5, column + 5 : column + side - 5] = 0.15
    return tones


@dataclass(frozen=True, eq=False)
class Wall:
    """A wall from its lower left corner (as seen from the street) along a level direction, with its tones."""

    corner: tuple[float, float, float]
    along: tuple[float, float, float]
    tones: np.ndarray

    @property
    def size(self):
        h, w = self.tones.shape
        return w * PIXEL, h * PIXEL

    @property
    def inward(self):
        return np.cross([0.0, 0.0, 1.0], self.along)

    def tone(self, x, z):
        rows = np.array([(self.size[1] - z) / PIXEL - 0.5, x / PIXEL - 0.5])
        return map_coordinates(self.tones, rows, order=1, mode="nearest")

    def points(self, step, rng, noise=0.001):
        """Points on a jittered grid of `step` m, and their tones."""
        x, z = np.meshgrid(*(np.arange(step / 2, side, step) for side in self.size))
        x, z = (v.ravel() + rng.uniform(-0.2, 0.2, v.size) * step for v in (x, z))
        xyz = np.asarray(self.corner) + x[:, None] * np.asarray(self.along) + z[:, None] * [0.0, 0.0, 1.0]
        return xyz + rng.normal(0, noise, len(x))[:, None] * self.inward, self.tone(x, z)

    def met(self, origin, ray):
        """Distance along rays (inf where they miss the wall) and the tones that they meet."""
        with np.errstate(divide="ignore", invalid="ignore"):
            way = (np.asarray(self.corner) - origin) @ self.inward / (ray @ self.inward)
            at = origin + way[:, None] * ray - self.corner
        x, z = at @ np.asarray(self.along), at[:, 2]
        hit = (way > 0) & (x > 0) & (x < self.size[0]) & (z > 0) & (z < self.size[1])
        return np.where(hit, way, np.inf), self.tone(np.where(hit, x, 0.0), np.where(hit, z, 0.0))


def corner_of_two(seed=1):
    """Two painted walls that meet at a right angle, in view of a street at y < 0."""
    front = Wall((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), paint(12.0, 7.0, seed))
    side = Wall((12.0, 0.0, 0.0), (0.0, -1.0, 0.0), paint(6.0, 7.0, seed + 50))
    return front, side


def scan_of(walls: Sequence[Wall], step=0.03, origin=(6.0, -9.0, 1.6), noise=0.001, seed=0):
    """A scan of walls from one station; its intensity is their paint."""
    rng = np.random.default_rng(seed)
    parts = [wall.points(step, rng, noise) for wall in walls]
    xyz, tone = (np.concatenate(values) for values in zip(*parts, strict=True))
    index = np.zeros(len(xyz), np.int32)
    return Scan("painted", xyz, WORLD, np.array([origin]), index, intensity=tone.astype(np.float32) * 0.9)


def looking(x, y, z=1.7, heading=0.0, pitch=6.0, roll=0.0):
    """The pose of a camera that looks along +y, turned to the right, up and clockwise by degrees."""
    yaw, up, spin = (
        cv2.Rodrigues(np.radians(a) * np.array(axis))[0]
        for a, axis in ((-heading, (0.0, 0.0, 1.0)), (pitch, (1.0, 0.0, 0.0)), (roll, (0.0, 0.0, 1.0)))
    )
    level = np.column_stack([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    return Rigid3("local", "camera", yaw @ up @ level @ spin, np.array([x, y, z]))


def posed(pose, camera=LANDSCAPE, name="photo"):
    return Photo(name, camera, Estimate(pose, EXACT, 0.0))


def photograph(walls: Sequence[Wall], photo: Photo, seed=0):
    """The picture (h, w, 3) uint8 of walls before a grey sky."""
    camera = photo.camera
    column, row = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    origin, ray = photo.ray(np.column_stack([column.ravel(), row.ravel()]))
    origin = np.broadcast_to(origin, ray.shape)
    nearest, tone = np.full(len(ray), np.inf), np.full(len(ray), 0.4)
    for wall in walls:
        way, own = wall.met(origin, ray)
        closer = way < nearest
        nearest, tone = np.where(closer, way, nearest), np.where(closer, own, tone)
    grey = 230 * np.sqrt(tone) + np.random.default_rng(seed).normal(0, 1.0, len(tone))
    return np.repeat(np.clip(grey, 0, 255).astype(np.uint8).reshape(*row.shape, 1), 3, axis=2)
