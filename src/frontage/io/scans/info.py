"""What a scan file holds, for `frontage info`."""

from pathlib import Path
from typing import Any

import numpy as np

from frontage.io.scans.read import read_scans
from frontage.io.scans.subset import spacing
from frontage.model import Grid, Scan

_FIELDS = ("intensity", "rgb", "time", "return_number")


def scan_info(path: str | Path) -> dict[str, Any]:
    """JSON-able facts of a scan file: points, extent (m world), CRS, notes, and those of every scan.

    `spacing` is the median distance in m to the nearest neighbour, measured at some thousand points.

    Raises FileError, CrsError, MissingExtra as `read_scans` does.
    """
    scans = read_scans(path)
    low = np.min([s.world.to_world(s.xyz.min(0)) for s in scans], axis=0)
    high = np.max([s.world.to_world(s.xyz.max(0)) for s in scans], axis=0)
    return {
        "path": str(path),
        "format": Path(path).suffix.lower().lstrip(".") or "colmap",
        "points": sum(len(s) for s in scans),
        "crs": scans[0].world.crs,
        "minimum": low.round(4).tolist(),
        "maximum": high.round(4).tolist(),
        "scans": [_scan_facts(s) for s in scans],
        "notes": list(dict.fromkeys(n for s in scans for n in s.notes)),
    }


def _scan_facts(scan: Scan) -> dict[str, Any]:
    return {
        "name": scan.name,
        "points": len(scan),
        "spacing": round(spacing(scan), 5),
        "fields": [name for name in _FIELDS if getattr(scan, name) is not None],
        "origins": len(scan.origins),
        "with_origin": float(np.mean(scan.origin_index >= 0)),
        "raster": list(scan.grid.index.shape) if isinstance(scan.grid, Grid) else None,
    }
