"""Groups of scans on the model: candidates of the coarse search are adjusted, the best stays."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.registration.adjust import STAGES, Adjusted, adjust
from frontage.registration.coarse import SPAN, plan_of_surfels, plan_of_walls, search
from frontage.registration.correspond import foot_heights
from frontage.registration.equations import Problem, rotation_vector
from frontage.registration.options import RegistrationOptions
from frontage.registration.result import Alternative, PosePrior
from frontage.registration.stations import group_prior, groups, motion
from frontage.registration.surfels import Surfels, merge_surfels
from frontage.registration.walls import Walls

_RIVAL = 0.9  # share of the best score above which another place is an alternative
_BEYOND = 16.8  # squared sigmas (99.9 % of 3 degrees of freedom) away before a place is another one
_MOST = 6000  # pieces that candidates are tried with
_PRIOR = 0.005  # of the explained share that one squared sigma of the prior is worth
_UNTIED = 0.95  # of what single scans explain, that tied ones must explain
_NEAR = 0.3  # m, pieces that lie on the model


@dataclass(frozen=True, eq=False)
class _Placed:
    """A group of scans on the model: poses by scan, share of the walls explained, other places."""

    poses: dict[int, Rigid3]
    score: float
    alternatives: list[Alternative]


def place(
    pieces: Sequence[Surfels], walls: Walls, priors: Sequence[PosePrior], options: RegistrationOptions
) -> tuple[list[Rigid3], list[Alternative], list[list[int]]]:
    """Start of every scan, alternatives, and which scans hang together.

    A tie between scans can be wrong (twin houses): where the model explains them clearly better one by one,
    they are not tied.
    """
    found: list[_Placed] = []
    for members in groups(pieces, priors):
        body = _body(members, pieces, walls, priors, options)
        if len(members) > 1:
            single = [{s: Rigid3.identity("local", "given")} for s in members]
            alone = [_body(one, pieces, walls, priors, options) for one in single]
            if body.score < _UNTIED * float(np.mean([a.score for a in alone])):
                found += alone
                continue
        found.append(body)
    start = {s: pose for g in found for s, pose in g.poses.items()}
    return (
        [start[s] for s in sorted(start)],
        [a for g in found for a in g.alternatives],
        [sorted(g.poses) for g in found],
    )


def _body(
    members: dict[int, Rigid3],
    pieces: Sequence[Surfels],
    walls: Walls,
    priors: Sequence[PosePrior],
    options: RegistrationOptions,
) -> _Placed:
    """Poses of a group of scans as one body on the model: the best of the coarse search's candidates."""
    first, prior = group_prior(members, priors)
    chain = {s: first.after(p) for s, p in members.items()}
    body = merge_surfels([pieces[s].moved(pose) for s, pose in chain.items()])
    sigma = (float(prior.sigma_position[:2].max()), prior.sigma_heading)
    peaks = search(plan_of_surfels(body), plan_of_walls(walls), prior.position[:2], sigma)
    thin = body.take(np.arange(0, len(body), max(1, len(body) // _MOST)))
    problem = Problem([thin], walls, [prior], options)
    tried: list[tuple[float, Adjusted]] = []
    for peak in peaks:
        start = motion(peak, prior.position)
        start = motion(peak, prior.position, _lift(thin.moved(start), walls, prior))
        got = adjust(problem, [start], None, STAGES[1:])
        tried.append((explained(got, thin) - _PRIOR * got.prior_cost, got))
    if not tried:
        return _Placed(chain, 0.0, [])
    tried.sort(key=lambda t: -t[0])
    score, best = tried[0]
    poses = {s: best.poses[0].after(p) for s, p in chain.items()}
    return _Placed(poses, explained(best, thin), _rivals(tried, prior, score, best, tuple(sorted(chain))))


def _lift(body: Surfels, walls: Walls, prior: PosePrior) -> float:
    """How far the body must be raised so that its ground lies at the feet of the model, within the prior."""
    z, _ = foot_heights(body.take(body.level), walls)
    seen = np.isfinite(z)
    if not seen.any():
        return 0.0
    limit = SPAN * float(prior.sigma_position[2])
    return float(np.clip(np.median((walls.base - z)[seen]), -limit, limit))


def explained(a: Adjusted, pieces: Surfels) -> float:
    """Share of the upright area that lies on the model."""
    near = np.abs(a.residuals[0]) < _NEAR
    m = a.matches[0].piece[near]
    return float(pieces.area[m[pieces.upright[m]]].sum() / max(pieces.area[pieces.upright].sum(), 1e-9))


def _rivals(
    tried: Sequence[tuple[float, Adjusted]],
    prior: PosePrior,
    score: float,
    best: Adjusted,
    scans: tuple[int, ...],
) -> list[Alternative]:
    """Other places with nearly the best score, that the best one's own uncertainty does not cover."""
    out: list[Alternative] = []
    about = best.poses[0].apply(prior.position[None])[0]
    seen = [best]
    C = best.covariance + np.diag([1e-4, 1e-4, 1e-2, 1e-6, 1e-6, 1e-6])
    for other, a in tried[1:]:
        offs = [_difference(a, b, prior) for b in seen]
        new = all(np.hypot(d[0], d[1]) > 0.5 or abs(d[5]) > np.radians(1.0) for d in offs)
        at = np.array([0, 1, 5])
        far = offs[0][at] @ np.linalg.solve(C[np.ix_(at, at)], offs[0][at]) > _BEYOND
        if other > _RIVAL * score and new and far:
            out.append(Alternative(offs[0][:3], float(offs[0][5]), other / score, about, scans))
            seen.append(a)
    return out


def _difference(a: Adjusted, b: Adjusted, prior: PosePrior) -> Float:
    """Shift of the pivot and turn (6,) from b to a."""
    p = prior.position[None]
    shift = a.poses[0].apply(p)[0] - b.poses[0].apply(p)[0]
    return np.concatenate([shift, rotation_vector(a.poses[0].R @ b.poses[0].R.T)])
