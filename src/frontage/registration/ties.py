"""Tie two scans to one another: the coarse search in plan, then point-to-plane adjustment of their surfels.

A KD-tree over the surfels finds neighbours. Residuals and normal equations are distances along a surfel's
normal (not those of small_gicp 1.0.1, whose point-to-plane Hessian is wrong on walls oblique to the axes).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.model.masonry import TOLERANCES
from frontage.registration.coarse import Peak, plan_of_surfels, search_motions
from frontage.registration.equations import apply_step, geman_mcclure
from frontage.registration.result import PosePrior
from frontage.solve.surfels import Surfels

_WIDE_M = (2.0, 1.0, 0.5, 0.3)  # m, search distances after the coarse search
_CLOSE_M = (0.4, 0.2, 0.2)  # m, search distances once a place along the street has been found
_STEPS = 3  # steps at each search distance
_LEAST_AREA_M2 = 15.0  # m2 of common upright surface that ties two scans
_SOFT_M = 0.05  # m, distance at which common surface counts a quarter
_SLIDE_M = 0.2  # m between the places that are tried along the street
_RIVAL = 0.9  # share of the best common area; another place as good as that leaves the scans untied
_PEAKS = 4  # peaks of the coarse search that are refined
_MOST_SURFELS = 4000  # surfels of one scan in the adjustment, at most


@dataclass(frozen=True, eq=False)
class Tie:
    """Scan `b` tied to scan `a`.

    a_from_b  motion between the coordinates as given
    area      m2 of common upright surface
    """

    a: int
    b: int
    a_from_b: Rigid3
    area: float


def motion_of_peak(peak: Peak, pivot: Float, height: float = 0.0) -> Rigid3:
    """Returns the rigid motion of a peak about `pivot` (3,) m, raised by `height` m."""
    c, s = np.cos(peak.turn), np.sin(peak.turn)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return Rigid3("local", "given", R, pivot + np.array([*peak.shift, height]) - R @ pivot)


def tie_scans(pieces: Sequence[Surfels], priors: Sequence[PosePrior], a: int, b: int) -> Tie | None:
    """Ties scan b to scan a; None where they have too little in common, or as much at another place.

    Fronts let a street slide along itself. From the best peak on, the weakest direction is therefore searched
    in small steps. Setbacks, reveals, cars and posts tell the right place, whose common area stands out.
    """
    sigma: Float = np.sqrt(priors[a].sigma ** 2 + priors[b].sigma ** 2)
    pair = _ScanPair(_thin(pieces[b]), pieces[a], cKDTree(pieces[a].xyz), priors[b].position, sigma)
    plan = (plan_of_surfels(pieces[b]), plan_of_surfels(pieces[a]))
    reach = (float(sigma[:2].max()), float(sigma[5]))
    found = [
        pair.rated(pair.refine(pair.raised(p), _WIDE_M))
        for p in search_motions(*plan, pair.pivot[:2], reach, _PEAKS)
    ]
    if not found:
        return None
    _, first = max(found, key=lambda t: t[0])
    found += [pair.rated(pair.refine(pose, _CLOSE_M)) for pose in pair.slid(first)]
    found.sort(key=lambda t: -t[0])
    score, best = found[0]
    here = best.apply(pair.pivot[None])
    far = [rival for rival, pose in found if np.linalg.norm(pose.apply(pair.pivot[None]) - here) > 0.3]
    if score < _LEAST_AREA_M2 or (far and max(far) > _RIVAL * score):
        return None
    return Tie(a, b, best, score)


def _thin(s: Surfels) -> Surfels:
    """Returns every k-th surfel, with k times its area."""
    k = max(1, len(s) // _MOST_SURFELS)
    t = s.take(np.arange(0, len(s), k))
    return Surfels(t.xyz, t.normal, t.oriented, t.area * k, t.thickness)


@dataclass(frozen=True, eq=False)
class _ScanPair:
    """Two scans to be tied.

    source, target  thinned surfels of one, and all of the other; `tree` over the target's centres
    pivot           (3,) m, place of the source's instrument
    sigma           (6,) of the prior, m and rad
    """

    source: Surfels
    target: Surfels
    tree: cKDTree
    pivot: Float
    sigma: Float

    def raised(self, peak: Peak) -> Rigid3:
        """Returns the motion of a peak in plan, at the height where the ground of both scans meets."""
        flat = motion_of_peak(peak, self.pivot)
        return motion_of_peak(peak, self.pivot, _height(self.source.moved(flat), self.target))

    def refine(self, pose: Rigid3, stages: Sequence[float]) -> Rigid3:
        """Adjusts a pose by point-to-plane distances with a shrinking search distance.

        The difference of levels is a prior; `stages` m are the search distances.
        """
        start = pose.apply(self.pivot[None])[0]
        for within in stages:
            for _ in range(_STEPS):
                normal, gradient = self.normal(pose, within, start)
                step: Float = np.asarray(np.linalg.solve(normal, -gradient), np.float64)
                pose = apply_step(pose, self.pivot, step)
                if np.abs(step).max() < 1e-4:
                    break
        return pose

    def normal(self, pose: Rigid3, within: float, start: Float) -> tuple[Float, Float]:
        """Returns the normal matrix (6, 6) and the gradient (6,) of a step about the pivot.

        within  m, search distance; `start` (3,) m, place of the pivot before the adjustment
        """
        now = self.source.moved(pose)
        i, k = neighbours(now, self.target, self.tree, max(within, 0.25))
        n = self.target.normal[k]
        r = np.einsum("ij,ij->i", n, now.xyz[i] - self.target.xyz[k])
        here = pose.apply(self.pivot[None])[0]
        A = np.column_stack([n, np.cross(now.xyz[i] - here, n)])
        scale = within / 3
        w = geman_mcclure(r, scale) * np.minimum(now.area[i], 0.5) / scale**2
        off = np.concatenate([0.1 * (here - start), np.zeros(3)])
        return (A * w[:, None]).T @ A + np.diag(1 / self.sigma**2), A.T @ (w * r) + off / self.sigma**2

    def rated(self, pose: Rigid3) -> tuple[float, Rigid3]:
        """Returns a pose's common upright area (m2), reduced by its distance from the prior, and the pose."""
        off = (pose.apply(self.pivot[None])[0] - self.pivot)[:2] / self.sigma[:2]
        return self.common(pose) * float(np.exp(-0.01 * off @ off)), pose

    def common(self, pose: Rigid3) -> float:
        """Returns the upright area (m2) of the source that lies on the target; it fades with the distance."""
        now = self.source.take(self.source.upright).moved(pose)
        i, k = neighbours(now, self.target, self.tree, 0.25)
        r = np.einsum("ij,ij->i", self.target.normal[k], now.xyz[i] - self.target.xyz[k])
        return float(now.area[i] @ geman_mcclure(r, _SOFT_M))

    def slid(self, pose: Rigid3) -> list[Rigid3]:
        """Returns the best places along the pose's weakest direction, which climbs with the street."""
        N, _ = self.normal(pose, 0.2, pose.t)
        climb = -N[2, :2] / N[2, 2]
        flat = np.linalg.eigh(N[:2, :2] + np.outer(N[:2, 2], climb))[1][:, 0]
        weak = np.append(flat, climb @ flat)
        reach = 3.0 * float(self.sigma[:2].max()) + float(
            np.abs(pose.apply(self.pivot[None]) - self.pivot).max()
        )
        steps = np.arange(-int(reach / _SLIDE_M), int(reach / _SLIDE_M) + 1) * _SLIDE_M
        poses = [Rigid3(pose.to, pose.frm, pose.R, pose.t + s * weak) for s in steps]
        rating = np.array([self.rated(p)[0] for p in poses])
        top = np.flatnonzero(rating == ndimage.maximum_filter1d(rating, 3))
        return [poses[k] for k in top[np.argsort(-rating[top], kind="stable")][: 2 * _PEAKS]]


