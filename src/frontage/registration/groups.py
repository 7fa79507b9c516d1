"""Groups of scans that are tied to one another, their common prior, and the surfels that they share."""

from collections.abc import Collection, Sequence

import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.registration.coarse import Peak
from frontage.registration.problem import Pairs
from frontage.registration.result import PosePrior
from frontage.registration.ties import motion_of_peak, neighbours, tie_scans
from frontage.solve.surfels import Surfels


def group_scans(pieces: Sequence[Surfels], priors: Sequence[PosePrior]) -> list[dict[int, Rigid3]]:
    """Groups scans by their ties; each has its motion into the given frame of the group's first scan.

    The ties with the most common area are taken first, until they form a spanning forest.
    """
    n = len(pieces)
    ties = [t for b in range(n) for a in range(b) if (t := tie_scans(pieces, priors, a, b)) is not None]
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
    """Names the frames of a motion "local" from "given"."""
    return Rigid3("local", "given", pose.R, pose.t)


def group_prior(members: dict[int, Rigid3], priors: Sequence[PosePrior]) -> tuple[Rigid3, PosePrior]:
    """Combines the GPS and compass readings of a group of tied scans into its motion and its prior.

    It is a weighted least-squares estimate of heading and shift. The position of the prior is where the
    middle of the group then lies.
    """
    rows = sorted(members)
    given = np.array([priors[s].position for s in rows])
    sigma = np.array([priors[s].sigma for s in rows])
    placed = np.array([members[s].apply(priors[s].position[None])[0] for s in rows])
    middle = placed.mean(0)
    turn, shift = 0.0, np.zeros(3)
    for _ in range(5):
        R = motion_of_peak(Peak(turn, (0.0, 0.0), 1.0), np.zeros(3)).R
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
    R = motion_of_peak(Peak(turn, (0.0, 0.0), 1.0), np.zeros(3)).R
    left = np.sqrt(np.diag(np.linalg.inv(normal)))
    pose = Rigid3("local", "given", R, middle + shift - R @ middle)
    level = float(np.mean(sigma[:, 3]) / np.sqrt(len(rows)))
    return pose, PosePrior(middle + shift, left[:3], float(left[3]), level)


def common_surfels(
    pieces: Sequence[Surfels],
    poses: Sequence[Rigid3],
    together: Sequence[Collection[int]],
    spread: float = 0.1,
) -> Pairs:
    """Pairs surfels of different scans of a group that lie on one surface.

    together  groups of scans, by their numbers
    spread    m, largest distance between two surfels along the normal
    """
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
