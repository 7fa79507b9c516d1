"""The graduated adjustment: correspondences, steps, covariance at the end (the model is in equations.py)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.registration.correspond import Matches, match
from frontage.registration.equations import CEILING, FLOOR, Pairs, Problem, State, linearise, moved
from frontage.solve.robust import mad_sigma


@dataclass(frozen=True)
class Stage:
    """One step of the graduated adjustment: search distance, scale of the loss in m, levels free or not."""

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


def adjust(
    problem: Problem,
    start: Sequence[Rigid3],
    pairs: Pairs | None = None,
    stages: Sequence[Stage] = STAGES,
) -> Adjusted:
    """Poses from `start` through all `stages`, each until the poses rest or its steps are used up."""
    errors = np.zeros((len(problem.walls.names) + len(problem.walls.patches), 3))
    now = _Now(list(start), errors, CEILING, [], None)
    reason = ""
    for stage in stages:
        reason = f"{stage.steps} steps in the last stage"
        for step in range(stage.steps):
            if step % 4 == 0 or stage.scale == 0:
                now.matches = _match(problem, now.poses, stage)
            if _step(problem, now, pairs, stage):
                reason = "the poses moved less than 0.1 mm and 0.01 mrad"
                break
    scale = stages[-1].scale or 3 * now.sigma
    last = linearise(problem, now.poses, now.effects, now.matches, pairs, scale, True, now.relief)
    inverse: Float = np.asarray(np.linalg.inv(last.normal), np.float64)
    k = 6 * len(now.poses)
    return Adjusted(
        tuple(now.poses),
        inverse[:k, :k],
        now.effects,
        inverse[k:, k:],
        tuple(now.matches),
        tuple(last.r),
        tuple(last.w),
        now.sigma,
        reason,
        last.prior_cost,
    )


@dataclass
class _Now:
    """Where an adjustment stands: poses, the model's errors, scatter of the residuals (m), matches, and the
    relief (j, 3) of the patches (None until the last stage)."""

    poses: list[Rigid3]
    effects: Float
    sigma: float
    matches: list[Matches]
    relief: Float | None


def _step(problem: Problem, now: _Now, pairs: Pairs | None, stage: Stage) -> bool:
    """One step of all unknowns; whether the poses rest."""
    scale = stage.scale or 3.0 * now.sigma
    state = linearise(problem, now.poses, now.effects, now.matches, pairs, scale, stage.free, now.relief)
    shift = state.solve()
    k = 6 * len(now.poses)
    own = shift[:k].reshape(-1, 6)
    now.poses = [moved(p, q.position, d) for p, q, d in zip(now.poses, problem.priors, own, strict=True)]
    now.effects = now.effects + shift[k:].reshape(-1, 3)
    now.sigma = float(np.clip(_scatter(state, scale), FLOOR, CEILING)) if stage.scale < 0.5 else CEILING
    if stage.scale == 0:
        now.relief = _relief(problem, now.matches, state.r)
    return bool(np.abs(own[:, :3]).max() < 1e-4 and np.abs(own[:, 3:]).max() < 1e-5)


def _match(problem: Problem, poses: Sequence[Rigid3], stage: Stage) -> list[Matches]:
    placed = (s.moved(p) for s, p in zip(problem.pieces, poses, strict=True))
    slack = 0.5 * stage.d_max if stage.d_max > 0.5 else 0.0
    turn = np.radians(10.0) if stage.d_max > 1.5 else 0.0
    return [match(m, problem.walls, stage.d_max, slack, turn, roofs=stage.d_max < 2.5) for m in placed]


def _scatter(state: State, scale: float) -> float:
    """Robust standard deviation of the residuals inside the loss, every piece alike."""
    r = np.concatenate(state.r)
    near = np.abs(r) < scale
    return mad_sigma(r[near]) if near.sum() > 10 else CEILING


def _relief(problem: Problem, matches: Sequence[Matches], r: Sequence[Float]) -> Float:
    """How far offset (m), turn and lean (rad) of every patch (j, 3) may be off because it is no plane.

    Ornament and layers stand before the plane that the model means, walls bulge, and half is hidden: half the
    robust spread of the residuals at either end, as for errors of the model's corners.
    """
    patch = np.concatenate([m.patch for m in matches])
    order = np.argsort(patch, kind="stable")
    count = np.bincount(patch, minlength=len(problem.walls.patches))
    parts = np.split(np.concatenate(list(r))[order], np.cumsum(count)[:-1])
    half = 0.5 * np.array([mad_sigma(part) if len(part) > 3 else 0.0 for part in parts])
    bounds = np.array([p.polygon.bounds for p in problem.walls.patches]).reshape(-1, 4)
    size = np.maximum(bounds[:, 2:] - bounds[:, :2], 1.0)
    return np.column_stack([half, 2.0 * half / size[:, 0], 2.0 * half / size[:, 1]])
