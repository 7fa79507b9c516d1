"""Robust adjustment of poses and of the model's own errors (maximum a posteriori).

A piece i of scan s on patch j of building b, moved to y = T_s p, has the residual

    r_i = n_j . (y - q_j) - n_j . e_b - (c_j + a_j u_i + b_j h_i)

with the building's shift e_b, the patch's offset c_j, turn a_j and lean b_j as unknowns with priors of their
own: a million points on one wall can then say no more of a pose than the wall itself knows. Pairs (i, k) of
pieces of two scans add ``n_k . (T_s p_i - T_t p_k)``; GPS, compass and level add their priors. Loss:
Geman-McClure with graduated non-convexity, weights by area: one square metre of wall is one observation, for
relief and roughness are correlated over about that much; what several scans see of a wall counts once.
Levels are held until the last stages (4 degrees of freedom), then free.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from frontage.geometry.arrays import Float, Int
from frontage.geometry.rigid import Rigid3, skew
from frontage.registration.correspond import Matches, foot_heights
from frontage.registration.options import RegistrationOptions
from frontage.registration.result import PosePrior
from frontage.registration.surfels import Surfels
from frontage.registration.walls import Walls

INDEPENDENT = 1.0  # m2 of wall that count as one observation
FLOOR = 0.005  # m, least sigma of one observation
CEILING = 0.05  # m, largest: what scatters more is not the wall
_CORNER = 0.6  # sigma of a corner and of a patch, relative to that of the building
_ROOF = 0.3  # sigma of a roof, relative to that of the building's height
_ASLANT = 0.5  # squared cosine with one surface's normal from which on it determines a direction: 45 degrees
_CLOSE = 0.01 / 2.576  # m, sigma for which 99 % of errors are below a centimetre
_HELD = 1e-5  # rad, sigma of levels that are held


@dataclass(frozen=True, eq=False)
class Pairs:
    """Pieces of two scans on one surface: scans s, t (m,), pieces i, k (m,) of each, area (m,) m2."""

    s: Int
    t: Int
    i: Int
    k: Int
    area: Float


@dataclass(frozen=True, eq=False)
class Link:
    """Scans s and t are corrected alike, but for `sigma` (6,): m half way between them, and rad."""

    s: int
    t: int
    sigma: Float


@dataclass(frozen=True, eq=False)
class Problem:
    """What stays the same during an adjustment: pieces as given, per scan, model, priors, pairs."""

    pieces: Sequence[Surfels]
    walls: Walls
    priors: Sequence[PosePrior]
    options: RegistrationOptions
    links: tuple["Link", ...] = ()

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
                    _ROOF * height,
                    _ROOF * height / max(p.length, 1.0),
                    np.radians(1.0) * min(1, height / 0.15),
                ]
            )
            for p in self.walls.patches
        ]
        return np.vstack([buildings, np.array(patches).reshape(-1, 3)])

    @property
    def observable(self) -> Float:
        """Sigma (3,) m per axis up to which a shift is observable: what one surface of the model tells of a
        direction that it meets at 45 degrees; of an exact model, a centimetre with 99 % confidence.
        """
        o = self.options
        plan = o.sigma_model**2 * (1 + (_CORNER / 1.4) ** 2)
        height = o.sigma_height**2 * (1 + _ROOF**2)
        variance = np.array([plan, plan, height]) / _ASLANT + _CLOSE**2
        return np.asarray(np.minimum(np.sqrt(variance), o.observable))


@dataclass(frozen=True, eq=False)
class State:
    """Normal equations of all unknowns, residuals and weights per scan, squared sigmas of the priors."""

    normal: Float
    gradient: Float
    r: list[Float]
    w: list[Float]
    prior_cost: float

    def solve(self) -> Float:
        """The step of all unknowns."""
        return np.asarray(np.linalg.solve(self.normal, -self.gradient))


def linearise(
    problem: Problem,
    poses: Sequence[Rigid3],
    effects: Float,
    matches: Sequence[Matches],
    pairs: Pairs | None,
    scale: float,
    free: bool,
    relief: Float | None = None,
) -> State:
    """Normal equations of all unknowns: 6 per scan, 3 per building, 3 per patch.

    relief  (j, 3) by how much every patch is no plane: what its offset, turn and lean may be off by besides
    """
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
    _add_links(problem, poses, normal, gradient)
    cost = _add_priors(problem, poses, effects, free, normal, gradient, relief)
    return State(normal, gradient, rs, ws, cost)


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
    """Ground at the foot of a building lies on its base: as well as bases are known, as ground is even."""
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


def _add_links(problem: Problem, poses: Sequence[Rigid3], normal: Float, gradient: Float) -> None:
    """Neighbouring strips of one drive: the same correction half way between them, but for the drift."""
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
        at = np.concatenate([6 * link.s + np.arange(6), 6 * link.t + np.arange(6)])
        normal[np.ix_(at, at)] += (A.T * w) @ A
        gradient[at] += A.T @ (w * off)


def _add_priors(
    problem: Problem,
    poses: Sequence[Rigid3],
    effects: Float,
    free: bool,
    normal: Float,
    gradient: Float,
    relief: Float | None,
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
    variance = problem.effect_sigma**2
    if relief is not None:
        variance[len(problem.walls.names) :] += relief**2
    information = (1.0 / variance).ravel()
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
