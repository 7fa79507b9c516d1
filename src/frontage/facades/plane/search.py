"""Search for wall planes by LO-MSAC on area-weighted points (paper A, section 2.1)."""

from dataclasses import dataclass

import numpy as np

from frontage.facades.cloud import BuildingCloud
from frontage.facades.options import FacadeOptions
from frontage.geometry.arrays import Array, Float, Int
from frontage.geometry.plane import fit_plane, fit_upright_plane, plane_offsets
from frontage.model.masonry import MASONRY
from frontage.solve.ransac import Consensus, lo_ransac

_SHARPEST_M = 0.006  # m, least inlier distance: mortar joints
_BASE_M = MASONRY.pier  # m, shortest base of a sample


@dataclass(eq=False)
class UprightWalls:
    """RANSAC problem of vertical planes through two points; a model is (nx, ny, 0, d) with n . p = d.

    xyz   (n, 3) m
    rise  (n,) weight of each point as the first of a sample: the height of its stack of voxels
    """

    xyz: Float
    rise: Float
    sample_size: int = 2

    def __post_init__(self) -> None:
        # scored in float32: coordinates are centred, and rounding (below 20 um at 200 m) does not matter
        self._plan = np.ascontiguousarray(self.xyz[:, :2].T, np.float32)
        self._total = np.cumsum(self.rise)

    def __len__(self) -> int:
        return len(self.xyz)

    def draw(self, rng: np.random.Generator, count: int) -> Int:
        """Draws pairs (count, 2): the first point by rise, the second the nearest of six beyond the base.

        The near second point lets small walls be hit as well.
        """
        total = self._total
        pick = np.searchsorted(total, rng.random((count, 7)) * total[-1], side="right")
        pick = np.minimum(pick, len(self) - 1)
        plan = self.xyz[pick][..., :2]
        apart = np.linalg.norm(plan[:, 1:] - plan[:, :1], axis=2)
        nearest = np.argmin(np.where(apart < _BASE_M, np.inf, apart), axis=1)
        return np.column_stack([pick[:, 0], pick[np.arange(count), 1 + nearest]]).astype(np.int64)

    def minimal(self, samples: Int) -> Float:
        """Returns the planes (j, 4) through pairs (k, 2) of points; pairs closer than the base give none."""
        a, b = self.xyz[samples[:, 0]], self.xyz[samples[:, 1]]
        along = (b - a)[:, :2]
        length = np.linalg.norm(along, axis=1)
        good = length >= _BASE_M
        n = np.column_stack([along[good, 1], -along[good, 0]]) / length[good, None]
        return np.column_stack([n, np.zeros(len(n)), (n * a[good, :2]).sum(1)])

    def residuals(self, models: Float, rows: Int | slice) -> Array:
        """Returns the signed distances (j, r) m of points from planes (j, 4)."""
        return np.asarray(
            models[:, :2].astype(np.float32) @ self._plan[:, rows] - models[:, 3:].astype(np.float32)
        )

    def fit(self, rows: Int, weights: Float) -> Float | None:
        """Fits a plane (4,) to a line in plan by total least squares; None when points do not span it."""
        flat = np.column_stack([self.xyz[rows, :2], np.zeros(len(rows))])
        if fit_plane(flat, weights)[2][2] < 1e-6:
            return None
        normal, centre = fit_upright_plane(flat, weights)
        return np.array([*normal, normal[:2] @ centre[:2]])


@dataclass(eq=False)
class FreeWalls:
    """RANSAC problem of planes through three points that lean at most `max_lean` rad.

    A model is (nx, ny, nz, d) with n . p = d.
    """

    xyz: Float
    max_lean: float
    sample_size: int = 3

    def __post_init__(self) -> None:
        self._space = np.ascontiguousarray(self.xyz.T, np.float32)

    def __len__(self) -> int:
        return len(self.xyz)

    def draw(self, rng: np.random.Generator, count: int) -> Int:
        """Draws triples (count, 3) of points at random."""
        return np.asarray(rng.integers(0, len(self), (count, 3)), np.int64)

    def minimal(self, samples: Int) -> Float:
        """Returns the planes (j, 4) through triples (k, 3) of points; those that lean too much give none."""
        a, b, c = (self.xyz[samples[:, k]] for k in range(3))
        n = np.cross(b - a, c - a)
        length = np.linalg.norm(n, axis=1)
        good = length > _BASE_M**2 / 2
        good[good] = np.abs(n[good, 2]) <= np.sin(self.max_lean) * length[good]
        n = n[good] / length[good, None]
        return np.column_stack([n, (n * a[good]).sum(1)])

    def residuals(self, models: Float, rows: Int | slice) -> Array:
        """Returns the signed distances (j, r) m of points from planes (j, 4)."""
        return np.asarray(
            models[:, :3].astype(np.float32) @ self._space[:, rows] - models[:, 3:].astype(np.float32)
        )

    def fit(self, rows: Int, weights: Float) -> Float | None:
        """Fits a plane (4,) by total least squares; None when it leans too much or points do not span it."""
        normal, centre, variances = fit_plane(self.xyz[rows], weights)
        if variances[1] < 1e-6 or abs(normal[2]) > np.sin(self.max_lean):
            return None
        return np.array([*normal, normal @ centre])


