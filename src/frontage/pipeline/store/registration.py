"""registration/report.json: what registering found, as users and programs read it (DESIGN section 6)."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Float
from frontage.io.arrayfiles import read_arrays
from frontage.model import Scan
from frontage.pipeline.store.files import read_json, write_arrays, write_json
from frontage.registration import (
    Direction,
    PosePrior,
    RegisteredScan,
    Registration,
    Selection,
    Strips,
    WallOffset,
    WallPoints,
)


def empty_record() -> dict[str, Any]:
    """The report without any scan."""
    lists: dict[str, Any] = {name: [] for name in ("scans", "alternatives", "walls", "notes")}
    return lists | {"ambiguous": False, "agreement": None, "overlap": 0, "reason": ""}


def report_record(scans: Sequence[Scan], priors: Sequence[PosePrior], found: Registration) -> dict[str, Any]:
    """`registration/report.json`: per scan the matrix into the world, covariance, what was observable."""
    return {
        "scans": [_scan_record(s, p, r) for s, p, r in zip(scans, priors, found.scans, strict=True)],
        "ambiguous": found.ambiguous,
        "alternatives": [
            {"shift": a.shift.tolist(), "turn": float(np.degrees(a.turn)), "score": a.score}
            for a in found.alternatives
        ],
        "agreement": _finite(found.agreement),
        "overlap": found.overlap,
        "walls": [_wall_record(w) for w in found.walls],
        "reason": found.reason,
        "notes": list(found.notes),
    }


def _scan_record(scan: Scan, prior: PosePrior, r: RegisteredScan) -> dict[str, Any]:
    """Angles in degrees but for the covariance (m, rad); `matrix` acts on the coordinates named by `from`."""
    local_from_file, source = _file_frame(scan)
    world = np.eye(4)
    world[:3, 3] = scan.world.origin
    return {
        "scan": scan.name,
        "from": source,
        "matrix": (world @ r.local_from_given.value.matrix @ local_from_file).tolist(),
        "correction": r.local_from_given.value.matrix.tolist(),
        "covariance": r.covariance.tolist(),
        "given": scan.world.to_world(prior.position[None])[0].tolist(),
        "position": scan.world.to_world(r.position[None])[0].tolist(),
        "sigma_prior": prior.sigma.tolist(),
        "observable": [_direction(d) for d in r.directions],
        "residual": _finite(r.residual),
        "explained": r.explained,
        "pieces": r.pieces,
        "area": r.area,
    }


def _file_frame(scan: Scan) -> tuple[Float, str]:
    """What the file's coordinates are, and how they were placed: (4, 4) local from them."""
    if scan.local_from_scanner is not None:
        return scan.local_from_scanner.value.matrix, "scanner"
    M = np.eye(4)
    M[:3, 3] = -scan.world.origin.astype(np.float64)
    return M, "file, in the project's system"


def _wall_record(w: WallOffset) -> dict[str, Any]:
    turn, lean = np.degrees([w.turn, w.lean]).tolist()
    record = {"building": w.building, "surface": w.surface, "kind": w.kind, "offset": w.offset}
    return record | {"sigma": w.sigma, "turn": turn, "lean": lean, "area": w.area}


def _direction(d: Direction) -> dict[str, Any]:
    sigma, prior = _unit(d.kind, d.sigma), _unit(d.kind, d.sigma_prior)
    known = {"sigma": sigma, "sigma_prior": prior, "observable": d.observable, "weak": d.weak}
    return {"kind": d.kind, "axis": d.axis.tolist()} | known


def strip_records(scan: Scan, prior: PosePrior, strips: Strips) -> list[dict[str, Any]]:
    """One entry per strip of a mobile recording; `matrix` acts on the file's coordinates."""
    local_from_file, source = _file_frame(scan)
    world = np.eye(4)
    world[:3, 3] = scan.world.origin
    table = []
    for k, strip in enumerate(strips.strips, 1):
        T = strip.local_from_given.value
        given = T.inverse.apply(strip.position[None])
        table.append(
            {
                "scan": f"{scan.name}, strip {k}",
                "from": source,
                "time": strip.time,
                "matrix": (world @ T.matrix @ local_from_file).tolist(),
                "correction": T.matrix.tolist(),
                "covariance": strip.covariance.tolist(),
                "given": scan.world.to_world(given)[0].tolist(),
                "position": scan.world.to_world(strip.position[None])[0].tolist(),
                "sigma_prior": prior.sigma.tolist(),
                "observable": [_direction(d) for d in strip.directions],
                "residual": None,
                "explained": None,
            }
        )
    return table


def selection_record(found: Selection, scan: Scan) -> dict[str, Any]:
    """The facades of the model with their points, and what only one of model and scan has."""
    return {
        "facades": [_facade(w) for w in found.walls],
        "absent": list(found.absent),
        "unseen": list(found.unseen),
        "unknown": [
            {"centre": scan.world.to_world(c[None])[0].tolist(), "area": area} for c, area in found.unknown
        ],
    }


def _facade(w: WallPoints) -> dict[str, Any]:
    sigma = [float(w.sigma[0]), *np.degrees(w.sigma[1:]).tolist()]
    against = {"offset": w.offset, "turn": float(np.degrees(w.turn)), "lean": float(np.degrees(w.lean))}
    seen = {"points": len(w.index), "coverage": w.coverage, "significance": w.significance.tolist()}
    return {"building": w.building, "surface": w.surface} | against | {"sigma": sigma} | seen


def save_report(folder: Path, table: dict[str, Any]) -> list[Path]:
    """Write `report.json`; returns the files written."""
    write_json(folder / "report.json", table)
    return [folder / "report.json"]


def save_walls(folder: Path, found: Selection) -> list[Path]:
    """Write `walls.npz`; returns the files written.

    It holds per wall k the points `index_k` (into registered.npz), `relief_k`, its `corner_k` and `cell_k`,
    and the matrix `local_from_facade_k`.
    """
    arrays: dict[str, Any] = {}
    for k, w in enumerate(found.walls):
        arrays[f"index_{k}"], arrays[f"relief_{k}"] = w.index, w.relief
        arrays[f"corner_{k}"], arrays[f"cell_{k}"] = np.array(w.corner), np.array(w.cell)
        arrays[f"local_from_facade_{k}"] = w.local_from_facade.matrix
    write_arrays(folder / "walls.npz", arrays)
    return [folder / "walls.npz"]


def save_plan(folder: Path, plan: dict[str, Float]) -> list[Path]:
    """Write `plan.npz`: walls (k, 2, 2) and points (n, 2) before and after, m local; returns the files."""
    write_arrays(folder / "plan.npz", plan)
    return [folder / "plan.npz"]


def load_report(folder: Path) -> tuple[dict[str, Any], dict[str, Float]]:
    """Return `report.json` and the arrays of `plan.npz`. Raises FileError if they are missing or damaged."""
    advice = "run `frontage register` again"
    try:
        table = dict(read_json(folder / "report.json"))
    except (OSError, ValueError) as error:
        raise FileError(folder / "report.json", f"cannot be read ({error})", advice) from None
    return table, read_arrays(folder / "plan.npz", advice)


def selection_notes(found: Selection) -> list[str]:
    """What a user should know of the buildings that only one side has."""
    notes = []
    if found.absent:
        notes.append(f"in the model, but not there: {', '.join(found.absent)}")
    if found.unknown:
        notes.append(f"{len(found.unknown)} buildings were scanned that the model does not hold")
    return notes


def _unit(kind: str, sigma: float) -> float:
    return float(np.degrees(sigma)) if kind == "turn" else sigma


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
