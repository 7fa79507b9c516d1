"""Scores the poses of photos and scans."""

from collections.abc import Sequence

import numpy as np

from frontage.evaluation.metric import ScorePart, mean, median, metric, normalised, p95
from frontage.evaluation.result import FoundPose
from frontage.evaluation.truth import TruePose
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import rotation_angle


def score_poses(truth: Sequence[TruePose], found: Sequence[FoundPose]) -> ScorePart:
    """Scores positions, attitudes, and both against the standard errors reported with them.

    `after_shift_median` is the distance that remains after the mean shift of all poses, which a misplacement
    of the whole block causes, was subtracted.
    """
    by_name = {t.name: t for t in truth}
    pairs = [(by_name[f.name], f) for f in found if f.name in by_name]
    shift = np.array([f.pose.t - t.true.t for t, f in pairs]).reshape(-1, 3)
    turn = np.array([_turn(t, f) for t, f in pairs]).reshape(-1, 3)
    distance, angle = np.linalg.norm(shift, axis=1), np.degrees(np.linalg.norm(turn, axis=1))
    rest = np.linalg.norm(shift - shift.mean(0), axis=1) if len(shift) > 1 else np.empty(0)
    names = {f.name for _, f in pairs}
    figures = {
        "recall": metric(np.array([t.name in names for t in truth]), mean),
        "position_median": metric(distance, median, "m"),
        "position_p95": metric(distance, p95, "m"),
        "after_shift_median": metric(rest, median, "m"),
        "angle_median": metric(angle, median, "deg"),
        "angle_p95": metric(angle, p95, "deg"),
        **normalised(_ratios(shift, [f.sigma_position for _, f in pairs]), "position"),
        **normalised(_ratios(turn, [f.sigma_angles for _, f in pairs]), "angle"),
    }
    rows = [
        {"id": f.name, "position_mm": round(1000 * float(d), 2), "angle_deg": round(float(a), 5)}
        for (_, f), d, a in zip(pairs, distance, angle, strict=True)
    ]
    rows += [{"id": t.name, "found": None} for t in truth if t.name not in names]
    return ScorePart(figures, tuple(rows))


def _turn(truth: TruePose, found: FoundPose) -> Float:
    """Rotation vector (3,) rad, world axes, from the true attitude to the found one."""
    R = found.pose.R @ truth.true.R.T
    angle = rotation_angle(R)
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    length = float(np.linalg.norm(axis))
    return np.asarray(axis / length * angle if length > 1e-15 else np.array([angle, 0.0, 0.0]))


def _ratios(errors: Float, sigmas: Sequence[Float | None]) -> Float:
    """Ratio error / sigma of every component that has a positive sigma."""
    known = [(e, s) for e, s in zip(errors, sigmas, strict=True) if s is not None]
    ratio = [e[s > 0] / s[s > 0] for e, s in known]
    return np.concatenate(ratio) if ratio else np.empty(0)
