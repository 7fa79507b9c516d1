"""Scans to a city model (paper B, section 2.1): pieces, ties between scans, coarse search, adjustment."""

from collections.abc import Sequence

import numpy as np

from frontage.errors import CrsError, InputError
from frontage.geometry.arrays import Float
from frontage.model import CityModel, Estimate, Scan
from frontage.registration.adjust import STAGES, Adjusted, adjust
from frontage.registration.coarse import SPAN
from frontage.registration.correspond import match
from frontage.registration.equations import Pairs, Problem
from frontage.registration.observability import about_frame, directions, spread
from frontage.registration.options import RegistrationOptions
from frontage.registration.place import place
from frontage.registration.result import (
    Alternative,
    Direction,
    PosePrior,
    Registered,
    Registration,
    WallOffset,
)
from frontage.registration.stations import pairs
from frontage.registration.surfels import Surfels, surfels
from frontage.registration.walls import Walls, model_walls

_NEAR = 0.3  # m, pieces that lie on the model


def register(
    scans: Sequence[Scan],
    model: CityModel,
    priors: Sequence[PosePrior],
    options: RegistrationOptions | None = None,
) -> Registration:
    """Poses of scans (placed roughly by `priors`, one each) against the walls of a city model.

    Raises CrsError when model and scans have different systems or lie apart, InputError when the model has no
    walls, a scan no flat pieces or the numbers of scans and priors differ.
    """
    options = options or RegistrationOptions()
    walls = _checked(scans, model, priors, options.reach)
    pieces = [
        _usable(surfels(s, options.cell, p.position, options.reach), s.name)
        for s, p in zip(scans, priors, strict=True)
    ]
    start, alternatives, together = place(pieces, walls, priors, options)
    problem = Problem(pieces, walls, priors, options)
    common = pairs(pieces, start, together, 0.2)
    result = adjust(problem, start, common, STAGES[3:])
    common = pairs(pieces, result.poses, together)
    result = adjust(problem, result.poses, common, STAGES[-1:])
    return _report(scans, problem, result, common, alternatives)


def prior_of(scan: Scan) -> PosePrior:
    """The prior that reading gave the scan with its approximate pose. Raises InputError without one."""
    pose = scan.local_from_scanner
    if pose is None or not (np.diag(pose.covariance) > 0).all():
        raise InputError(
            f"{scan.name}: has no approximate pose; state sigma_position, sigma_heading, sigma_level"
        )
    s = pose.sigma
    return PosePrior(pose.value.t, s[:3], float(s[5]), float(np.hypot(s[3], s[4]) / np.sqrt(2)))


def _checked(scans: Sequence[Scan], model: CityModel, priors: Sequence[PosePrior], reach: float) -> Walls:
    """The model's walls, after everything that can be wrong with the input was looked at."""
    if len(scans) != len(priors) or not scans:
        raise InputError(f"{len(scans)} scans with {len(priors)} pose priors; give one prior for every scan")
    for s in scans:
        if s.world.crs and model.world.crs and s.world.crs != model.world.crs:
            raise CrsError(
                f"the city model is in {model.world.crs}, {s.name} in {s.world.crs}; read both in one system"
            )
        if (s.world.origin != model.world.origin).any():
            raise CrsError(
                f"{s.name} and the city model have different local origins; read both with one world"
            )
    walls = model_walls(model)
    if not walls.of_kind("wall"):
        raise InputError(
            "the city model has no walls (LoD1 or finer) near the scans; check its file and extent"
        )
    _overlapping(walls, priors, reach)
    return walls


def _overlapping(walls: Walls, priors: Sequence[PosePrior], reach: float) -> None:
    """Raise CrsError when no wall is within reach of any scan, and say what would help."""
    place = np.array([p.point for p in walls.patches])[:, :2]
    half = np.array([0.5 * p.length for p in walls.patches])
    gap = np.array(
        [
            np.linalg.norm(place - p.position[:2], axis=1) - half - SPAN * p.sigma_position.max()
            for p in priors
        ]
    ).min()
    if gap > reach:
        far = f"{gap / 1000:.1f} km" if gap > 1000 else f"{gap:.0f} m"
        raise CrsError(
            f"the city model lies {far} from the scans; check its coordinate system and that its axes are "
            "not swapped (east before north)"
        )


def _usable(s: Surfels, name: str) -> Surfels:
    if len(s) == 0:
        raise InputError(f"{name}: has no flat surfaces within reach of its scanner; is its position right?")
    return s


