"""A photo's light: one ray per pixel, more where anything changes from a pixel to the next.

Surfaces are prefiltered (see `materials`), so only edges alias: of faces, of shadows, of what panes mirror.
There a pixel gets several samples; those of one face in one light are shaded once.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Camera
from frontage.simulate.openness import OpennessMap
from frontage.simulate.raygrid import RayGrid, finite
from frontage.simulate.samples import group, lattice
from frontage.simulate.shading import radiance
from frontage.simulate.stage import Stage

_BAND = 250_000  # pixels worked on at a time
_SPLIT = 400_000  # samples at edges traced at a time
_THREADS = 2  # casting rays holds the interpreter lock; the arithmetic of another band runs meanwhile


def render(stage: Stage, camera: Camera, local_from_camera: Rigid3, samples: int = 5) -> Array:
    """Light (h, w, 3) float32, linear, that reaches the pixels; 0 where the lens sees nothing."""
    grid = RayGrid(camera)
    view = _View(stage, camera, local_from_camera, grid, samples)
    rows = max(1, _BAND // camera.width)
    bands = [(r, min(r + rows, camera.height)) for r in range(0, camera.height, rows)]
    with ThreadPoolExecutor(_THREADS) as pool:
        return np.concatenate(list(pool.map(lambda b: view.band(*b), bands)))


class _View:
    """One photo being rendered."""

    def __init__(self, stage: Stage, camera: Camera, pose: Rigid3, grid: RayGrid, samples: int) -> None:
        self.stage, self.camera, self.pose, self.grid = stage, camera, pose, grid
        self.openness = OpennessMap(stage, grid, pose.t, pose.R)
        self.offsets = lattice(samples)

    def band(self, first: int, end: int) -> Array:
        """Light (end - first, w, 3) float32 of rows first..end-1; one more row on either side is traced."""
        top, bottom = max(first - 1, 0), min(end + 1, self.camera.height)
        rays = self.grid.rows(top, bottom)
        seen = finite(rays)
        rays = np.where(seen[..., None], rays, [0.0, 0.0, 1.0]) @ self.pose.R.T
        sight = self.stage.look(self.pose.t, rays.reshape(-1, 3))
        edge = _changes(np.where(seen, sight.key.reshape(seen.shape), np.uint32(1)))
        inner = np.zeros(seen.shape, np.bool_)
        inner[first - top : first - top + end - first] = True
        out = np.zeros((seen.size, 3), np.float32)
        split = inner & edge & _inside(seen) if len(self.offsets) > 1 else np.zeros_like(inner)
        plain = np.flatnonzero(inner & seen & ~split)
        row, column = np.divmod(plain, self.camera.width)
        free = self.openness.at(row + top, column, sight, plain)
        out[plain] = radiance(self.stage, sight, plain, free, self.grid.angle)
        pixels = np.flatnonzero(split)
        many = max(1, _SPLIT // len(self.offsets))
        for k in range(0, len(pixels), many):
            out[pixels[k : k + many]] = self._split(rays, pixels[k : k + many], top)
        return out.reshape(*seen.shape, 3)[first - top : first - top + end - first]

    def _split(self, rays: Float, pixels: Array, top: int) -> Array:
        """Mean light (k, 3) of the samples of `pixels` (k,), flat indices into rays (m, w, 3)."""
        row, column = np.divmod(pixels, self.camera.width)
        right, down = _slope(rays, row, column, 1), _slope(rays, row, column, 0)
        ways = (
            rays[row, column][:, None]
            + self.offsets[:, :1] * right[:, None]
            + self.offsets[:, 1:] * down[:, None]
        ).reshape(-1, 3)
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        sight = self.stage.look(self.pose.t, ways)
        groups = group(sight.key, len(self.offsets))
        pick = groups.pick
        place = sight.xyz.copy()
        place[pick] = groups.mean(sight.xyz)  # a group is shaded in its middle
        sight = replace(sight, xyz=place)
        pixel = pick // len(self.offsets)
        free = self.openness.at(row[pixel] + top, column[pixel], sight, pick)
        return groups.blend(radiance(self.stage, sight, pick, free, self.grid.angle))


def _changes(key: Array) -> Bool:
    """Pixels (h, w) that differ from one of their four neighbours."""
    edge = np.zeros(key.shape, np.bool_)
    across, down = key[:, 1:] != key[:, :-1], key[1:] != key[:-1]
    edge[:, 1:] |= across
    edge[:, :-1] |= across
    edge[1:] |= down
    edge[:-1] |= down
    return edge


def _inside(seen: Bool) -> Bool:
    """Pixels whose neighbours have directions too."""
    inside = seen.copy()
    inside[:, 1:] &= seen[:, :-1]
    inside[:, :-1] &= seen[:, 1:]
    inside[1:] &= seen[:-1]
    inside[:-1] &= seen[1:]
    return inside


def _slope(rays: Float, row: Array, column: Array, axis: int) -> Float:
    """Change (k, 3) of the direction per pixel down (axis 0) or across (1); one-sided at the border."""
    at = [row, column]
    ahead, behind = list(at), list(at)
    ahead[axis] = np.minimum(at[axis] + 1, rays.shape[axis] - 1)
    behind[axis] = np.maximum(at[axis] - 1, 0)
    width = np.maximum(ahead[axis] - behind[axis], 1)
    return np.asarray((rays[tuple(ahead)] - rays[tuple(behind)]) / width[:, None])
