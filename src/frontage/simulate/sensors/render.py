"""Renders the light of a photo: one ray for every second pixel, several per pixel along edges.

Textures are prefiltered (see `materials`), so only the edges of faces, of shadows and of what panes mirror
can alias. There a pixel gets several samples; those that see one face in one light are shaded once.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Camera
from frontage.simulate.optics.litscene import LitScene, ViewHits
from frontage.simulate.optics.openness import OpennessMap
from frontage.simulate.optics.raygrid import RayGrid, finite
from frontage.simulate.optics.samples import group_samples, lattice
from frontage.simulate.optics.shading import radiance

_BAND = 250_000  # pixels worked on at a time
_SPLIT = 400_000  # samples along edges that are traced at a time
_THREADS = 2  # casting rays holds the interpreter lock, while the arithmetic of another band runs


def render(lit_scene: LitScene, camera: Camera, local_from_camera: Rigid3, samples: int = 5) -> Array:
    """Return the linear light (h, w, 3) float32 that reaches the pixels; 0 where the lens sees nothing."""
    grid = RayGrid(camera)
    renderer = _Renderer(lit_scene, camera, local_from_camera, grid, samples)
    rows = max(1, _BAND // camera.width)
    bands = [(r, min(r + rows, camera.height)) for r in range(0, camera.height, rows)]
    with ThreadPoolExecutor(_THREADS) as pool:
        return np.concatenate(list(pool.map(lambda b: renderer.render_rows(*b), bands)))


class _Renderer:
    """One photo being rendered."""

    def __init__(
        self, lit_scene: LitScene, camera: Camera, pose: Rigid3, grid: RayGrid, samples: int
    ) -> None:
        self.lit_scene, self.camera, self.pose, self.grid = lit_scene, camera, pose, grid
        self.openness = OpennessMap(lit_scene, grid, pose.t, pose.R)
        self.offsets = lattice(samples)

    def render_rows(self, first: int, end: int) -> Array:
        """Render rows `first` to `end` - 1: light (end - first, w, 3) float32.

        Rays are cast for every second pixel, like the white squares of a chessboard. Any other pixel whose
        four neighbours see the same faces in the same light is taken to see them too. One more row on either
        side is used.
        """
        top, bottom = max(first - 1, 0), min(end + 1, self.camera.height)
        rays = self.grid.rows(top, bottom)
        seen = finite(rays)
        rays = np.where(seen[..., None], rays, [0.0, 0.0, 1.0]) @ self.pose.R.T
        cast = (np.arange(top, bottom)[:, None] + np.arange(self.camera.width)) % 2 == 0
        directions, chosen = rays.reshape(-1, 3), np.flatnonzero(cast)
        view = self.lit_scene.cast(self.pose.t, directions[chosen])
        key, index = np.zeros(seen.shape, np.uint32), np.zeros(seen.shape, np.int64)
        key[cast], index[cast] = np.where(seen[cast], view.key, np.uint32(1)), np.arange(len(chosen))
        edge = _changes(key, cast)
        inner = np.zeros(seen.shape, np.bool_)
        inner[first - top : first - top + end - first] = True
        split = inner & edge & _inside(seen) if len(self.offsets) > 1 else np.zeros_like(inner)
        plain = inner & seen & ~split
        out = np.zeros((seen.size, 3), np.float32)
        at = np.flatnonzero(plain & cast)
        out[at] = self._light(view, index.ravel()[at], at, top)
        at = np.flatnonzero(plain & ~cast & edge)
        out[at] = self._light(self.lit_scene.cast(self.pose.t, directions[at]), np.arange(len(at)), at, top)
        at = np.flatnonzero(plain & ~cast & ~edge)
        beside = np.pad(index, 1, mode="reflect")[1:-1, :-2].ravel()[at]
        same = self.lit_scene.follow(view, beside, self.pose.t, directions[at])
        out[at] = self._light(same, np.arange(len(at)), at, top)
        at = np.flatnonzero(split)
        many = max(1, _SPLIT // len(self.offsets))
        for k in range(0, len(at), many):
            out[at[k : k + many]] = self._split(rays, at[k : k + many], top)
        return out.reshape(*seen.shape, 3)[first - top : first - top + end - first]

    def _light(self, view: ViewHits, which: Array, pixels: Array, top: int) -> Array:
        """Returns the light (k, 3) of rays `which` (k,) of `view`; `pixels` (k,) count from row `top`."""
        row, column = np.divmod(pixels, self.camera.width)
        free = self.openness.at(row + top, column, view, which)
        return radiance(self.lit_scene, view, which, free, self.grid.angle)

    def _split(self, rays: Float, pixels: Array, top: int) -> Array:
        """Returns the mean light (k, 3) of several samples of `pixels` (k,), indices into rays (m, w, 3)."""
        row, column = np.divmod(pixels, self.camera.width)
        right, down = _slope(rays, row, column, 1), _slope(rays, row, column, 0)
        directions = (
            rays[row, column][:, None]
            + self.offsets[:, :1] * right[:, None]
            + self.offsets[:, 1:] * down[:, None]
        ).reshape(-1, 3)
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        view = self.lit_scene.cast(self.pose.t, directions)
        groups = group_samples(view.key, len(self.offsets))
        pick = groups.pick
        place = view.xyz.copy()
        place[pick] = groups.mean(view.xyz)  # a group is shaded in its middle
        view = replace(view, xyz=place)
        return groups.blend(self._light(view, pick, pixels[pick // len(self.offsets)], top))


def _changes(key: Array, cast: Bool) -> Bool:
    """Returns the pixels (h, w) that see something else than their neighbours, from the keys of every second.

    Pixels with a key of their own (`cast`) are compared with their diagonal neighbours; for other pixels, the
    four neighbours are compared with each other.
    """
    wide = np.pad(key, 1, mode="reflect")
    corner = (wide[:-2, :-2], wide[:-2, 2:], wide[2:, :-2], wide[2:, 2:])
    left, beside = wide[1:-1, :-2], (wide[1:-1, 2:], wide[:-2, 1:-1], wide[2:, 1:-1])
    own = np.logical_or.reduce([c != key for c in corner])
    between = np.logical_or.reduce([b != left for b in beside])
    return np.asarray(np.where(cast, own, between))


def _inside(seen: Bool) -> Bool:
    """Returns the pixels that have a direction and whose neighbours have one too."""
    inside = seen.copy()
    inside[:, 1:] &= seen[:, :-1]
    inside[:, :-1] &= seen[:, 1:]
    inside[1:] &= seen[:-1]
    inside[:-1] &= seen[1:]
    return inside


def _slope(rays: Float, row: Array, column: Array, axis: int) -> Float:
    """Returns the change (k, 3) of the direction per pixel down (axis 0) or across (1).

    It is one-sided at the border.
    """
    at = [row, column]
    ahead, behind = list(at), list(at)
    ahead[axis] = np.minimum(at[axis] + 1, rays.shape[axis] - 1)
    behind[axis] = np.maximum(at[axis] - 1, 0)
    width = np.maximum(ahead[axis] - behind[axis], 1)
    return np.asarray((rays[tuple(ahead)] - rays[tuple(behind)]) / width[:, None])