def _height(source: Surfels, target: Surfels) -> float:
    """Returns the median height difference (m) of ground that both saw, in 2 m cells; 0 without any."""
    cells = []
    for s in (source, target):
        g = s.take(s.level)
        key = np.floor(g.xyz[:, :2] / 2.0).astype(np.int64)
        key, number = np.unique(key, axis=0, return_inverse=True)
        low = np.full(len(key), np.inf)
        np.minimum.at(low, number.ravel(), g.xyz[:, 2])
        cells.append(dict(zip(map(tuple, key.tolist()), low.tolist(), strict=True)))
    both = [cells[1][k] - z for k, z in cells[0].items() if k in cells[1]]
    return float(np.median(both)) if both else 0.0


def neighbours(source: Surfels, target: Surfels, tree: cKDTree, within: float) -> tuple[Int, Int]:
    """Finds the surfels of two scans that lie on the same surface.

    source  in the target's frame; `tree` over the target's centres
    within  m, largest distance between centres

    Returns rows of `source` (m,) and of `target` (m,).
    """
    distance, k = tree.query(source.xyz, distance_upper_bound=within)
    i = np.flatnonzero(np.isfinite(distance))
    k = np.asarray(k, np.int64)[i]
    cosine = np.einsum("ij,ij->i", source.normal[i], target.normal[k])
    oriented = source.oriented[i] & target.oriented[k]
    same = np.where(oriented, cosine, np.abs(cosine)) > TOLERANCES.parallel_cos
    return i[same], k[same]
