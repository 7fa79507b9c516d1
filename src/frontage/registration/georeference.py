"""Register scans to a city model (paper B, section 2.1), step by step."""

from collections.abc import Sequence

import numpy as np

from frontage.errors import CrsError, InputError
from frontage.model import CityModel, Scan
from frontage.registration.adjust import GNC_STAGES, adjust
from frontage.registration.coarse import SPAN_SIGMAS
from frontage.registration.groups import common_surfels
from frontage.registration.initial import initial_poses
from frontage.registration.options import RegistrationOptions
from frontage.registration.problem import Problem
from frontage.registration.result import PosePrior, Registration
from frontage.registration.summary import summarise
from frontage.registration.walls import ModelWalls, model_walls
from frontage.solve.surfels import Surfels, make_surfels

_FIRST_SPREAD_M = 0.2  # m, distance between scans within which surfels are common, before the adjustment


def register(
    scans: Sequence[Scan],
    model: CityModel,
    priors: Sequence[PosePrior],
    options: RegistrationOptions | None = None,
) -> Registration:
    """Estimates the poses of scans, which `priors` place roughly, against the walls of a city model.

    scans   with one prior each
    model   in the same coordinate system and with the same local origin

    The scans are cut into surfels and tied to one another; a coarse search places each group of tied scans on
    the model; a robust adjustment of all poses and of the model's own errors follows (paper B uses ICP here).

    Raises CrsError when model and scans have different systems or lie apart, and InputError when the model
    has no walls, a scan has no flat surfels, or the numbers of scans and priors differ.
    """
    options = options or RegistrationOptions()
    walls = _checked_walls(scans, model, priors, options.reach)
    pieces = [
        _checked_surfels(make_surfels(s, options.cell, p.position, options.reach), s.name)
        for s, p in zip(scans, priors, strict=True)
    ]
    start, alternatives, together = initial_poses(pieces, walls, priors, options)
    problem = Problem(pieces, walls, priors, options)
    common = common_surfels(pieces, start, together, _FIRST_SPREAD_M)
    result = adjust(problem, start, common, GNC_STAGES[3:])
    common = common_surfels(pieces, result.poses, together)
    result = adjust(problem, result.poses, common, GNC_STAGES[-1:])
    return summarise(scans, problem, result, common, alternatives)


def prior_of(scan: Scan) -> PosePrior:
    """Returns the prior that a scan with an approximate pose was read with. Raises InputError without one."""
    pose = scan.local_from_scanner
    if pose is None or not (np.diag(pose.covariance) > 0).all():
        raise InputError(
            f"{scan.name} has no approximate pose; state sigma_position, sigma_heading, sigma_level"
        )
    s = pose.sigma
    return PosePrior(pose.value.t, s[:3], float(s[5]), float(np.hypot(s[3], s[4]) / np.sqrt(2)))


def _checked_walls(
    scans: Sequence[Scan], model: CityModel, priors: Sequence[PosePrior], reach: float
) -> ModelWalls:
    """Returns the model's walls after checking the input. Raises CrsError or InputError."""
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
    _check_overlap(walls, priors, reach)
    return walls


def _check_overlap(walls: ModelWalls, priors: Sequence[PosePrior], reach: float) -> None:
    """Raises CrsError when no wall lies within reach of any scan, and says what would help."""
    place = np.array([p.point for p in walls.patches])[:, :2]
    half = np.array([0.5 * p.length for p in walls.patches])
    gap = np.array(
        [
            np.linalg.norm(place - p.position[:2], axis=1) - half - SPAN_SIGMAS * p.sigma_position.max()
            for p in priors
        ]
    ).min()
    if gap > reach:
        far = f"{gap / 1000:.1f} km" if gap > 1000 else f"{gap:.0f} m"
        raise CrsError(
            f"the city model lies {far} from the scans; check its coordinate system and that its axes are "
            "not swapped (east before north)"
        )


def _checked_surfels(s: Surfels, name: str) -> Surfels:
    """Returns the surfels of a scan. Raises InputError when there are none."""
    if len(s) == 0:
        raise InputError(f"{name} has no flat surfaces within reach of its scanner; check its position")
    return s
