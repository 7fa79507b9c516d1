"""Robust adjustment of poses and of the model's own errors (maximum a posteriori).

A piece i of scan s on patch j of building b, moved to y = T_s p, has the residual

    r_i = n_j . (y - q_j) - n_j . e_b - (c_j + a_j u_i + b_j h_i)

with the building's shift e_b, the patch's offset c_j, turn a_j and lean b_j as unknowns with priors of their own:
a million points on one wall can then say no more of a pose than the wall itself knows. Pairs (i, k) of pieces of two
scans add ``n_k . (T_s p_i - T_t p_k)``; GPS, compass and level add their priors. Loss: Geman-McClure with
graduated non-convexity, weights by area: one square metre of wall is one observation, since relief and roughness are
correlated over about that much. Levels are held until the last stages (4 degrees of freedom), then free.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from frontage.geometry.arrays import Float, Int
from frontage.geometry.rigid import Rigid3, skew
from frontage.registration.correspond import Matches, foot_heights, match
from frontage.registration.options import RegistrationOptions
from frontage.registration.result import PosePrior
from frontage.registration.surfels import Surfels
from frontage.registration.walls import Walls
from frontage.solve.robust import mad_sigma

INDEPENDENT = 1.0  # m2 of wall that count as one observation
FLOOR = 0.005  # m, least sigma of one observation
CEILING = 0.05  # m, largest: what scatters more is not the wall
_CORNER = 0.6  # sigma of a corner and of a patch, relative to that of the building
_HELD = 1e-5  # rad, sigma of levels that are held


@dataclass(frozen=True)
class Stage:
    """One step of the graduated adjustment: search distance and scale of the loss in m, levels free or held."""

    d_max: float
    scale: float
    free: bool
    steps: int


STAGES = (
    Stage(3.0, 1.0, False, 4),
    Stage(2.0, 0.6, False, 4),
    Stage(1.2, 0.36, False, 4),
    Stage(0.8, 0.22, False, 4),
    Stage(0.5, 0.13, True, 4),
    Stage(0.3, 0.0, True, 12),  # scale 0: three times the measured scatter
)


@dataclass(frozen=True, eq=False)
class Pairs:
    """Pieces of two scans on one surface: scans s, t (m,), pieces i, k (m,) into their surfels, area (m,) m2."""

    s: Int
    t: Int
    i: Int
    k: Int
    area: Float


@dataclass(frozen=True, eq=False)
class Adjusted:
    """Poses, covariance (6 s, 6 s) about the instruments, the model's errors and what the residuals say.

    effects    (b + j, 3): building shifts, then (offset, turn, lean) of patches; `sigma_offset` (j,) m of a
               patch's whole offset at its foot's middle
    matches    last matches per scan, with the residual about the corrected patch and its robust weight
    """

    poses: tuple[Rigid3, ...]
    covariance: Float
    effects: Float
    effect_covariance: Float
    matches: tuple[Matches, ...]
    residuals: tuple[Float, ...]
    weights: tuple[Float, ...]
    sigma: float
    reason: str
    prior_cost: float


@dataclass(frozen=True, eq=False)
class Problem:
    """What stays the same during an adjustment: pieces as given, per scan, model, priors, pairs."""

    pieces: Sequence[Surfels]
    walls: Walls
    priors: Sequence[PosePrior]
    options: RegistrationOptions

    @property
    def effect_sigma(self) -> Float:
        """Prior sigmas (b + j, 3) of the model's errors."""
        o = self.options
        plan, height = max(o.sigma_model, 1e-4), max(o.sigma_height, 1e-4)
        buildings = np.tile([plan, plan, height], (len(self.walls.names), 1))
        patches = [
            (
                [
                    _CORNER * plan / 1.4,
                    _CORNER * plan * 1.4 / max(p.length, 1.0),
                    np.radians(o.sigma_lean) + 1e-5,
                ]
                if p.kind == "wall"
                else [
                    0.3 * height,
                    0.3 * height / max(p.length, 1.0),
                    np.radians(1.0) * min(1, height / 0.15),
                ]
            )
            for p in self.walls.patches
        ]
        return np.vstack([buildings, np.array(patches).reshape(-1, 3)])


