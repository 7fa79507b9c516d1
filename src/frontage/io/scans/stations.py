"""Station positions beside a LAS file: `[{"station": point_source_id, "position": [x, y, z]}, ...]`."""

import json
from pathlib import Path

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array, Float
from frontage.io.crs import LARGEST_M
from frontage.io.files import reading, require_file, whole_file
from frontage.io.placement import Placement
from frontage.model import Scan


def rays_from_stations(
    path: str | Path, source: Array, place: Placement, notes: list[str]
) -> tuple[Float, Array]:
    """The origins (s, 3) m local of a stations file, and the origin of every point (n,) int32.

    `source` (n,) holds the source ids of the points. Points whose source the file does not name get -1, and
    `notes` gets a sentence.

    Raises FileError when the file is missing or malformed, or names a station twice or without a position.
    """
    p = require_file(path)
    with reading(p, "stations", 'it should hold [{"station": 1, "position": [x, y, z]}, ...]'):
        entries = json.loads(p.read_text("utf-8"))
        ids = np.array([int(e["station"]) for e in entries], np.int64)
        positions = np.array([[float(v) for v in e["position"]] for e in entries]).reshape(-1, 3)
    if not len(ids) or len(np.unique(ids)) != len(ids) or not (np.abs(positions) < LARGEST_M).all():
        raise FileError(
            p, "names no station, a station twice, or one without a position", "correct it", code="I108"
        )
    order = np.argsort(ids)
    at = np.clip(np.searchsorted(ids[order], source), 0, len(ids) - 1)
    known = ids[order][at] == source
    if not known.all():
        count = int((~known).sum())
        notes.append(f"{p.name}: {count} points have a source id without a station; their origin is unknown")
    return place.to_local(positions), np.where(known, order[at], -1).astype(np.int32)


def write_stations(path: Path, scan: Scan, first: int) -> None:
    """Write the origins of a scan in world coordinates; `first` is the id of origin 0. Raises FileError."""
    world = scan.world.to_world(scan.origins)
    entries = [
        {"station": first + i, "position": [round(float(v), 6) for v in xyz]} for i, xyz in enumerate(world)
    ]
    with whole_file(path) as temporary:
        temporary.write_text(json.dumps(entries), "utf-8")