def stack_rise(xyz: Float, cell: float) -> Float:
    """Counts the points (n,) in each point's plan cell of `cell` m; walls stack up, ground does not."""
    key = ((xyz[:, :2] - xyz[:, :2].min(0)) / cell).astype(np.int64)
    size = key.max(0) + 1
    flat = key[:, 0] * size[1] + key[:, 1]
    if float(size[0]) * float(size[1]) > 4.0e7:
        flat = np.unique(flat, return_inverse=True)[1]
    return np.asarray(np.bincount(flat)[flat], np.float64)


def search_plane(
    xyz: Float, rise: Float, cloud: BuildingCloud, options: FacadeOptions, rng: np.random.Generator
) -> tuple[Float, Float] | None:
    """Finds the wall plane with the most area among thinned points (n, 3) m.

    `rise` (n,) comes from `stack_rise`. Returns unit normal (3,) and a point (3,) m on the plane, or None.
    """
    if len(xyz) < 3:
        return None
    centre = xyz.mean(0)
    local = xyz - centre
    found: Consensus | None
    if options.levelled:
        found = lo_ransac(UprightWalls(local, rise), cloud.threshold, rng)
    else:
        walls = FreeWalls(local, np.radians(options.max_lean))
        found = lo_ransac(walls, cloud.threshold, rng, max_hypotheses=8192)
    if found is None or not found.inliers.any():
        return None
    normal = found.model[:3]
    point = centre + normal * found.model[3]
    return normal, point + normal * modal_offset(xyz, normal, point, cloud, options)


def sharp_plane(q: Float, cloud: BuildingCloud, rng: np.random.Generator) -> Float | None:
    """Finds the upright plane y = c + a x with the most points (n, 3) m at the measured noise.

    `q` is in the frame of a plane found with the inlier distance of the search. That distance is never below
    2 cm, which is enough for shallow relief to hide in. Returns (c, a, 0), or None when the noise is no
    smaller than that, or when nothing is found.
    """
    threshold = max(3.0 * cloud.noise, _SHARPEST_M)
    if threshold > 0.7 * cloud.threshold or len(q) < 10:
        return None
    found = lo_ransac(UprightWalls(q, np.ones(len(q))), threshold, rng, max_hypotheses=512)
    if found is None or abs(found.model[1]) < 0.9:
        return None
    nx, ny, _, d = found.model
    return np.array([d / ny, -nx / ny, 0.0])


def modal_offset(
    xyz: Float, normal: Float, point: Float, cloud: BuildingCloud, options: FacadeOptions
) -> float:
    """Returns the offset (m) of the parallel surface near a plane that covers the most facade cells.

    Thinned points count area already. Each cell still counts once per offset bin, so that a deep front (a
    grille, ivy) cannot stack up.
    """
    offsets = plane_offsets(xyz, normal, point)
    width = cloud.threshold
    near = np.abs(offsets) < min(options.depth_front, options.depth_back)
    if not near.any():
        return 0.0
    across = np.array([-normal[1], normal[0]]) / np.hypot(normal[0], normal[1])
    cells = np.column_stack([xyz[near, :2] @ across, xyz[near, 2]]) / cloud.cell
    cells = (cells - cells.min(0)).astype(np.int64)
    step = np.rint(offsets[near] / width).astype(np.int64)
    step -= (low := step.min())
    flat = (step * (cells[:, 0].max() + 1) + cells[:, 0]) * (cells[:, 1].max() + 1) + cells[:, 1]
    area_of = (cells[:, 0].max() + 1) * (cells[:, 1].max() + 1)
    hit = np.zeros(int((step.max() + 1) * area_of), np.bool_)
    hit[flat] = True
    area = hit.reshape(-1, area_of).sum(1).astype(np.float64)
    pooled = area + np.pad(area, 1)[:-2] + np.pad(area, 1)[2:]  # a wall on the border of two bins
    best = int(np.argmax(pooled))
    chosen = np.abs(step - best) <= 1
    return float(np.median(offsets[near][chosen])) if abs(best + low) > 1 else 0.0
