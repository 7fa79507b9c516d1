"""Scans to one another: the same coarse search, then point to plane; and the groups that hang together.

Neighbours are found by a KD-tree over flat pieces; residual and normal equations are scalar distances along the
piece's normal. (small_gicp 1.0.1 is of no use here: its point-to-plane Hessian is wrong on walls oblique to the axes.)
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.registration.adjust import Pairs, moved
from frontage.registration.coarse import Peak, plan_of_surfels, search
from frontage.registration.result import PosePrior
from frontage.registration.surfels import Surfels

_SEARCH = (2.0, 1.0, 0.5, 0.3, 0.2, 0.2)  # m, neighbours of the stages
_STEPS = 4
_TURN = np.cos(np.radians(15.0))
_LEAST = 15.0  # m2 of common upright surface that ties two scans
_CLOSE = 0.04  # m, pieces on one surface
_PEAKS = 6
_MOST = 6000  # pieces that a stage looks at


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
    return Rigid3("local", "given", R, pivot + [*peak.shift, height] - R @ pivot)


def tie(pieces: Sequence[Surfels], priors: Sequence[PosePrior], a: int, b: int) -> Tie | None:
    """Scan b onto scan a, or None where they have too little in common."""
    sigma = np.hypot(priors[a].sigma, priors[b].sigma)
    target, source = pieces[a], pieces[b]
    plan = (plan_of_surfels(source), plan_of_surfels(target))
    pivot = priors[b].position
    peaks = search(*plan, pivot[:2], (float(sigma[:2].max()), float(sigma[5])), _PEAKS)
    tree = cKDTree(target.xyz)
    best: tuple[float, Rigid3] | None = None
    for peak in peaks:
        start = motion(peak, pivot)
        start = motion(peak, pivot, _height(source.moved(start), target))
        pose = _refine(source, target, tree, start, pivot, sigma)
        area = _common(source, target, tree, pose)
        if best is None or area > best[0]:
            best = (area, pose)
    if best is None or best[0] < _LEAST:
        return None
    return Tie(a, b, best[1], best[0])


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
    k = k[i]
    cosine = np.einsum("ij,ij->i", source.normal[i], target.normal[k])
    oriented = source.oriented[i] & target.oriented[k]
    same = np.where(oriented, cosine, np.abs(cosine)) > _TURN
    return i[same], k[same].astype(np.int64)


def _refine(
    source: Surfels, target: Surfels, tree: cKDTree, pose: Rigid3, pivot: Float, sigma: Float
) -> Rigid3:
    """Point to plane with a shrinking search distance; GPS and level differences as priors."""
    thin = source.take(np.arange(0, len(source), max(1, len(source) // _MOST)))
    start = pose.R @ pivot + pose.t
    for within in _SEARCH:
        for _ in range(_STEPS):
            now = thin.moved(pose)
            i, k = neighbours(now, target, tree, max(within, 0.25))
            n = target.normal[k]
            r = np.einsum("ij,ij->i", n, now.xyz[i] - target.xyz[k])
            here = pose.R @ pivot + pose.t
            A = np.column_stack([n, np.cross(now.xyz[i] - here, n)])
            scale = within / 3
            w = (scale**2 / (scale**2 + r * r)) ** 2 * np.minimum(thin.area[i], 0.1) / scale**2
            off = np.concatenate([0.1 * (here - start), np.zeros(3)])
            normal = (A * w[:, None]).T @ A + np.diag(1 / sigma**2)
            step = np.linalg.solve(normal, -(A.T @ (w * r) + off / sigma**2))
            pose = moved(pose, pivot, step)
            if np.abs(step).max() < 1e-4:
                break
    return pose


def _common(source: Surfels, target: Surfels, tree: cKDTree, pose: Rigid3) -> float:
    """Upright area (m2) of the source that lies on the target."""
    now = source.take(source.upright).moved(pose)
    i, k = neighbours(now, target, tree, 0.25)
    r = np.einsum("ij,ij->i", target.normal[k], now.xyz[i] - target.xyz[k])
    return float(now.area[i[np.abs(r) < _CLOSE]].sum())


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
        link = _chain(_chain(one[t.a], t.a_from_b), _renamed(two[t.b].inverse))
        for s, pose in two.items():
            one[s] = _chain(link, pose)
            group[s] = one
    unique: list[dict[int, Rigid3]] = []
    for s in range(n):
        if not any(group[s] is g for g in unique):
            unique.append(group[s])
    return unique


def _chain(a: Rigid3, b: Rigid3) -> Rigid3:
    """First b, then a: both correct coordinates in one frame."""
    return Rigid3(a.to, b.frm, a.R @ b.R, a.R @ b.t + a.t)


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
    pieces: Sequence[Surfels], poses: Sequence[Rigid3], within: float = 0.25, spread: float = 0.1
) -> Pairs:
    """Pieces of different scans on one surface, `spread` m apart along the normal at most."""
    now = [s.moved(p) for s, p in zip(pieces, poses, strict=True)]
    parts: list[tuple[Int, ...]] = []
    area: list[Float] = [np.zeros(0)]
    for t, target in enumerate(now):
        tree = cKDTree(target.xyz)
        for s in range(t + 1, len(now)):
            i, k = neighbours(now[s], target, tree, within)
            r = np.einsum("ij,ij->i", target.normal[k], now[s].xyz[i] - target.xyz[k])
            i, k = i[np.abs(r) < spread], k[np.abs(r) < spread]
            parts.append((np.full(len(i), s), np.full(len(i), t), i, k))
            area.append(np.minimum(now[s].area[i], target.area[k]))
    if not parts:
        none = np.zeros(0, np.int64)
        return Pairs(none, none, none, none, np.zeros(0))
    s_, t_, i_, k_ = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Pairs(s_, t_, i_, k_, np.concatenate(area))
