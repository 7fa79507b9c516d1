"""How much of the sky every pixel's surface sees: few rays on a coarse grid, smoothed within each face."""

import numpy as np

from frontage.geometry.arrays import Array, Float, Int
from frontage.simulate.raygrid import RayGrid, finite
from frontage.simulate.stage import Sight, Stage

_STEP = 4  # px between the places where rays are cast
_RAYS = 4
_PASSES = (1, 2, 4)  # distances of the smoothing kernel, in grid cells (a-trous)


class OpennessMap:
    """Openness on a grid of every fourth pixel of one photo."""

    def __init__(self, stage: Stage, grid: RayGrid, origin: Float, R: Float) -> None:
        """Cast the rays of a photo taken at `origin` (3,) m local, local_from_camera rotation R (3, 3)."""
        h, w = grid.camera.height, grid.camera.width
        rows = range(min(_STEP // 2, h - 1), h, _STEP)
        columns = np.arange(min(_STEP // 2, w - 1), w, _STEP)
        rays = np.stack([grid.rows(r, r + 1)[0, columns] for r in rows])
        seen = finite(rays).ravel()
        ways = np.where(seen[:, None], rays.reshape(-1, 3), [0.0, 0.0, 1.0]) @ R.T
        triangle, xyz = self._solid(stage, origin, ways)
        triangle[~seen] = -1
        face = np.where(triangle >= 0, stage.faces[triangle], 0)
        hit = np.flatnonzero(triangle >= 0)
        free = np.ones(len(triangle), np.float32)
        free[hit] = stage.openness(triangle[hit], xyz[hit], ways[hit], _RAYS)
        shape = (len(rows), len(columns))
        self._face = face.reshape(shape).astype(np.uint32)
        self._free = _smoothed(free.reshape(shape), self._face)
        self._stage = stage

    def at(self, row: Array, column: Array, sight: Sight, which: Int) -> Array:
        """Openness (m,) float32 of what `sight`'s rays `which` (m,) see in pixels (row, column) (m,)."""
        solid = sight.solid[which]
        face = np.where(solid >= 0, self._stage.faces[solid], np.uint32(0))
        y, x = (
            np.clip((c - _STEP // 2) / _STEP, 0, n - 1)
            for c, n in zip((row, column), self._face.shape, strict=True)
        )
        total, weight = np.zeros((2, len(which)), np.float32)
        spare = np.zeros(len(which), np.float32)
        y0, x0 = np.floor(y).astype(np.int64), np.floor(x).astype(np.int64)
        for dy in (0, 1):
            for dx in (0, 1):
                i, j = (
                    np.minimum(y0 + dy, self._face.shape[0] - 1),
                    np.minimum(x0 + dx, self._face.shape[1] - 1),
                )
                share = (1 - np.abs(y - y0 - dy)) * (1 - np.abs(x - x0 - dx)) + 1e-3
                value = self._free[i, j]
                same = share * (self._face[i, j] == face)
                total += same * value
                weight += same
                spare += 0.25 * value
        return np.where(weight > 0, total / np.maximum(weight, 1e-9), spare).astype(np.float32)

    @staticmethod
    def _solid(stage: Stage, origin: Float, ways: Float) -> tuple[Int, Float]:
        hits = stage.solid.first_hit(origin, ways)
        return hits.triangle.copy(), origin + ways * np.where(hits.found, hits.distance, 0.0)[:, None]


def _smoothed(free: Array, face: Array) -> Array:
    """Means over 3 x 3 cells at growing distances, over cells of the same face only."""
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
