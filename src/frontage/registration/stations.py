"""Scans to one another: the same coarse search, then point to plane; and the groups that hang together.

Neighbours are found by a KD-tree over flat pieces; residual and normal equations are distances along a
piece's normal (not small_gicp 1.0.1: its point-to-plane Hessian is wrong on walls oblique to the axes).
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.model.masonry import TOLERANCES
from frontage.registration.coarse import Peak, plan_of_surfels, search
from frontage.registration.equations import Pairs, moved
from frontage.registration.result import PosePrior
from frontage.registration.surfels import Surfels

_WIDE = (2.0, 1.0, 0.5, 0.3)  # m, search distances from the coarse search on
_CLOSE = (0.4, 0.2, 0.2)  # and once a place along the street is found
_STEPS = 3
_LEAST = 15.0  # m2 of common upright surface that ties two scans
_SOFT = 0.05  # m, distance at which common surface counts a quarter
_SLIDE = 0.2  # m between the places that are tried along the street
_RIVAL = 0.9  # of the best common area: another place as good as that unties the scans
_PEAKS = 4
_MOST = 4000  # pieces that a stage looks at


@dataclass(frozen=True, eq=False)
class Tie:
    """Scan `b` onto scan `a`: `a_from_b` (coordinates as given), common upright area in m2."""

    a: int
    b: int
    a_from_b: Rigid3
    area: float


def motion(peak: Peak, pivot: Float, height: float = 0.0) -> Rigid3:
    """The rigid motion of a peak about `pivot` (3,), raised by `height` m."""
    c, s = np.cos(peak.turn), np.sin(peak.turn)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return Rigid3("local", "given", R, pivot + np.array([*peak.shift, height]) - R @ pivot)


def tie(pieces: Sequence[Surfels], priors: Sequence[PosePrior], a: int, b: int) -> Tie | None:
    """Scan b onto scan a, or None where they have too little in common, or as much at another place.

    Fronts let a street slide along itself: from the best peak on, the weakest direction is searched in small
    steps. There setbacks, reveals, cars and posts tell the right place, whose common area stands out.
    """
    sigma: Float = np.sqrt(priors[a].sigma ** 2 + priors[b].sigma ** 2)
    pair = _Pair(_thin(pieces[b]), pieces[a], cKDTree(pieces[a].xyz), priors[b].position, sigma)
    plan = (plan_of_surfels(pieces[b]), plan_of_surfels(pieces[a]))
    reach = (float(sigma[:2].max()), float(sigma[5]))
    found = [
        pair.rated(pair.refine(pair.raised(p), _WIDE)) for p in search(*plan, pair.pivot[:2], reach, _PEAKS)
    ]
    if not found:
        return None
    _, first = max(found, key=lambda t: t[0])
    found += [pair.rated(pair.refine(pose, _CLOSE)) for pose in pair.slid(first)]
    found.sort(key=lambda t: -t[0])
    score, best = found[0]
    here = best.apply(pair.pivot[None])
    far = [rival for rival, pose in found if np.linalg.norm(pose.apply(pair.pivot[None]) - here) > 0.3]
    if score < _LEAST or (far and max(far) > _RIVAL * score):
        return None
    return Tie(a, b, best, score)


def _thin(s: Surfels) -> Surfels:
    """Every k-th piece, its area k times as large."""
    k = max(1, len(s) // _MOST)
    t = s.take(np.arange(0, len(s), k))
    return Surfels(t.xyz, t.normal, t.oriented, t.area * k, t.thickness)


@dataclass(frozen=True, eq=False)
class _Pair:
    """Two scans to be tied: thinned pieces of one, all of the other, pivot and sigmas of the prior."""

    source: Surfels
    target: Surfels
    tree: cKDTree
    pivot: Float
    sigma: Float

    def raised(self, peak: Peak) -> Rigid3:
        """The motion of a peak of the plan, at the height where the ground of both meets."""
        flat = motion(peak, self.pivot)
        return motion(peak, self.pivot, _height(self.source.moved(flat), self.target))

    def refine(self, pose: Rigid3, stages: Sequence[float]) -> Rigid3:
        """Point to plane with a shrinking search distance; differences of levels as priors."""
        start = pose.apply(self.pivot[None])[0]
        for within in stages:
            for _ in range(_STEPS):
                normal, gradient = self.normal(pose, within, start)
                step: Float = np.asarray(np.linalg.solve(normal, -gradient), np.float64)
                pose = moved(pose, self.pivot, step)
                if np.abs(step).max() < 1e-4:
                    break
        return pose

    def normal(self, pose: Rigid3, within: float, start: Float) -> tuple[Float, Float]:
        """Normal equations (6, 6) and gradient (6,) of a step about the pivot."""
        now = self.source.moved(pose)
        i, k = neighbours(now, self.target, self.tree, max(within, 0.25))
        n = self.target.normal[k]
        r = np.einsum("ij,ij->i", n, now.xyz[i] - self.target.xyz[k])
        here = pose.apply(self.pivot[None])[0]
        A = np.column_stack([n, np.cross(now.xyz[i] - here, n)])
        scale = within / 3
        w = (scale**2 / (scale**2 + r * r)) ** 2 * np.minimum(now.area[i], 0.5) / scale**2
        off = np.concatenate([0.1 * (here - start), np.zeros(3)])
        return (A * w[:, None]).T @ A + np.diag(1 / self.sigma**2), A.T @ (w * r) + off / self.sigma**2

    def rated(self, pose: Rigid3) -> tuple[float, Rigid3]:
        """Common upright area (m2) of a pose, less what the prior holds against it."""
        off = (pose.apply(self.pivot[None])[0] - self.pivot)[:2] / self.sigma[:2]
        return self.common(pose) * float(np.exp(-0.01 * off @ off)), pose

    def common(self, pose: Rigid3) -> float:
        """Upright area (m2) of the source that lies on the target, soft at its borders."""
        now = self.source.take(self.source.upright).moved(pose)
        i, k = neighbours(now, self.target, self.tree, 0.25)
        r = np.einsum("ij,ij->i", self.target.normal[k], now.xyz[i] - self.target.xyz[k])
        return float(now.area[i] @ (_SOFT**2 / (_SOFT**2 + r * r)) ** 2)

    def slid(self, pose: Rigid3) -> list[Rigid3]:
        """The best places along the direction in which the pose is weakest, which climbs with the street."""
        N, _ = self.normal(pose, 0.2, pose.t)
        climb = -N[2, :2] / N[2, 2]
        flat = np.linalg.eigh(N[:2, :2] + np.outer(N[:2, 2], climb))[1][:, 0]
        weak = np.append(flat, climb @ flat)
        reach = 3.0 * float(self.sigma[:2].max()) + float(
            np.abs(pose.apply(self.pivot[None]) - self.pivot).max()
        )
        steps = np.arange(-int(reach / _SLIDE), int(reach / _SLIDE) + 1) * _SLIDE
        poses = [Rigid3(pose.to, pose.frm, pose.R, pose.t + s * weak) for s in steps]
        rating = np.array([self.rated(p)[0] for p in poses])
        top = np.flatnonzero(rating == ndimage.maximum_filter1d(rating, 3))
        return [poses[k] for k in top[np.argsort(-rating[top], kind="stable")][: 2 * _PEAKS]]


def _height(source: Surfels, target: Surfels) -> float:
    """Median difference in height of ground that both have seen, in 2 m cells; 0 where there is none."""
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
    """Rows of `source` (in the target's frame) and of the pieces of `target` on the same surface."""
    distance, k = tree.query(source.xyz, distance_upper_bound=within)
    i = np.flatnonzero(np.isfinite(distance))
    k = np.asarray(k, np.int64)[i]
    cosine = np.einsum("ij,ij->i", source.normal[i], target.normal[k])
    oriented = source.oriented[i] & target.oriented[k]
    same = np.where(oriented, cosine, np.abs(cosine)) > TOLERANCES.parallel_cos
    return i[same], k[same]


def groups(pieces: Sequence[Surfels], priors: Sequence[PosePrior]) -> list[dict[int, Rigid3]]:
    """Scans that hang together, each with its motion into the group's first scan's given frame.

    The ties with the most common area are taken first, one less than there are scans (a spanning forest).
    """
    n = len(pieces)
    ties = [t for b in range(n) for a in range(b) if (t := tie(pieces, priors, a, b)) is not None]
    group = {s: {s: Rigid3.identity("local", "given")} for s in range(n)}
    for t in sorted(ties, key=lambda t: -t.area):
        one, two = group[t.a], group[t.b]
        if one is two:
            continue
        link = one[t.a].after(t.a_from_b).after(_renamed(two[t.b].inverse))
        for s, pose in two.items():
            one[s] = link.after(pose)
            group[s] = one
    unique: list[dict[int, Rigid3]] = []
    for s in range(n):
        if not any(group[s] is g for g in unique):
            unique.append(group[s])
    return unique


def _renamed(pose: Rigid3) -> Rigid3:
    return Rigid3("local", "given", pose.R, pose.t)


def group_prior(members: dict[int, Rigid3], priors: Sequence[PosePrior]) -> tuple[Rigid3, PosePrior]:
    """What all GPS and compass readings say of a group as one body: its motion, and the sigmas that are left.

    Weighted least squares of heading and shift; the prior's position is where the group's middle then lies.
    """
    rows = sorted(members)
    given = np.array([priors[s].position for s in rows])
    sigma = np.array([priors[s].sigma for s in rows])
    placed = np.array([members[s].apply(priors[s].position[None])[0] for s in rows])
    middle = placed.mean(0)
    turn, shift = 0.0, np.zeros(3)
    for _ in range(5):
        R = motion(Peak(turn, (0.0, 0.0), 1.0), np.zeros(3)).R
        arm = (placed - middle) @ R.T
        A, r, w = [], [], []
        for k, s in enumerate(rows):
            A.append(np.column_stack([np.eye(3), np.cross([0.0, 0.0, 1.0], arm[k])]))
            r.append(middle + arm[k] + shift - given[k])
            w.append(1 / sigma[k, :3] ** 2)
            heading = np.arctan2(*(R @ members[s].R)[[1, 0], 0])
            A.append(np.array([[0.0, 0.0, 0.0, 1.0]]))
            r.append(np.array([heading]))
            w.append(1 / sigma[k, 5:] ** 2)
        a, residual, weight = np.vstack(A), np.concatenate(r), np.concatenate(w)
        normal = (a * weight[:, None]).T @ a
        step = np.linalg.solve(normal, -a.T @ (weight * residual))
        shift, turn = shift + step[:3], turn + float(step[3])
    R = motion(Peak(turn, (0.0, 0.0), 1.0), np.zeros(3)).R
    left = np.sqrt(np.diag(np.linalg.inv(normal)))
    pose = Rigid3("local", "given", R, middle + shift - R @ middle)
    level = float(np.mean(sigma[:, 3]) / np.sqrt(len(rows)))
    return pose, PosePrior(middle + shift, left[:3], float(left[3]), level)


def pairs(
    pieces: Sequence[Surfels],
    poses: Sequence[Rigid3],
    together: Sequence[Collection[int]],
    spread: float = 0.1,
) -> Pairs:
    """Pieces of different scans of a group on one surface, `spread` m apart along the normal at most."""
    group = {s: g for g, members in enumerate(together) for s in members}
    now = [s.moved(p) for s, p in zip(pieces, poses, strict=True)]
    parts: list[tuple[Int, ...]] = []
    area: list[Float] = [np.zeros(0)]
    for t, target in enumerate(now):
        tree = cKDTree(target.xyz)
        for s in (s for s in range(t + 1, len(now)) if group[s] == group[t]):
            i, k = neighbours(now[s], target, tree, 0.25)
            r = np.einsum("ij,ij->i", target.normal[k], now[s].xyz[i] - target.xyz[k])
            i, k = i[np.abs(r) < spread], k[np.abs(r) < spread]
            parts.append((np.full(len(i), s), np.full(len(i), t), i, k))
            area.append(np.minimum(now[s].area[i], target.area[k]))
    if not parts:
        none = np.zeros(0, np.int64)
        return Pairs(none, none, none, none, np.zeros(0))
    s_, t_, i_, k_ = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Pairs(s_, t_, i_, k_, np.concatenate(area))