def adjust(
    problem: Problem,
    start: Sequence[Rigid3],
    pairs: Pairs | None = None,
    stages: Sequence[Stage] = STAGES,
) -> Adjusted:
    """Poses from `start` through all `stages`; the last one iterates until the pose rests."""
    poses = list(start)
    effects = np.zeros((len(problem.walls.names) + len(problem.walls.patches), 3))
    sigma = CEILING
    reason = "no stage"
    state: _State | None = None
    for stage in stages:
        for step in range(stage.steps):
            if step % 4 == 0 or stage.scale == 0:
                matches = _match(problem, poses, stage)
            scale = stage.scale or 3.0 * sigma
            state = _linearise(problem, poses, effects, matches, pairs, scale, stage)
            shift = state.solve()
            poses = [
                moved(p, q.position, shift[6 * s : 6 * s + 6])
                for s, (p, q) in enumerate(zip(poses, problem.priors, strict=True))
            ]
            effects = effects + shift[6 * len(poses) :].reshape(-1, 3)
            sigma = float(np.clip(_scatter(state, scale), FLOOR, CEILING)) if stage.scale < 0.5 else CEILING
            step_size = np.abs(shift[: 6 * len(poses)].reshape(-1, 6)).max(0)
            reason = f"{step + 1} steps in the last stage"
            if step_size[:3].max() < 1e-4 and step_size[3:].max() < 1e-5:
                reason = "the poses moved less than 0.1 mm and 0.01 mrad"
                break
    if state is None:
        raise ValueError("an adjustment needs at least one stage")
    last = replace(stages[-1], free=True)
    state = _linearise(problem, poses, effects, matches, pairs, stages[-1].scale or 3.0 * sigma, last)
    inverse = np.linalg.inv(state.normal)
    k = 6 * len(poses)
    return Adjusted(
        tuple(poses),
        inverse[:k, :k],
        effects,
        inverse[k:, k:],
        tuple(matches),
        tuple(state.r),
        tuple(state.w),
        sigma,
        reason,
        state.prior_cost,
    )


def moved(pose: Rigid3, pivot: Float, step: Float) -> Rigid3:
    """The pose turned about where it puts `pivot` (3,), and shifted: step (6,)."""
    angle = float(np.linalg.norm(step[3:]))
    K = skew(step[3:] / angle) if angle > 0 else np.zeros((3, 3))
    turn = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * (K @ K)
    here = pose.R @ pivot + pose.t
    R = turn @ pose.R
    u, _, vt = np.linalg.svd(R)
    R = u @ vt
    return Rigid3(pose.to, pose.frm, R, here + step[:3] - R @ pivot)


def _match(problem: Problem, poses: Sequence[Rigid3], stage: Stage) -> list[Matches]:
    placed = (s.moved(p) for s, p in zip(problem.pieces, poses, strict=True))
    slack = 0.5 * stage.d_max if stage.d_max > 0.5 else 0.0
    turn = np.radians(10.0) if stage.d_max > 1.5 else 0.0
    return [match(m, problem.walls, stage.d_max, slack, turn, roofs=stage.d_max < 2.5) for m in placed]


def _scatter(state: "_State", scale: float) -> float:
    """Robust standard deviation of the residuals inside the loss, every piece alike."""
    r = np.concatenate(state.r)
    near = np.abs(r) < scale
    return mad_sigma(r[near]) if near.sum() > 10 else CEILING


@dataclass(frozen=True, eq=False)
class _State:
    normal: Float
    gradient: Float
    r: list[Float]
    w: list[Float]
    prior_cost: float

    def solve(self) -> Float:
        """The step of all unknowns."""
        return np.asarray(np.linalg.solve(self.normal, -self.gradient))


def _linearise(
    problem: Problem,
    poses: Sequence[Rigid3],
    effects: Float,
    matches: Sequence[Matches],
    pairs: Pairs | None,
    scale: float,
    stage: Stage,
) -> _State:
    """Normal equations of all unknowns: 6 per scan, 3 per building, 3 per patch."""
    stations = len(poses)
    n = 6 * stations + effects.size
    sigma = max(scale / 3.0, FLOOR)
    normal, gradient = np.zeros((n, n)), np.zeros(n)
    rs, ws = [], []
    share = _share(problem, matches)
    for s, (pose, m) in enumerate(zip(poses, matches, strict=True)):
        rows, r = _wall_rows(problem, pose, s, stations, effects, m)
        w = (scale**2 / (scale**2 + r * r)) ** 2
        weight = w * share[m.patch] * problem.pieces[s].area[m.piece] / (INDEPENDENT * sigma**2)
        normal += (rows.T.multiply(weight) @ rows).toarray()
        gradient += rows.T @ (weight * r)
        rs.append(r)
        ws.append(w)
    _add_ground(problem, poses, normal, gradient)
    if pairs is not None and len(pairs.s):
        _add_pairs(problem, poses, pairs, scale, normal, gradient)
    cost = _add_priors(problem, poses, effects, stage.free, normal, gradient)
    return _State(normal, gradient, rs, ws, cost)


def _share(problem: Problem, matches: Sequence[Matches]) -> Float:
    """What a piece counts by patch (j,): relief seen from several places is seen once."""
    areas: Float = np.array(
        [
            np.bincount(m.patch, problem.pieces[s].area[m.piece], len(problem.walls.patches))
            for s, m in enumerate(matches)
        ]
    )
    return np.asarray(areas.max(0) / np.maximum(areas.sum(0), 1e-9))


