"""The sky view factor of what every pixel sees: few rays on a coarse grid, smoothed within each face."""

import numpy as np

from frontage.geometry.arrays import Array, Float, Int
from frontage.simulate.optics.litscene import LitScene, ViewHits
from frontage.simulate.optics.raygrid import RayGrid, finite

_CELLS = 500  # approximate number along the longer side of the picture
_LEAST_STEP_PX = 4  # least distance between the pixels for which rays are cast
_RAYS = 4  # number cast per cell
_DITHER: Int = np.array([[0, 2, 1, 3], [3, 1, 2, 0], [1, 3, 0, 2], [2, 0, 3, 1]])
_PASSES = (1, 2, 4)  # distances of the smoothing kernel, in grid cells (a-trous)


class OpennessMap:
    """The openness (sky view factor) on a coarse grid of one photo."""

    def __init__(self, lit_scene: LitScene, grid: RayGrid, origin: Float, R: Float) -> None:
        """Cast the rays of a photo taken at `origin` (3,) m local; R (3, 3) is local_from_camera's."""
        h, w = grid.camera.height, grid.camera.width
        self._step = step = max(_LEAST_STEP_PX, max(h, w) // _CELLS)
        rows = range(min(step // 2, h - 1), h, step)
        columns = np.arange(min(step // 2, w - 1), w, step)
        rays = np.stack([grid.rows(r, r + 1)[0, columns] for r in rows])
        seen = finite(rays).ravel()
        directions = np.where(seen[:, None], rays.reshape(-1, 3), [0.0, 0.0, 1.0]) @ R.T
        triangle, xyz = self._solid(lit_scene, origin, directions)
        triangle[~seen] = -1
        face = lit_scene.faces[triangle]
        hit = np.flatnonzero(triangle >= 0)
        free = np.ones(len(triangle), np.float32)
        free[hit] = lit_scene.openness(triangle[hit], xyz[hit], directions[hit], _RAYS)
        shape = (len(rows), len(columns))
        self._face = face.reshape(shape)
        self._free = _smoothed(free.reshape(shape), self._face)
        self._lit_scene = lit_scene

    def at(self, row: Array, column: Array, view: ViewHits, which: Int) -> Array:
        """Return the openness (m,) float32 of what the rays `which` (m,) of `view` meet.

        row, column (m,) are the pixels that these rays belong to.
        """
        face = self._lit_scene.faces[view.solid[which]]
        h, w = self._face.shape
        # ordered dithering picks each of the four cells around a pixel as often as bilinear weights would
        step, half = self._step, self._step // 2
        i = np.clip((row - half + _DITHER[row & 3, column & 3] * step // 4) // step, 0, h - 1)
        j = np.clip((column - half + _DITHER[column & 3, row & 3] * step // 4) // step, 0, w - 1)
        free = self._free[i, j]
        other = np.flatnonzero(self._face[i, j] != face)
        free[other] = self._nearby(i[other], j[other], face[other], free[other])
        return np.asarray(free, np.float32)

    def _nearby(self, i: Int, j: Int, face: Array, spare: Array) -> Array:
        """Averages those of the 3 x 3 cells around (i, j) (k,) that show `face` (k,); `spare` without any."""
        h, w = self._face.shape
        total, weight = np.zeros((2, len(i)), np.float32)
        for di in (-1, 0, 1):
            for dj in (-1, 0, 1):
                near = np.clip(i + di, 0, h - 1), np.clip(j + dj, 0, w - 1)
                same = self._face[near] == face
                total += same * self._free[near]
                weight += same
        return np.where(weight > 0, total / np.maximum(weight, 1.0), spare)

    @staticmethod
    def _solid(lit_scene: LitScene, origin: Float, directions: Float) -> tuple[Int, Float]:
        hits = lit_scene.solid.first_hit(origin, directions)
        return hits.triangle.copy(), origin + directions * np.where(hits.found, hits.distance, 0.0)[:, None]


def _smoothed(free: Array, face: Array) -> Array:
    """Averages 3 x 3 cells at growing distances, but only over cells of the same face."""
    for step in _PASSES:
        total, weight = np.zeros_like(free), np.zeros_like(free)
        wide, same = np.pad(free, step, mode="edge"), np.pad(face, step, mode="edge")
        h, w = free.shape
        for dy in (0, step, 2 * step):
            for dx in (0, step, 2 * step):
                match = same[dy : dy + h, dx : dx + w] == face
                total += match * wide[dy : dy + h, dx : dx + w]
                weight += match
        free = total / weight
    return free
