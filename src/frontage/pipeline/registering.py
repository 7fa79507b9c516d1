"""The register stage: scans with approximate poses onto the city model (paper B, section 2.1).

The scans stage leaves every scan as given in `scans/part_000.npz`, ...; this one leaves all of them in place
and merged in `scans/registered.npz`, and `registration/report.json`.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from frontage.errors import InputError
from frontage.geometry.arrays import Float
from frontage.io.citymodels.read import read_city_model
from frontage.io.scans.npz import load_scan, save_scan
from frontage.io.scans.read import ScanSource
from frontage.model import CityModel, Estimate, Scan, Surface, merge_scans
from frontage.pipeline.clouds import around, thin_to
from frontage.pipeline.context import Run
from frontage.pipeline.files import write_arrays, write_json
from frontage.pipeline.project import Project
from frontage.pipeline.registered import (
    empty_record,
    report_record,
    save_walls,
    selection_notes,
    selection_record,
    strip_records,
)
from frontage.registration import (
    PosePrior,
    RegisteredScan,
    Registration,
    correct_strips,
    prior_of,
    register,
    select_walls,
)

Result = dict[str, Any]
_STATIONS = 64  # origins above which they are a trajectory
_TURNED = 50.0  # m: what a wrong heading moves the far end of a scan by


def approximate(project: Project) -> bool:
    """Whether any scan of the project has to be registered."""
    return any(source.pose == "approximate" for source in project.scans)


def save_parts(run: Run, parts: Sequence[tuple[int, Scan]]) -> list[int]:
    """Keep scans as given, one file each; returns the number of the project's source of each."""
    for k, (_, scan) in enumerate(parts):
        save_scan(run.workspace.part_path(k), scan)
    return [source for source, _ in parts]


def register_scans(run: Run) -> Result:
    """Register the approximate scans against the city model; trusted ones stay where they are.

    Stations are adjusted together, every mobile recording strip by strip along its trajectory.
    """
    sources, scans = _load_parts(run)
    rough = [k for k, source in enumerate(sources) if source.pose == "approximate"]
    priors = {k: pose_prior(scans[k], sources[k]) for k in rough}
    model = _model(run, scans, list(priors.values()))
    run.progress.begin("register", len(rough))
    still = [k for k in rough if not is_mobile(scans[k])]
    options, placed = run.project.registration, dict(enumerate(scans))
    found, table = None, empty_record()
    if still:
        found = register([scans[k] for k in still], model, [priors[k] for k in still], options)
        placed |= {k: _moved(scans[k], r) for k, r in zip(still, found.scans, strict=True)}
        table = report_record([scans[k] for k in still], [priors[k] for k in still], found)
    for k in sorted(set(rough) - set(still)):
        strips = correct_strips(scans[k], model, priors[k], options=options)
        placed[k] = strips.scan
        table["scans"] += strip_records(scans[k], priors[k], strips)
    merged = merge_scans([placed[k] for k in range(len(scans))])
    selection = select_walls(merged, model, options=options)
    run.workspace.begin("register")
    run.workspace.registration_folder.mkdir(exist_ok=True)
    save_scan(run.workspace.registered_path, merged)
    write_json(run.workspace.registration_folder / "report.json", table | selection_record(selection, merged))
    save_walls(run.workspace.registration_folder / "walls.npz", selection)
    _save_plan(run, model, scans, merged)
    notes = [*table["notes"], *_trusted_note(len(scans) - len(rough)), *model.notes]
    notes += [*(str(p.message) for p in model.problems), *selection_notes(selection)]
    return {"items": len(rough), "notes": notes, "warnings": _warnings(found) if found else []}


def _load_parts(run: Run) -> tuple[list[ScanSource], list[Scan]]:
    """Every scan as given, and what the project says of it."""
    marker = run.workspace.done("scans")
    assert marker is not None
    numbers = marker["result"]["parts"]
    scans = [load_scan(run.workspace.part_path(k)) for k in range(len(numbers))]
    return [run.project.scans[k] for k in numbers], scans


