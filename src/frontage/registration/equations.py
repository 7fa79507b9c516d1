"""Normal equations of poses and of the model's own errors (maximum a posteriori).

A surfel i of scan s on patch j of building b, moved to y = T_s p, has the residual

    r_i = n_j . (y - q_j) - n_j . e_b - (c_j + a_j u_i + b_j h_i)

The building's shift e_b and the patch's offset c_j, turn a_j and lean b_j are unknowns with priors of their
own. A million points on one wall can then say no more of a pose than the wall itself knows. Pairs (i, k) of
surfels of two scans add ``n_k . (T_s p_i - T_t p_k)``; GPS, compass and level add their priors.

The loss is Geman-McClure with graduated non-convexity. Weights go by area: one square metre of wall is one
observation, because relief and roughness are correlated over about that much, and what several scans see of a
wall counts once. Levels are held until the last stages (4 degrees of freedom), then free.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3, skew
from frontage.registration.correspond import Matches, foot_heights
from frontage.registration.problem import Pairs, Problem

INDEPENDENT_M2 = 1.0  # m2 of wall that count as one observation
LEAST_SIGMA_M = 0.005  # m, of one observation
MOST_SIGMA_M = 0.05  # m, of one observation: rougher surfaces are no wall
_PAIR_SCALE_M = 0.3  # m, largest scale of the loss between scans
_UNEVEN_M = 0.05  # m, one sigma by which ground differs from a building's base
_HELD_RAD = 1e-5  # rad, sigma of levels that are held


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """Normal equations of all unknowns at one iterate.

    normal      (n, n); `gradient` (n,); n = 6 per scan, 3 per building, 3 per patch
    r, w        per scan, residuals (m,) m of its matches and their robust weights (m,)
    prior_cost  squared sigmas by which the poses are off their priors
    """

    normal: Float
    gradient: Float
    r: list[Float]
    w: list[Float]
    prior_cost: float

    def solve(self) -> Float:
        """Returns the step (n,) of all unknowns."""
        return np.asarray(np.linalg.solve(self.normal, -self.gradient))


@dataclass(frozen=True, eq=False)
class _System:
    """Normal matrix (n, n) and gradient (n,) to which terms are added in place."""

    normal: Float
    gradient: Float

    def add(self, at: Array, A: Float, w: Array, r: Array) -> None:
        """Adds rows A (m, k) with weights w (m,) and residuals r (m,) of the unknowns `at` (k,)."""
        self.normal[np.ix_(at, at)] += (A * w[:, None]).T @ A
        self.gradient[at] += A.T @ (w * r)


def geman_mcclure(r: Float, scale: float) -> Float:
    """Returns the weights (m,) of residuals r (m,) m under the Geman-McClure loss with `scale` m."""
    return np.asarray((scale**2 / (scale**2 + r * r)) ** 2)


def linearise(
    problem: Problem,
    poses: Sequence[Rigid3],
    model_errors: Float,
    matches: Sequence[Matches],
    pairs: Pairs | None,
    *,
    scale: float,
    free_levels: bool,
    relief: Float | None = None,
) -> NormalEquations:
    """Builds the normal equations of all unknowns: 6 per scan, 3 per building, 3 per patch.

    model_errors  (b + j, 3) of buildings and patches
    matches       of the surfels of every scan
    scale         m, of the robust loss
    free_levels   whether the tilts of the scans are estimated
    relief        (j, 3) by how much offset, turn and lean of a patch may be off because it is no plane
    """
    n = 6 * len(poses) + model_errors.size
    sigma = max(scale / 3.0, LEAST_SIGMA_M)
    system = _System(np.zeros((n, n)), np.zeros(n))
    rs, ws = [], []
    share = _share(problem, matches)
    for s, m in enumerate(matches):
        rows, r = _wall_rows(problem, poses, s, model_errors, m)
        w = geman_mcclure(r, scale)
        weight = w * share[m.patch] * problem.pieces[s].area[m.piece] / (INDEPENDENT_M2 * sigma**2)
        system.normal[...] += (rows.T.multiply(weight) @ rows).toarray()
        system.gradient[...] += rows.T @ (weight * r)
        rs.append(r)
        ws.append(w)
    _add_ground(system, problem, poses)
    if pairs is not None and len(pairs.s):
        _add_pairs(system, problem, poses, pairs, scale)
    _add_links(system, problem, poses)
    cost = _add_pose_priors(system, problem, poses, free_levels)
    _add_model_priors(system, problem, model_errors, relief)
    return NormalEquations(system.normal, system.gradient, rs, ws, cost)


def _share(problem: Problem, matches: Sequence[Matches]) -> Float:
    """Returns what an area counts on each patch (j,): relief that several scans see is seen once."""
    areas: Float = np.array(
        [
            np.bincount(m.patch, problem.pieces[s].area[m.piece], len(problem.walls.patches))
            for s, m in enumerate(matches)
        ]
    )
    return np.asarray(areas.max(0) / np.maximum(areas.sum(0), 1e-9))


def _wall_rows(
    problem: Problem, poses: Sequence[Rigid3], s: int, model_errors: Float, m: Matches
) -> tuple[sparse.csr_array, Float]:
    """Returns the Jacobian (m, n) and the residuals (m,) m of the surfels of scan s on their patches."""
    walls, pose = problem.walls, poses[s]
    k, b = len(m), walls.building[m.patch]
    n = walls.normals[m.patch]
    y = pose.apply(problem.pieces[s].xyz[m.piece])
    here = pose.R @ problem.priors[s].position + pose.t
    point = np.array([p.point for p in walls.patches]).reshape(-1, 3)[m.patch]
    j = len(walls.names) + m.patch
    shape = np.column_stack([np.ones(k), m.u, m.h])
    r = np.einsum("ij,ij->i", n, y - point - model_errors[b]) - np.einsum("ij,ij->i", shape, model_errors[j])
    values = np.column_stack([n, np.cross(y - here, n), -n, -shape])
    base = 6 * len(poses)
    columns = np.column_stack(
        [
            np.tile(6 * s + np.arange(6), (k, 1)),
            base + 3 * b[:, None] + np.arange(3),
            base + 3 * j[:, None] + np.arange(3),
        ]
    )
    start = np.arange(k + 1) * 12
    rows = sparse.csr_array((values.ravel(), columns.ravel(), start), shape=(k, base + model_errors.size))
    return rows, np.asarray(r)


def _add_ground(system: _System, problem: Problem, poses: Sequence[Rigid3]) -> None:
    """Adds that the ground at the foot of a building lies on its base.

    This holds as well as bases are known and the ground is even.
    """
    placed = [s.moved(p) for s, p in zip(problem.pieces, poses, strict=True)]
    share = 1.0 / len(placed)  # there is one ground, however many scans see it
    for s, m in enumerate(placed):
        z, spread = foot_heights(m.take(m.level), problem.walls)
        seen = np.isfinite(z)
        variance = problem.options.sigma_height**2 + spread[seen] ** 2 + _UNEVEN_M**2
        r = z[seen] - problem.walls.base[seen]
        w = share * (1.0 / variance) * (1.0 / (1.0 + r * r / (9 * variance))) ** 2
        system.normal[6 * s + 2, 6 * s + 2] += w.sum()
        system.gradient[6 * s + 2] += (w * r).sum()


def _add_pairs(
    system: _System, problem: Problem, poses: Sequence[Rigid3], pairs: Pairs, scale: float
) -> None:
    """Adds the distances between surfels of two scans, along the normal of the second."""
    scale = min(scale, _PAIR_SCALE_M)
    sigma = max(scale / 3.0, LEAST_SIGMA_M)
    for s, t in np.unique(np.column_stack([pairs.s, pairs.t]), axis=0):
        rows = (pairs.s == s) & (pairs.t == t)
        i, k = pairs.i[rows], pairs.k[rows]
        y, q = poses[s].apply(problem.pieces[s].xyz[i]), poses[t].apply(problem.pieces[t].xyz[k])
        n = poses[t].rotate(problem.pieces[t].normal[k])
        r = np.einsum("ij,ij->i", n, y - q)
        here = [poses[x].R @ problem.priors[x].position + poses[x].t for x in (s, t)]
        A = np.column_stack([n, np.cross(y - here[0], n), -n, -np.cross(q - here[1], n)])
        w = geman_mcclure(r, scale) * pairs.area[rows] / (INDEPENDENT_M2 * sigma**2)
        system.add(_unknowns(s, t), A, w, r)


def _add_links(system: _System, problem: Problem, poses: Sequence[Rigid3]) -> None:
    """Adds that neighbouring strips of a drive share one correction half way between, except for drift."""
    for link in problem.links:
        middle = 0.5 * (problem.priors[link.s].position + problem.priors[link.t].position)
        A = np.zeros((6, 12))
        off = np.zeros(6)
        for column, x, sign in ((0, link.s, 1.0), (6, link.t, -1.0)):
            here = poses[x].R @ problem.priors[x].position + poses[x].t
            there = poses[x].R @ middle + poses[x].t
            A[:, column : column + 6] = sign * np.eye(6)
            A[:3, column + 3 : column + 6] = -sign * skew(there - here)
            off += sign * np.concatenate([there, rotation_vector(poses[x].R)])
        w = 1.0 / link.sigma**2
        system.add(_unknowns(link.s, link.t), A, w, off)


def _unknowns(s: int, t: int) -> Array:
    """Returns the unknowns (12,) of the poses of two scans."""
    return np.concatenate([6 * s + np.arange(6), 6 * t + np.arange(6)])


def _add_pose_priors(system: _System, problem: Problem, poses: Sequence[Rigid3], free_levels: bool) -> float:
    """Adds GPS, compass and level; returns the squared sigmas by which the poses are off."""
    cost = 0.0
    for s, (pose, prior) in enumerate(zip(poses, problem.priors, strict=True)):
        sigma = prior.sigma.copy()
        if not free_levels:
            sigma[3:5] = _HELD_RAD
        off = np.concatenate([pose.R @ prior.position + pose.t - prior.position, rotation_vector(pose.R)])
        at = 6 * s + np.arange(6)
        system.normal[at, at] += 1 / sigma**2
        system.gradient[at] += off / sigma**2
        cost += float(np.square(off / prior.sigma).sum())
    return cost


def _add_model_priors(system: _System, problem: Problem, model_errors: Float, relief: Float | None) -> None:
    """Adds how well the model is known, and how far its patches are planes."""
    variance = problem.model_sigma**2
    if relief is not None:
        variance[len(problem.walls.names) :] += relief**2
    information = (1.0 / variance).ravel()
    at = len(system.gradient) - model_errors.size + np.arange(model_errors.size)
    system.normal[at, at] += information
    system.gradient[at] += information * model_errors.ravel()


def rotation_vector(R: Float) -> Float:
    """Returns axis times angle (3,) rad of a rotation matrix (3, 3), for angles below pi."""
    v = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine = float(np.linalg.norm(v))
    angle = float(np.arctan2(sine, 0.5 * (np.trace(R) - 1)))
    return np.asarray(v if sine < 1e-12 else v * (angle / sine))


def apply_step(pose: Rigid3, pivot: Float, step: Float) -> Rigid3:
    """Applies a step (6,) to a pose: a turn (rad) about where it puts `pivot` (3,) m, and a shift (m)."""
    angle = float(np.linalg.norm(step[3:]))
    K = skew(step[3:] / angle) if angle > 0 else np.zeros((3, 3))
    turn = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * (K @ K)
    here = pose.R @ pivot + pose.t
    R = turn @ pose.R
    u, _, vt = np.linalg.svd(R)
    R = u @ vt
    return Rigid3(pose.to, pose.frm, R, here + step[:3] - R @ pivot)
