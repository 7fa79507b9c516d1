"""The stage `register`: scans with approximate poses onto the city model (paper B, section 2.1).

The stage `scans` leaves every scan as given in `scans/part_000.npz`, ...; this one leaves all of them in
place and merged in `scans/registered.npz`, and `registration/report.json`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from frontage.errors import InputError
from frontage.geometry.arrays import Float
from frontage.io.citymodels.read import read_city_model
from frontage.io.scans.read import ScanSource
from frontage.model import CityModel, Estimate, Scan, Surface, merge_scans
from frontage.pipeline.clouds import around, thin_to
from frontage.pipeline.stage import Job, Stage
from frontage.pipeline.stages.scans import approximate
from frontage.pipeline.store import registration as files
from frontage.pipeline.store.results import StageResult, StageWarning
from frontage.registration import (
    PosePrior,
    RegisteredScan,
    Registration,
    Selection,
    Strips,
    correct_strips,
    prior_of,
    register,
    select_walls,
)

_STATIONS = 64  # origins above which they are a trajectory
_TURNED = 50.0  # m: what a wrong heading moves the far end of a scan by


@dataclass(frozen=True, eq=False)
class Given:
    """Every scan as given with its source, priors of the approximate ones by number, and the city model."""

    sources: tuple[ScanSource, ...]
    scans: tuple[Scan, ...]
    priors: dict[int, PosePrior]
    model: CityModel


@dataclass(frozen=True, eq=False)
class Placed:
    """The scans in place: stations adjusted together, mobile recordings strip by strip."""

    given: Given
    merged: Scan
    stations: tuple[int, ...]
    registration: Registration | None
    strips: dict[int, Strips]
    selection: Selection
    notes: tuple[str, ...] = field(default=())


def load(job: Job) -> Given:
    """Read every scan as given, what the project says of it, and the city model around them."""
    numbers = job.store.scans().parts
    scans = tuple(job.store.part(k) for k in range(len(numbers)))
    sources = tuple(job.project.scans[k] for k in numbers)
    rough = [k for k, source in enumerate(sources) if source.pose == "approximate"]
    priors = {k: pose_prior(scans[k], sources[k]) for k in rough}
    return Given(sources, scans, priors, _model(job, scans, list(priors.values())))


def work(job: Job, given: Given) -> Placed:
    """Register the approximate scans against the city model; trusted ones stay where they are."""
    scans, priors, options = given.scans, given.priors, job.project.registration
    job.progress.begin("register", len(priors))
    stations = tuple(k for k in priors if not is_mobile(scans[k]))
    placed, found = dict(enumerate(scans)), None
    if stations:
        found = register([scans[k] for k in stations], given.model, [priors[k] for k in stations], options)
        placed |= {k: _moved(scans[k], r) for k, r in zip(stations, found.scans, strict=True)}
    strips = {
        k: correct_strips(scans[k], given.model, priors[k], options=options)
        for k in sorted(set(priors) - set(stations))
    }
    placed |= {k: found_strips.scan for k, found_strips in strips.items()}
    merged = merge_scans([placed[k] for k in range(len(scans))])
    selection = select_walls(merged, given.model, options=options)
    return Placed(given, merged, stations, found, strips, selection)


def save(job: Job, placed: Placed) -> Placed:
    """Write the merged cloud in place, and what registering found."""
    given, folder = placed.given, job.store.registration_folder
    table = files.empty_record()
    if placed.registration is not None:
        scans = [given.scans[k] for k in placed.stations]
        priors = [given.priors[k] for k in placed.stations]
        table = files.report_record(scans, priors, placed.registration)
    for k, strips in placed.strips.items():
        table["scans"] += files.strip_records(given.scans[k], given.priors[k], strips)
    table |= files.selection_record(placed.selection, placed.merged)
    job.store.save_cloud(placed.merged, registered=True)
    job.store.wrote(*files.save_report(folder, table), *files.save_walls(folder, placed.selection))
    job.store.wrote(*files.save_plan(folder, _plan(placed)))
    return placed


def join(job: Job, parts: list[Placed]) -> StageResult:
    """Tell what was moved, and what a user must know or decide."""
    (placed,) = parts
    given, found = placed.given, placed.registration
    trusted = len(given.scans) - len(given.priors)
    notes = [
        *(found.notes if found else ()),
        *([f"{trusted} scans have trusted poses and were not moved"] if trusted else []),
        *given.model.notes,
        *(str(problem.message) for problem in given.model.problems),
        *files.selection_notes(placed.selection),
    ]
    warnings = _ambiguous(found) if found else ()
    return StageResult(items=len(given.priors), notes=tuple(notes), warnings=warnings)


def _model(job: Job, scans: Sequence[Scan], priors: Sequence[PosePrior]) -> CityModel:
    """Read the city model as far around the scans as they may have to move."""
    source = job.project.model
    assert source is not None  # the project is refused without one
    reach = _TURNED + 4.0 * max(float(p.sigma_position.max()) for p in priors)
    return read_city_model(source.path, scans[0].world, around(scans, reach), source.crs)


def is_mobile(scan: Scan) -> bool:
    """Tell whether a scan was measured on the move: it has times and more origins than stations would be."""
    return scan.time is not None and len(scan.origins) > _STATIONS


def pose_prior(scan: Scan, source: ScanSource) -> PosePrior:
    """Return what the project says of a scan's pose, about the place where its instrument stood.

    Raises InputError if the scan does not tell where that was.
    """
    if scan.local_from_scanner is not None:
        return prior_of(scan)
    if not len(scan.origins) or source.sigmas is None:
        raise InputError(
            f"{scan.name}: an approximate pose needs the instrument's position; give E57 or PTX, or "
            "stations = ... or trajectory = ... beside the scan"
        )
    sigma = np.array(source.sigmas)
    return PosePrior(scan.origins.mean(0), sigma[:3], float(sigma[5]), float(sigma[3]))


def _plan(placed: Placed) -> dict[str, Float]:
    """Return what the report draws: walls (k, 2, 2) and points (n, 2) before and after, m local."""
    shells = [shell for building in placed.given.model.buildings for shell in building.shells]
    rings = [s.ring for shell in shells for s in shell.surfaces if _upright(s)]
    return {
        "walls": np.array([_ends(ring) for ring in rings]).reshape(-1, 2, 2),
        "before": _from_side(placed.given.scans),
        "after": _from_side([placed.merged]),
    }


def _upright(surface: Surface) -> bool:
    """Tell whether a polygon is upright: its area vector is nearly horizontal."""
    ring = surface.ring - surface.ring.mean(0)
    area = np.cross(ring, np.roll(ring, -1, 0)).sum(0)
    return bool(abs(area[2]) < 0.2 * np.linalg.norm(area))


def _ends(ring: Float) -> Float:
    """Return both ends (2, 2) of an upright polygon in plan: its extreme corners along its main direction."""
    xy = ring[:, :2]
    along = np.linalg.svd(xy - xy.mean(0))[2][0]
    s = xy @ along
    return np.asarray(xy[[s.argmin(), s.argmax()]])


def _from_side(scans: Sequence[Scan]) -> Float:
    """Return points (n, 2) in plan, of those up to 8 m above the instruments: walls, not ground."""
    xyz, origins = (
        np.concatenate(arrays) for arrays in zip(*((s.xyz, s.origins) for s in scans), strict=True)
    )
    eye = float(np.median(origins[:, 2] if len(origins) else xyz[:, 2]))
    up = xyz[(xyz[:, 2] > eye) & (xyz[:, 2] < eye + 8.0)]
    flat = np.column_stack([up[:, :2], np.zeros(len(up))])
    return np.asarray(flat[thin_to(flat, 0.1, 300_000), :2])


def _moved(scan: Scan, r: RegisteredScan) -> Scan:
    """Return the scan with its points, origins, beams without return and pose corrected."""
    T = r.local_from_given.value
    pose = scan.local_from_scanner
    if pose is not None:
        pose = Estimate(T.after(pose.value), r.covariance, r.local_from_given.dof)
    lost = tuple(beams.moved(T) for beams in scan.no_returns)
    xyz, origins = T.apply(scan.xyz), T.apply(scan.origins)
    return replace(scan, xyz=xyz, origins=origins, no_returns=lost, local_from_scanner=pose)


def _ambiguous(found: Registration) -> tuple[StageWarning, ...]:
    """Return what a user must decide about: another place fits as well."""
    if not found.ambiguous:
        return ()
    shifts = "; ".join(f"{np.hypot(*a.shift[:2]):.1f} m away" for a in found.alternatives)
    message = f"other places explain the scans nearly as well ({shifts})"
    hint = "give better positions (sigma_position) or more of the street"
    return (StageWarning("registration", "R201", message, hint),)


STAGE = Stage(
    name="register",
    after=("scans",),
    load=load,
    work=work,
    save=save,
    join=join,
    table="registration",
    applies=approximate,
    rooms=("registration",),
    inputs=("model",),
    options=("model.crs", "registration"),
)
