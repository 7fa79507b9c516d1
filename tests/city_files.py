"""A house and small helpers for the tests of city models."""

import json
from pathlib import Path

import numpy as np

from frontage.model import CityBuilding, Shell, Surface, WorldRef

LOCAL = WorldRef(np.zeros(3, np.int64))


def write(path: Path, text: str | dict) -> Path:
    """Writes text, or a table as JSON."""
    path.write_text(text if isinstance(text, str) else json.dumps(text))
    return path


def volume(shell: Shell) -> float:
    """Returns the volume, m3, by the divergence theorem; positive where polygons run counter-clockwise seen
    from outside."""
    total, middle = 0.0, np.mean([s.ring.mean(0) for s in shell.surfaces], axis=0)
    for s in shell.surfaces:
        for ring in (r - middle for r in (s.ring, *s.holes)):
            total += np.linalg.det(np.stack(np.broadcast_arrays(ring[0], ring[1:-1], ring[2:]), 1)).sum() / 6
    return total


HOUSE = [("GroundSurface", [[0, 6, 0], [8, 6, 0], [8, 0, 0], [0, 0, 0]]),
         ("RoofSurface", [[0, 0, 5], [8, 0, 5], [8, 6, 5], [0, 6, 5]]),
         ("WallSurface", [[0, 0, 0], [8, 0, 0], [8, 0, 5], [0, 0, 5]]),
         ("WallSurface", [[8, 0, 0], [8, 6, 0], [8, 6, 5], [8, 0, 5]]),
         ("WallSurface", [[8, 6, 0], [0, 6, 0], [0, 6, 5], [8, 6, 5]]),
         ("WallSurface", [[0, 6, 0], [0, 0, 0], [0, 0, 5], [0, 6, 5]])]  # fmt: skip


def house(name: str, x: float) -> CityBuilding:
    """Returns a box of 8 x 6 x 5 m whose lower left corner stands at `x` m."""
    faces = tuple(
        Surface(np.array(ring, float) + np.array([x, 0, 0]), kind, f"{name}/s{k}")
        for k, (kind, ring) in enumerate(HOUSE)
    )
    return CityBuilding(
        name,
        (Shell("2.2", faces, {f"{name}/s2": {"sigma": 0.004}}),),
        "12 Lime Street",
        {"measuredHeight": 5.0},
    )
