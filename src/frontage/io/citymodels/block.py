"""Footprints extruded to blocks of level of detail 1."""

from collections.abc import Iterator

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import Surface
from frontage.model.citymodel import Shell


def block(footprint: Shell, height: float) -> Shell:
    """Extrude the polygons of a footprint by `height` m: ground, walls and a flat roof.

    Every side of a ring gives one wall; all rings are counter-clockwise seen from outside.
    """
    surfaces: list[Surface] = []
    for s in footprint.surfaces:
        outer = _turned(s.ring, 1.0)
        holes = tuple(_turned(h, -1.0) for h in s.holes)
        name = s.source_id
        top = np.array([0.0, 0.0, height])
        ground = tuple(h[::-1] for h in holes)
        surfaces.append(Surface(outer[::-1], "GroundSurface", f"{name}/ground", ground))
        surfaces.append(Surface(outer + top, "RoofSurface", f"{name}/roof", tuple(h + top for h in holes)))
        walls = (wall for ring in (outer, *holes) for wall in _walls(ring, top))
        surfaces += [Surface(w, "WallSurface", f"{name}/wall{k}") for k, w in enumerate(walls)]
    return Shell("1", tuple(surfaces), {}, True, footprint.part)


def _turned(ring: Float, sign: float) -> Float:
    """The ring (k, 3), counter-clockwise seen from above for sign 1, clockwise for sign -1."""
    x, y = (ring[:, :2] - ring[0, :2]).T
    area = np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
    return ring if area * sign > 0 else ring[::-1]


def _walls(ring: Float, top: Float) -> Iterator[Float]:
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        yield np.stack([a, b, b + top, a + top])
