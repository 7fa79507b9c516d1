"""Place groups of scans on the model: the candidates of the coarse search are adjusted, the best stays."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.registration.adjust import GNC_STAGES, Adjustment, adjust
from frontage.registration.coarse import SPAN_SIGMAS, plan_of_surfels, plan_of_walls, search_motions
from frontage.registration.correspond import foot_heights
from frontage.registration.equations import rotation_vector
from frontage.registration.groups import group_prior, group_scans
from frontage.registration.options import RegistrationOptions
from frontage.registration.problem import Problem
from frontage.registration.result import Alternative, PosePrior
from frontage.registration.ties import motion_of_peak
from frontage.registration.walls import ModelWalls
from frontage.solve.surfels import Surfels, merge_surfels

_RIVAL = 0.9  # share of the best score above which another place is an alternative
_ANOTHER_PLACE = 16.8  # squared sigmas (99.9 % of 3 degrees of freedom) from which a place is another one
_ANOTHER_M = 0.5  # m, and
_ANOTHER_RAD = np.radians(1.0)  # rad between two alternatives
_MOST_SURFELS = 6000  # surfels that candidates are tried with
_PRIOR = 0.005  # share explained that one squared sigma of the prior is worth
_UNTIED = 0.95  # tied scans must explain this share of what single scans explain
_ON_MODEL_M = 0.3  # m, within which surfels lie on the model


@dataclass(frozen=True, eq=False)
class _PlacedGroup:
    """A group of scans on the model: poses by scan, share of the walls explained, other places."""

    poses: dict[int, Rigid3]
    explained: float
    alternatives: list[Alternative]


@dataclass(frozen=True, eq=False)
class _Task:
    """What is to be placed: surfels and priors of all scans, the model and the options."""

    pieces: Sequence[Surfels]
    walls: ModelWalls
    priors: Sequence[PosePrior]
    options: RegistrationOptions


def initial_poses(
    pieces: Sequence[Surfels], walls: ModelWalls, priors: Sequence[PosePrior], options: RegistrationOptions
) -> tuple[list[Rigid3], list[Alternative], list[list[int]]]:
    """Returns the initial pose of every scan, alternatives, and the groups of scans that are tied.

    A tie between scans can be wrong (twin houses). Where the model explains them clearly better one by one,
    they are not tied.
    """
    task = _Task(pieces, walls, priors, options)
    found: list[_PlacedGroup] = []
    for members in group_scans(pieces, priors):
        together = _place(members, task)
        if len(members) > 1:
            alone = [_place({s: Rigid3.identity("local", "given")}, task) for s in members]
            if together.explained < _UNTIED * float(np.mean([a.explained for a in alone])):
                found += alone
                continue
        found.append(together)
    start = {s: pose for g in found for s, pose in g.poses.items()}
    return (
        [start[s] for s in sorted(start)],
        [a for g in found for a in g.alternatives],
        [sorted(g.poses) for g in found],
    )


def _place(members: dict[int, Rigid3], task: _Task) -> _PlacedGroup:
    """Places a group of scans as one body on the model: the best of the coarse search's candidates."""
    first, prior = group_prior(members, task.priors)
    chain = {s: first.after(p) for s, p in members.items()}
    body = merge_surfels([task.pieces[s].moved(pose) for s, pose in chain.items()])
    sigma = (float(prior.sigma_position[:2].max()), prior.sigma_heading)
    peaks = search_motions(plan_of_surfels(body), plan_of_walls(task.walls), prior.position[:2], sigma)
    thin = body.take(np.arange(0, len(body), max(1, len(body) // _MOST_SURFELS)))
    problem = Problem([thin], task.walls, [prior], task.options)
    tried: list[tuple[float, Adjustment]] = []
    for peak in peaks:
        start = motion_of_peak(peak, prior.position)
        start = motion_of_peak(peak, prior.position, _lift(thin.moved(start), task.walls, prior))
        got = adjust(problem, [start], None, GNC_STAGES[1:])
        tried.append((explained_share(got, thin) - _PRIOR * got.prior_cost, got))
    if not tried:
        return _PlacedGroup(chain, 0.0, [])
    tried.sort(key=lambda t: -t[0])
    best = tried[0][1]
    poses = {s: best.poses[0].after(p) for s, p in chain.items()}
    alternatives = _alternatives(tried, prior, tuple(sorted(chain)))
    return _PlacedGroup(poses, explained_share(best, thin), alternatives)


def _lift(body: Surfels, walls: ModelWalls, prior: PosePrior) -> float:
    """Returns how far (m) to raise a body so that its ground lies at the feet of the model's buildings.

    The prior limits it.
    """
    z, _ = foot_heights(body.take(body.level), walls)
    seen = np.isfinite(z)
    if not seen.any():
        return 0.0
    limit = SPAN_SIGMAS * float(prior.sigma_position[2])
    return float(np.clip(np.median((walls.base - z)[seen]), -limit, limit))


def explained_share(a: Adjustment, pieces: Surfels) -> float:
    """Returns the share of the upright area that lies on the model, 0..1."""
    near = np.abs(a.residuals[0]) < _ON_MODEL_M
    m = a.matches[0].piece[near]
    return float(pieces.area[m[pieces.upright[m]]].sum() / max(pieces.area[pieces.upright].sum(), 1e-9))


def _alternatives(
    tried: Sequence[tuple[float, Adjustment]], prior: PosePrior, scans: tuple[int, ...]
) -> list[Alternative]:
    """Returns other places with nearly the best score, unless the best one's uncertainty covers them.

    tried  scores and adjustments, best first
    scans  numbers of the group's scans
    """
    out: list[Alternative] = []
    score, best = tried[0]
    about = best.poses[0].apply(prior.position[None])[0]
    seen = [best]
    C = best.covariance + np.diag([1e-4, 1e-4, 1e-2, 1e-6, 1e-6, 1e-6])
    for other, a in tried[1:]:
        offs = [_difference(a, b, prior) for b in seen]
        is_new = all(np.hypot(d[0], d[1]) > _ANOTHER_M or abs(d[5]) > _ANOTHER_RAD for d in offs)
        at = np.array([0, 1, 5])
        is_far = offs[0][at] @ np.linalg.solve(C[np.ix_(at, at)], offs[0][at]) > _ANOTHER_PLACE
        if other > _RIVAL * score and is_new and is_far:
            out.append(Alternative(offs[0][:3], float(offs[0][5]), other / score, about, scans))
            seen.append(a)
    return out


def _difference(a: Adjustment, b: Adjustment, prior: PosePrior) -> Float:
    """Returns shift (m) of the pivot and turn (rad), (6,), from b to a."""
    p = prior.position[None]
    shift = a.poses[0].apply(p)[0] - b.poses[0].apply(p)[0]
    return np.concatenate([shift, rotation_vector(a.poses[0].R @ b.poses[0].R.T)])
