"""Facades with plain rectangular openings, for tests of how openings are numbered."""

from collections.abc import Iterable

import numpy as np

from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.model import Estimate, Facade, Opening, Provenance, WorldRef


def opening(x: float, z: float, w: float = 1.0, h: float = 1.5, kind: str = "window") -> Opening:
    """Returns an opening of w x h m with its lower left corner at (x, z) m."""
    ring = rectangle(x, z, x + w, z + h)
    zero = np.zeros((2 * len(ring), 2 * len(ring)))
    return Opening("?", kind, ring, zero, None, "rectangle", Provenance.MEASURED, 1.0, 1.0, 9, 9)


def rows(sills: Iterable[float], xs: Iterable[float] = (1.0, 3.0, 5.0), **size: float) -> list[Opening]:
    """Returns windows at every crossing of the given sill heights and left edges, m."""
    return [opening(x, z, **size) for z in sills for x in list(xs)]  # type: ignore[arg-type]


def facade(id: str, origin: tuple[float, float, float] = (0.0, 0.0, 0.0), azimuth: float = 90.0) -> Facade:
    """Returns a vertical facade of 8 x 12 m; `azimuth` (degrees from x) is that of its normal inwards."""
    a = np.radians(azimuth)
    y, z = np.array([np.cos(a), np.sin(a), 0.0]), np.array([0.0, 0.0, 1.0])
    pose = Rigid3("local", "facade", np.column_stack([np.cross(y, z), y, z]), np.array(origin))
    nothing = np.empty(0, np.int64)
    return Facade(
        id, id.split("/")[0], Estimate(pose, np.eye(6) * 1e-6, 100.0), WorldRef(np.zeros(3, np.int64), None),
        rectangle(0.0, 0.0, 8.0, 12.0), (), nothing, nothing, 0.003, 0.02, 0.9, "rays",
    )  # fmt: skip
