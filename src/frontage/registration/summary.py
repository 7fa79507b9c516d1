"""Summarise an adjustment as a `Registration`: poses with covariance, wall offsets, agreement and notes."""

from collections.abc import Sequence

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import Estimate, Scan
from frontage.registration.adjust import Adjustment
from frontage.registration.correspond import match_surfels
from frontage.registration.observability import about_frame, alternatives_covariance, principal_directions
from frontage.registration.problem import Pairs, Problem
from frontage.registration.result import (
    Alternative,
    Direction,
    RegisteredScan,
    Registration,
    WallOffset,
)

_ON_MODEL_M = 0.3  # m, within which surfels lie on the model
_LEAST_AREA_M2 = 1.0  # m2 of a patch that must be seen to state its offset
_LEAST_EXPLAINED = 0.2  # share of the wall area on the model, below which a note says so
_MAD_TO_SIGMA = 1.4826  # standard deviation of a Gaussian over its median absolute deviation


def summarise(
    scans: Sequence[Scan],
    problem: Problem,
    a: Adjustment,
    common: Pairs,
    alternatives: Sequence[Alternative],
) -> Registration:
    """Builds the result of a registration from the last adjustment.

    common        pairs of surfels that several scans have in common
    alternatives  other places that explain the scans nearly as well
    """
    registered = tuple(_registered(scan, problem, a, k, alternatives) for k, scan in enumerate(scans))
    r = _distances_between_scans(problem, a, common)
    agreement = float(_MAD_TO_SIGMA * np.median(np.abs(r))) if len(r) else float("nan")
    return Registration(
        registered,
        tuple(alternatives),
        _wall_offsets(problem, a),
        agreement,
        len(r),
        a.reason,
        _notes(registered, alternatives),
    )


def _registered(
    scan: Scan, problem: Problem, a: Adjustment, k: int, alternatives: Sequence[Alternative]
) -> RegisteredScan:
    """Builds the result of scan k."""
    pose, prior, pieces = a.poses[k], problem.priors[k], problem.pieces[k]
    position = pose.apply(prior.position[None])[0]
    block = a.covariance[6 * k : 6 * k + 6, 6 * k : 6 * k + 6]
    block = block + alternatives_covariance(position, [o for o in alternatives if k in o.scans])
    lever = float(np.median(np.linalg.norm(pieces.xyz - prior.position, axis=1)))
    m, near = a.matches[k], np.abs(a.residuals[k]) < 3 * a.sigma
    upright = pieces.upright
    on = match_surfels(pieces.moved(pose), problem.walls, _ON_MODEL_M, roofs=False).piece
    share = float(pieces.area[on].sum() / max(pieces.area[upright].sum(), 1e-9))
    r = a.residuals[k][near]
    return RegisteredScan(
        scan.name,
        Estimate(
            pose, about_frame(block, pose, position), max(float(pieces.area[m.piece[near]].sum()) - 6, 1.0)
        ),
        position,
        block,
        principal_directions(block, prior, problem.observable, lever),
        share,
        float(_MAD_TO_SIGMA * np.median(np.abs(r))) if len(r) else float("nan"),
        int(near.sum()),
        float(pieces.area[m.piece[near]].sum()),
    )


def _distances_between_scans(problem: Problem, a: Adjustment, common: Pairs) -> Float:
    """Returns the distances (m,) m between the surfels of two scans on one surface, along its normal."""
    out = [np.zeros(0)]
    for s, t in {(int(x), int(y)) for x, y in zip(common.s, common.t, strict=True)}:
        rows = (common.s == s) & (common.t == t)
        one = problem.pieces[s].take(common.i[rows]).moved(a.poses[s])
        two = problem.pieces[t].take(common.k[rows]).moved(a.poses[t])
        out.append(np.einsum("ij,ij->i", two.normal, one.xyz - two.xyz))
    return np.concatenate(out)


def _wall_offsets(problem: Problem, a: Adjustment) -> tuple[WallOffset, ...]:
    """Returns the offsets of all patches that were seen: their buildings' shifts and their own."""
    walls = problem.walls
    count = len(walls.names)
    area = np.zeros(len(walls.patches))
    for pieces, m, w in zip(problem.pieces, a.matches, a.weights, strict=True):
        area += np.bincount(m.patch, pieces.area[m.piece] * w, len(area))
    out = []
    for j in np.flatnonzero(area > _LEAST_AREA_M2):
        p = walls.patches[j]
        b, e = p.building, a.model_errors[count + j]
        at = np.concatenate([3 * b + np.arange(3), [3 * (count + j)]])
        g = np.append(p.normal, 1.0)
        variance = float(g @ a.model_covariance[np.ix_(at, at)] @ g)
        offset = float(p.normal @ a.model_errors[b] + e[0])
        out.append(
            WallOffset(
                walls.names[b],
                p.source,
                p.kind,
                offset,
                float(np.sqrt(variance)),
                float(e[1]),
                float(e[2]),
                float(area[j]),
            )
        )
    return tuple(out)


def _notes(scans: Sequence[RegisteredScan], alternatives: Sequence[Alternative]) -> tuple[str, ...]:
    """Writes what a user must know before trusting the poses."""
    notes = []
    for s in scans:
        shifts = [d for d in s.unobservable if d.kind == "shift"]
        if lost := _list_directions([d for d in shifts if not d.weak]):
            notes.append(
                f"{s.name}: the walls do not determine the shift along {lost}; the prior applies there"
            )
        if weak := _list_directions([d for d in shifts if d.weak]):
            notes.append(f"{s.name}: the shift along {weak} is poorly determined")
        if s.explained < _LEAST_EXPLAINED:
            notes.append(f"{s.name}: only {100 * s.explained:.0f} % of its wall area lies on the model")
    if alternatives:
        notes.append(f"{len(alternatives)} other places explain the scans nearly as well; check the result")
    return tuple(notes)


def _list_directions(lost: Sequence[Direction]) -> str:
    """Lists directions with their sigmas."""
    return ", ".join(f"{d.axis.round(2).tolist()} (sigma {d.sigma:.2f} m)" for d in lost)