def _wall_rows(
    problem: Problem, pose: Rigid3, s: int, stations: int, effects: Float, m: Matches
) -> tuple[sparse.csr_array, Float]:
    """Jacobian (m, n) and residuals (m,) of pieces on patches, at this pose and these effects."""
    walls = problem.walls
    k, b = len(m), walls.building[m.patch]
    n = walls.normals[m.patch]
    y = pose.apply(problem.pieces[s].xyz[m.piece])
    here = pose.R @ problem.priors[s].position + pose.t
    point = np.array([p.point for p in walls.patches]).reshape(-1, 3)[m.patch]
    j = len(walls.names) + m.patch
    shape = np.column_stack([np.ones(k), m.u, m.h])
    r = np.einsum("ij,ij->i", n, y - point - effects[b]) - np.einsum("ij,ij->i", shape, effects[j])
    values = np.column_stack([n, np.cross(y - here, n), -n, -shape])
    base = 6 * stations
    columns = np.column_stack(
        [
            np.tile(6 * s + np.arange(6), (k, 1)),
            base + 3 * b[:, None] + np.arange(3),
            base + 3 * j[:, None] + np.arange(3),
        ]
    )
    start = np.arange(k + 1) * 12
    rows = sparse.csr_array((values.ravel(), columns.ravel(), start), shape=(k, base + effects.size))
    return rows, np.asarray(r)


def _add_ground(problem: Problem, poses: Sequence[Rigid3], normal: Float, gradient: Float) -> None:
    """Ground at the foot of a building lies on its base: as well as bases are known, and as ground is even."""
    placed = [s.moved(p) for s, p in zip(problem.pieces, poses, strict=True)]
    share = 1.0 / len(placed)  # one ground, however many scans see it
    for s, m in enumerate(placed):
        z, spread = foot_heights(m.take(m.level), problem.walls)
        seen = np.isfinite(z)
        variance = problem.options.sigma_height**2 + spread[seen] ** 2 + 0.05**2
        r = z[seen] - problem.walls.base[seen]
        w = share * (1.0 / variance) * (1.0 / (1.0 + r * r / (9 * variance))) ** 2
        normal[6 * s + 2, 6 * s + 2] += w.sum()
        gradient[6 * s + 2] += (w * r).sum()


def _add_pairs(
    problem: Problem, poses: Sequence[Rigid3], pairs: Pairs, scale: float, normal: Float, gradient: Float
) -> None:
    """Scan to scan: scalar distances along the other piece's normal."""
    scale = min(scale, 0.3)
    sigma = max(scale / 3.0, FLOOR)
    for s, t in np.unique(np.column_stack([pairs.s, pairs.t]), axis=0):
        rows = (pairs.s == s) & (pairs.t == t)
        i, k = pairs.i[rows], pairs.k[rows]
        y, q = poses[s].apply(problem.pieces[s].xyz[i]), poses[t].apply(problem.pieces[t].xyz[k])
        n = poses[t].rotate(problem.pieces[t].normal[k])
        r = np.einsum("ij,ij->i", n, y - q)
        here = [poses[x].R @ problem.priors[x].position + poses[x].t for x in (s, t)]
        A = np.column_stack([n, np.cross(y - here[0], n), -n, -np.cross(q - here[1], n)])
        w = (scale**2 / (scale**2 + r * r)) ** 2 * pairs.area[rows] / (INDEPENDENT * sigma**2)
        at = np.concatenate([6 * s + np.arange(6), 6 * t + np.arange(6)])
        normal[np.ix_(at, at)] += (A * w[:, None]).T @ A
        gradient[at] += A.T @ (w * r)


def _add_priors(
    problem: Problem, poses: Sequence[Rigid3], effects: Float, free: bool, normal: Float, gradient: Float
) -> float:
    """GPS, compass, level and the model's own errors; returns the squared sigmas of the poses."""
    cost = 0.0
    for s, (pose, prior) in enumerate(zip(poses, problem.priors, strict=True)):
        sigma = prior.sigma.copy()
        if not free:
            sigma[3:5] = _HELD
        off = np.concatenate([pose.R @ prior.position + pose.t - prior.position, rotation_vector(pose.R)])
        at = 6 * s + np.arange(6)
        normal[at, at] += 1 / sigma**2
        gradient[at] += off / sigma**2
        cost += float(np.square(off / prior.sigma).sum())
    information = (1.0 / problem.effect_sigma**2).ravel()
    at = 6 * len(poses) + np.arange(effects.size)
    normal[at, at] += information
    gradient[at] += information * effects.ravel()
    return cost


def rotation_vector(R: Float) -> Float:
    """Axis times angle (3,) rad of a rotation matrix (3, 3), angles below pi."""
    v = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine = float(np.linalg.norm(v))
    angle = float(np.arctan2(sine, 0.5 * (np.trace(R) - 1)))
    return np.asarray(v if sine < 1e-12 else v * (angle / sine))
