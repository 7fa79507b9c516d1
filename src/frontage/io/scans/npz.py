"""Scans in a run folder: uncompressed arrays, bit for bit, nothing pickled."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array
from frontage.geometry.rigid import Rigid3
from frontage.io.arrayfiles import read_arrays
from frontage.io.files import reading, require_file, whole_file
from frontage.io.scans.request import ScanRequest
from frontage.model import Estimate, Grid, NoReturns, Provenance, Scan, WorldRef

_FAR_M = 1e8  # no coordinate is as large
_ARRAYS = ("xyz", "origins", "origin_index", "intensity", "rgb", "time", "return_number", "return_count")
_AGAIN = "run the stage again that made it"


def read_npz(path: str | Path, request: ScanRequest) -> list[Scan]:
    """`load_scan` as a reader of the registry; the scan keeps its own world."""
    return [load_scan(path)]


def save_scan(path: str | Path, scan: Scan) -> Path:
    """Write every field of a scan to `path` (.npz), bit for bit. Raises FileError when that fails."""
    arrays = {n: getattr(scan, n) for n in _ARRAYS if getattr(scan, n) is not None}
    if scan.grid is not None:
        arrays["grid"] = scan.grid.index
    for k, lost in enumerate(scan.no_returns):  # a bit per beam
        arrays |= {f"lost{k}_axes": lost.axes, f"lost{k}_azimuth": lost.azimuth}
        arrays |= {f"lost{k}_elevation": lost.elevation, f"lost{k}_mask": np.packbits(lost.lost)}
    meta: dict[str, Any] = {
        "no_returns": [{"origin": lost.origin, "ground": lost.ground} for lost in scan.no_returns],
        "name": scan.name,
        "crs": scan.world.crs,
        "sigma_range": scan.sigma_range,
        "notes": scan.notes,
    }
    if scan.local_from_scanner is not None:
        e = scan.local_from_scanner
        arrays["pose"], arrays["pose_covariance"] = e.value.matrix, e.covariance
        meta["pose"] = {"frm": e.value.frm, "dof": e.dof, "provenance": e.provenance.value}
    arrays["origin"] = scan.world.origin
    arrays["meta"] = np.frombuffer(json.dumps(meta).encode("utf-8"), np.uint8)
    with whole_file(path) as temporary, open(temporary, "wb") as f:
        np.savez(f, allow_pickle=False, **arrays)
    return Path(path)


def load_scan(path: str | Path) -> Scan:
    """Read what `save_scan` wrote. Raises FileError when the file is missing, truncated or corrupt."""
    p = require_file(path)
    a = read_arrays(p, _AGAIN)
    with reading(p, "Frontage scan", _AGAIN):
        if not {"meta", "xyz", "origin"} <= a.keys():
            raise FileError(p, "is not a scan that Frontage wrote", _AGAIN, code="I103")
        meta = json.loads(a["meta"].tobytes())
        pose = None
        if "pose" in a:
            rigid = Rigid3("local", meta["pose"]["frm"], a["pose"][:3, :3], a["pose"][:3, 3])
            pose = Estimate(
                rigid, a["pose_covariance"], meta["pose"]["dof"], Provenance(meta["pose"]["provenance"])
            )
        _require_sane(a)
        return Scan(
            meta["name"],
            world=WorldRef(a["origin"], meta["crs"]),
            sigma_range=meta["sigma_range"],
            grid=Grid(a["grid"]) if "grid" in a else None,
            no_returns=tuple(_no_returns(a, k, **m) for k, m in enumerate(meta.get("no_returns", ()))),
            local_from_scanner=pose,
            notes=tuple(meta["notes"]),
            **{n: a[n] for n in _ARRAYS if n in a},
        )


def _require_sane(a: dict[str, Array]) -> None:
    """Raise ValueError for coordinates or indices that no scan of ours has."""
    for name in ("xyz", "origins", "origin"):
        values = a.get(name, np.empty(0))
        if values.size and not (values.min() > -_FAR_M and values.max() < _FAR_M):  # NaN is not, either
            raise ValueError(f"{name} lie beyond {_FAR_M:g} m")
    index = a.get("origin_index", np.empty(0, np.int32))
    if index.size and not -1 <= index.min() <= index.max() < len(a.get("origins", ())):
        raise ValueError("points name origins that do not exist")
    if "time" in a and not np.isfinite(a["time"]).all():
        raise ValueError("times are not finite")


def _no_returns(a: dict[str, Array], number: int, origin: int, ground: float) -> NoReturns:
    """The beams without return of one station."""
    axes, azimuth, elevation, bits = (
        a[f"lost{number}_{name}"] for name in ("axes", "azimuth", "elevation", "mask")
    )
    shape = len(elevation), len(azimuth)
    mask = np.unpackbits(bits, count=shape[0] * shape[1]).reshape(shape)
    return NoReturns(origin, axes, azimuth, elevation, mask.view(np.bool_), ground)