def _model(run: Run, scans: Sequence[Scan], priors: Sequence[PosePrior]) -> CityModel:
    """The city model as far around the scans as they may have to move."""
    source = run.project.model
    assert source is not None  # the project is refused without one
    reach = _TURNED + 4.0 * max(float(p.sigma_position.max()) for p in priors)
    return read_city_model(source.path, scans[0].world, around(scans, reach), source.crs)


def is_mobile(scan: Scan) -> bool:
    """Whether a scan was measured on the move: it has times, and more places than stations would be."""
    return scan.time is not None and len(scan.origins) > _STATIONS


def pose_prior(scan: Scan, source: ScanSource) -> PosePrior:
    """What the project says of a scan's pose, about the place where its instrument stood.

    Raises InputError when the scan does not tell where that was.
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


def _save_plan(run: Run, model: CityModel, scans: Sequence[Scan], merged: Scan) -> None:
    """`registration/plan.npz` for the report: walls (k, 2, 2) and points (n, 2) before and after, m local."""
    rings = [s.ring for b in model.buildings for shell in b.shells for s in shell.surfaces if _upright(s)]
    plan = {
        "walls": np.array([_ends(ring) for ring in rings]).reshape(-1, 2, 2),
        "before": _from_side(scans),
        "after": _from_side([merged]),
    }
    write_arrays(run.workspace.registration_folder / "plan.npz", plan)


def _upright(surface: Surface) -> bool:
    """Whether a polygon stands: its area vector is nearly level."""
    ring = surface.ring - surface.ring.mean(0)
    area = np.cross(ring, np.roll(ring, -1, 0)).sum(0)
    return bool(abs(area[2]) < 0.2 * np.linalg.norm(area))


def _ends(ring: Float) -> Float:
    """Both ends (2, 2) of an upright polygon in plan: its corners furthest along its main direction."""
    xy = ring[:, :2]
    along = np.linalg.svd(xy - xy.mean(0))[2][0]
    s = xy @ along
    return np.asarray(xy[[s.argmin(), s.argmax()]])


def _from_side(scans: Sequence[Scan]) -> Float:
    """Points (n, 2) from above, of those up to 8 m above the instruments: walls, no ground."""
    xyz, origins = (
        np.concatenate(arrays) for arrays in zip(*((s.xyz, s.origins) for s in scans), strict=True)
    )
    eye = float(np.median(origins[:, 2] if len(origins) else xyz[:, 2]))
    up = xyz[(xyz[:, 2] > eye) & (xyz[:, 2] < eye + 8.0)]
    flat = np.column_stack([up[:, :2], np.zeros(len(up))])
    return np.asarray(flat[thin_to(flat, 0.1, 300_000), :2])


def _moved(scan: Scan, r: RegisteredScan) -> Scan:
    """The scan with its points, origins, lost beams and pose corrected."""
    T = r.local_from_given.value
    pose = scan.local_from_scanner
    if pose is not None:
        pose = Estimate(T.after(pose.value), r.covariance, r.local_from_given.dof)
    lost = tuple(beams.moved(T) for beams in scan.no_returns)
    xyz, origins = T.apply(scan.xyz), T.apply(scan.origins)
    return replace(scan, xyz=xyz, origins=origins, no_returns=lost, local_from_scanner=pose)


def _warnings(found: Registration) -> list[dict[str, str]]:
    """What a user must decide about: another place fits as well."""
    if not found.ambiguous:
        return []
    shifts = "; ".join(f"{np.hypot(*a.shift[:2]):.1f} m away" for a in found.alternatives)
    return [
        {
            "code": "R201",
            "item": "registration",
            "message": f"other places explain the scans nearly as well ({shifts})",
            "hint": "give better positions (sigma_position) or more of the street",
        }
    ]


def _trusted_note(count: int) -> list[str]:
    return [f"{count} scans have trusted poses and were not moved"] if count else []
