"""The graduated adjustment of poses: correspondences, steps and covariance (the model is in `equations`)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.registration.correspond import Matches, match_surfels
from frontage.registration.equations import (
    LEAST_SIGMA_M,
    MOST_SIGMA_M,
    NormalEquations,
    apply_step,
    linearise,
)
from frontage.registration.problem import Pairs, Problem
from frontage.solve.robust import mad_sigma

_REST_M = 1e-4  # m, step of the poses below which they rest
_REST_RAD = 1e-5  # rad
_WIDE_TURN_RAD = np.radians(10.0)  # rad, by which headings may still be off in the first stages


@dataclass(frozen=True)
class GncStage:
    """One stage of the graduated adjustment (graduated non-convexity).

    d_max        m, search distance of the correspondences
    scale        m, of the robust loss; 0 stands for three times the measured scatter
    free_levels  whether the tilts of the scans are estimated
    steps        largest number of steps
    """

    d_max: float
    scale: float
    free_levels: bool
    steps: int


GNC_STAGES = (
    GncStage(3.0, 1.0, False, 4),
    GncStage(2.0, 0.6, False, 4),
    GncStage(1.2, 0.36, False, 4),
    GncStage(0.8, 0.22, False, 4),
    GncStage(0.5, 0.13, True, 4),
    GncStage(0.3, 0.0, True, 12),
)


@dataclass(frozen=True, eq=False)
class Adjustment:
    """The result of an adjustment of s scans.

    poses             local from given coordinates, per scan
    covariance        (6 s, 6 s) of the poses about their instruments, m and rad
    model_errors      (b + j, 3): shifts of the buildings (m), then offset (m), turn and lean (rad) of patches
    model_covariance  (3 (b + j), 3 (b + j)) of them
    matches           last matches per scan
    residuals         (m,) m per scan, about the corrected patches; `weights` (m,) of the robust loss
    sigma             m, robust standard deviation of the residuals
    reason            why the adjustment stopped
    prior_cost        squared sigmas by which the poses are off their priors
    """

    poses: tuple[Rigid3, ...]
    covariance: Float
    model_errors: Float
    model_covariance: Float
    matches: tuple[Matches, ...]
    residuals: tuple[Float, ...]
    weights: tuple[Float, ...]
    sigma: float
    reason: str
    prior_cost: float


def adjust(
    problem: Problem,
    start: Sequence[Rigid3],
    pairs: Pairs | None = None,
    stages: Sequence[GncStage] = GNC_STAGES,
) -> Adjustment:
    """Adjusts the poses from `start` through all stages, each until they rest or its steps are used up."""
    errors = np.zeros((len(problem.walls.names) + len(problem.walls.patches), 3))
    now = _Iterate(list(start), errors, MOST_SIGMA_M, [], None)
    reason = ""
    for stage in stages:
        reason = f"{stage.steps} steps in the last stage"
        for step in range(stage.steps):
            if step % 4 == 0 or stage.scale == 0:
                now.matches = _match(problem, now.poses, stage)
            if _step(problem, now, pairs, stage):
                reason = "the poses moved less than 0.1 mm and 0.01 mrad"
                break
    last = _linearised(problem, now, pairs, stages[-1].scale or 3 * now.sigma, free_levels=True)
    inverse: Float = np.asarray(np.linalg.inv(last.normal), np.float64)
    k = 6 * len(now.poses)
    return Adjustment(
        tuple(now.poses),
        inverse[:k, :k],
        now.model_errors,
        inverse[k:, k:],
        tuple(now.matches),
        tuple(last.r),
        tuple(last.w),
        now.sigma,
        reason,
        last.prior_cost,
    )


@dataclass
class _Iterate:
    """The state of an adjustment.

    sigma   m, robust standard deviation of the residuals
    relief  (j, 3) of the patches; None until the last stage
    """

    poses: list[Rigid3]
    model_errors: Float
    sigma: float
    matches: list[Matches]
    relief: Float | None


def _linearised(
    problem: Problem, now: _Iterate, pairs: Pairs | None, scale: float, free_levels: bool
) -> NormalEquations:
    """Builds the normal equations at an iterate; `scale` m is that of the robust loss."""
    return linearise(
        problem,
        now.poses,
        now.model_errors,
        now.matches,
        pairs,
        scale=scale,
        free_levels=free_levels,
        relief=now.relief,
    )


def _step(problem: Problem, now: _Iterate, pairs: Pairs | None, stage: GncStage) -> bool:
    """Takes one step of all unknowns; returns whether the poses rest."""
    scale = stage.scale or 3.0 * now.sigma
    equations = _linearised(problem, now, pairs, scale, stage.free_levels)
    shift = equations.solve()
    k = 6 * len(now.poses)
    own = shift[:k].reshape(-1, 6)
    now.poses = [apply_step(p, q.position, d) for p, q, d in zip(now.poses, problem.priors, own, strict=True)]
    now.model_errors = now.model_errors + shift[k:].reshape(-1, 3)
    scatter = float(np.clip(_scatter(equations, scale), LEAST_SIGMA_M, MOST_SIGMA_M))
    now.sigma = scatter if stage.scale < 0.5 else MOST_SIGMA_M
    if stage.scale == 0:
        now.relief = _relief(problem, now.matches, equations.r)
    return bool(np.abs(own[:, :3]).max() < _REST_M and np.abs(own[:, 3:]).max() < _REST_RAD)


def _match(problem: Problem, poses: Sequence[Rigid3], stage: GncStage) -> list[Matches]:
    """Matches the surfels of every scan with the model, more loosely in the first stages."""
    placed = (s.moved(p) for s, p in zip(problem.pieces, poses, strict=True))
    slack = 0.5 * stage.d_max if stage.d_max > 0.5 else 0.0
    turn = _WIDE_TURN_RAD if stage.d_max > 1.5 else 0.0
    return [
        match_surfels(m, problem.walls, stage.d_max, slack=slack, turn=turn, roofs=stage.d_max < 2.5)
        for m in placed
    ]


def _scatter(equations: NormalEquations, scale: float) -> float:
    """Robust standard deviation (m) of the residuals within the loss; every surfel counts the same."""
    r = np.concatenate(equations.r)
    near = np.abs(r) < scale
    return mad_sigma(r[near]) if near.sum() > 10 else MOST_SIGMA_M


def _relief(problem: Problem, matches: Sequence[Matches], r: Sequence[Float]) -> Float:
    """Estimates how far offset (m), turn and lean (rad) of every patch (j, 3) are off because it is no plane.

    Ornament and layers stand before the plane that the model means, walls bulge, and half is hidden. Assumed
    is half the robust spread of the residuals at either end, as for errors of the model's corners.
    """
    patch = np.concatenate([m.patch for m in matches])
    order = np.argsort(patch, kind="stable")
    count = np.bincount(patch, minlength=len(problem.walls.patches))
    parts = np.split(np.concatenate(list(r))[order], np.cumsum(count)[:-1])
    half = 0.5 * np.array([mad_sigma(part) if len(part) > 3 else 0.0 for part in parts])
    bounds = np.array([p.polygon.bounds for p in problem.walls.patches]).reshape(-1, 4)
    size = np.maximum(bounds[:, 2:] - bounds[:, :2], 1.0)
    return np.column_stack([half, 2.0 * half / size[:, 0], 2.0 * half / size[:, 1]])
