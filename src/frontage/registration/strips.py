"""Correct mobile recordings by piecewise rigid motions along time, because a trajectory drifts.

The recording is cut into strips of about `length` m of drive. Strips are adjusted together against the model,
with links between neighbours (how much a trajectory drifts over that length). Points between the middles of
two strips are corrected by the mean of both motions, weighted by time, so that nothing tears.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.errors import InputError
from frontage.geometry.arrays import Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.model import CityModel, Estimate, Scan
from frontage.registration.adjust import GNC_STAGES, adjust
from frontage.registration.observability import about_frame, principal_directions
from frontage.registration.options import RegistrationOptions
from frontage.registration.problem import Link, Problem
from frontage.registration.result import Direction, PosePrior
from frontage.registration.walls import model_walls
from frontage.solve.surfels import make_surfels


@dataclass(frozen=True, eq=False)
class Strip:
    """One strip of a recording.

    time              s, at its middle
    local_from_given  correction of its points
    position          (3,) m local, of the vehicle after the correction
    covariance        (6, 6) of the position and the rotation about it (m, rad)
    directions        which directions the walls determine
    """

    time: float
    local_from_given: Estimate[Rigid3]
    position: Float
    covariance: Float
    directions: tuple[Direction, ...]


@dataclass(frozen=True, eq=False)
class Strips:
    """All strips, and the scan with their corrections applied; `reason` says why the adjustment stopped."""

    strips: tuple[Strip, ...]
    scan: Scan
    reason: str


def correct_strips(
    scan: Scan,
    model: CityModel,
    prior: PosePrior,
    *,
    length: float = 20.0,
    drift: float = 0.02,
    drift_angle: float = 3e-4,
    options: RegistrationOptions | None = None,
) -> Strips:
    """Corrects a mobile recording that is already within about 2 m of the model.

    prior        how well the trajectory is known as a whole; each strip's middle replaces its position
    length       m of drive per strip
    drift        m, one sigma by which neighbouring strips differ
    drift_angle  rad, the same of their rotation

    Raises InputError when the scan has no times or no trajectory.
    """
    options = options or RegistrationOptions()
    if scan.time is None or not scan.has_origins or len(scan.origins) < 2:
        raise InputError(f"{scan.name}: strips need gps_time and a trajectory; give the scan its trajectory")
    strip, middles, times = _cut(scan, length)
    parts = [scan.take(strip == k) for k in range(len(middles))]
    pieces = [make_surfels(p, options.cell, m, options.reach) for p, m in zip(parts, middles, strict=True)]
    priors = [replace(prior, position=m) for m in middles]
    sigma = np.array([drift] * 3 + [drift_angle] * 3)
    links = [Link(k, k + 1, sigma) for k in range(len(middles) - 1)]
    problem = Problem(pieces, model_walls(model), priors, options, tuple(links))
    a = adjust(problem, [Rigid3.identity("local", "given")] * len(middles), None, GNC_STAGES[1:])
    strips = []
    for k, (pose, p) in enumerate(zip(a.poses, priors, strict=True)):
        block = a.covariance[6 * k : 6 * k + 6, 6 * k : 6 * k + 6]
        here = pose.apply(p.position[None])[0]
        estimate = Estimate(pose, about_frame(block, pose, here), max(float(len(a.matches[k])) / 25, 1.0))
        known = principal_directions(block, p, problem.observable, 15.0)
        strips.append(Strip(float(times[k]), estimate, here, block, known))
    return Strips(tuple(strips), _corrected(scan, times, a.poses), a.reason)


def _cut(scan: Scan, length: float) -> tuple[Int, Float, Float]:
    """Returns the strip (n,) of every point, and the middles (k, 3) m and (k,) s of the strips."""
    assert scan.time is not None  # checked by the caller
    known = scan.origin_index >= 0
    order = np.argsort(scan.time[known], kind="stable")
    time = scan.time[known][order]
    place = scan.origins[scan.origin_index[known][order]]
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(place, axis=0), axis=1))])
    # two scanner heads take turns, so the way is scaled to that of a smooth track
    way = way / max(way[-1], 1e-9) * float(np.linalg.norm(np.ptp(place, axis=0)))
    number = max(round(float(way[-1]) / length), 1)
    edges = np.interp(np.linspace(0, way[-1], number + 1), way, time)
    strip = np.clip(np.searchsorted(edges, scan.time, "right") - 1, 0, number - 1)
    times = 0.5 * (edges[1:] + edges[:-1])
    middles = np.column_stack([np.interp(times, time, place[:, a]) for a in range(3)])
    return strip.astype(np.int64), middles, times


def _corrected(scan: Scan, times: Float, poses: Sequence[Rigid3]) -> Scan:
    """Moves points and sensor positions by the motions of the two nearest strips, weighted by time."""
    assert scan.time is not None  # checked by the caller
    xyz = _blended(scan.xyz, scan.time, times, poses)
    known = scan.origin_index >= 0
    index = scan.origin_index[known]
    count = np.maximum(np.bincount(index, minlength=len(scan.origins)), 1)
    when = np.bincount(index, scan.time[known] - times[0], len(scan.origins)) / count + times[0]
    return replace(scan, xyz=xyz, origins=_blended(scan.origins, when, times, poses))


def _blended(xyz: Float, time: Float, times: Float, poses: Sequence[Rigid3]) -> Float:
    """Moves points (n, 3) m, measured at `time` (n,) s, by the motions of the strips around it.

    times  (k,) s, middles of the strips
    """
    if len(poses) == 1:
        return poses[0].apply(xyz)
    k = np.clip(np.searchsorted(times, time) - 1, 0, len(times) - 2)
    share = np.clip((time - times[k]) / (times[k + 1] - times[k]), 0.0, 1.0)[:, None]
    out = np.empty_like(xyz)
    for j in range(len(times) - 1):
        rows = k == j
        a, b = poses[j].apply(xyz[rows]), poses[j + 1].apply(xyz[rows])
        out[rows] = (1 - share[rows]) * a + share[rows] * b
    return out