def _report(
    scans: Sequence[Scan],
    problem: Problem,
    a: Adjusted,
    common: Pairs,
    alternatives: Sequence[Alternative],
) -> Registration:
    registered = tuple(_registered(scan, problem, a, k, alternatives) for k, scan in enumerate(scans))
    r = _between(problem, a, common)
    agreement = float(1.4826 * np.median(np.abs(r))) if len(r) else float("nan")
    return Registration(
        registered,
        tuple(alternatives),
        _offsets(problem, a),
        agreement,
        len(r),
        a.reason,
        _notes(registered, alternatives),
    )


def _registered(
    scan: Scan, problem: Problem, a: Adjusted, k: int, alternatives: Sequence[Alternative]
) -> Registered:
    pose, prior, pieces = a.poses[k], problem.priors[k], problem.pieces[k]
    position = pose.apply(prior.position[None])[0]
    block = a.covariance[6 * k : 6 * k + 6, 6 * k : 6 * k + 6]
    block = block + spread(position, [o for o in alternatives if k in o.scans])
    lever = float(np.median(np.linalg.norm(pieces.xyz - prior.position, axis=1)))
    m, near = a.matches[k], np.abs(a.residuals[k]) < 3 * a.sigma
    upright = pieces.upright
    on = match(pieces.moved(pose), problem.walls, _NEAR, roofs=False).piece
    share = float(pieces.area[on].sum() / max(pieces.area[upright].sum(), 1e-9))
    r = a.residuals[k][near]
    return Registered(
        scan.name,
        Estimate(
            pose, about_frame(block, pose, position), max(float(pieces.area[m.piece[near]].sum()) - 6, 1.0)
        ),
        position,
        block,
        directions(block, prior, problem.observable, lever),
        share,
        float(1.4826 * np.median(np.abs(r))) if len(r) else float("nan"),
        int(near.sum()),
        float(pieces.area[m.piece[near]].sum()),
    )


def _between(problem: Problem, a: Adjusted, common: Pairs) -> Float:
    """Distances (m,) m between scans where they overlap."""
    out = [np.zeros(0)]
    for s, t in {(int(x), int(y)) for x, y in zip(common.s, common.t, strict=True)}:
        rows = (common.s == s) & (common.t == t)
        one = problem.pieces[s].take(common.i[rows]).moved(a.poses[s])
        two = problem.pieces[t].take(common.k[rows]).moved(a.poses[t])
        out.append(np.einsum("ij,ij->i", two.normal, one.xyz - two.xyz))
    return np.concatenate(out)


def _offsets(problem: Problem, a: Adjusted) -> tuple[WallOffset, ...]:
    """Every patch that was seen, against the model: building shift and own offset together."""
    walls = problem.walls
    count = len(walls.names)
    area = np.zeros(len(walls.patches))
    for pieces, m, w in zip(problem.pieces, a.matches, a.weights, strict=True):
        area += np.bincount(m.patch, pieces.area[m.piece] * w, len(area))
    out = []
    for j in np.flatnonzero(area > 1.0):
        p = walls.patches[j]
        b, e = p.building, a.effects[count + j]
        at = np.concatenate([3 * b + np.arange(3), [3 * (count + j)]])
        g = np.append(p.normal, 1.0)
        variance = float(g @ a.effect_covariance[np.ix_(at, at)] @ g)
        offset = float(p.normal @ a.effects[b] + e[0])
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


def _notes(scans: Sequence[Registered], alternatives: Sequence[Alternative]) -> tuple[str, ...]:
    notes = []
    for s in scans:
        shifts = [d for d in s.unobservable if d.kind == "shift"]
        if lost := _words([d for d in shifts if not d.weak]):
            notes.append(
                f"{s.name}: the walls do not determine the shift along {lost}; there the prior stands"
            )
        if weak := _words([d for d in shifts if d.weak]):
            notes.append(f"{s.name}: little determines the shift along {weak}")
        if s.explained < 0.2:
            notes.append(f"{s.name}: only {100 * s.explained:.0f} % of its wall area lies on the model")
    if alternatives:
        notes.append(f"{len(alternatives)} other places explain the scans nearly as well; check the result")
    return tuple(notes)


def _words(lost: Sequence[Direction]) -> str:
    return ", ".join(f"{d.axis.round(2).tolist()} (sigma {d.sigma:.2f} m)" for d in lost)
