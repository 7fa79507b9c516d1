"""Interiors: walls that were measured through the openings of a larger facade."""

import numpy as np

from frontage.facades.cloud import Cloud
from frontage.facades.front import Front, some_of
from frontage.facades.street import seen_through
from frontage.geometry.arrays import Int
from frontage.model.scan import Scan

_SEEN_THROUGH = 0.5  # share of a wall's points measured through another facade that makes it an interior
_LEAK = 0.15  # share of the chance crossings of shut cells that an interior may still have (curtains, frames)
_GRAZING = 0.25  # sine of the angle (15 degrees) below which a surface returns nothing
_SIGHTS = 500  # lines of sight per plausible place


def drop_interiors(fronts: list[Front], scan: Scan, cloud: Cloud, rng: np.random.Generator) -> list[Front]:
    """Leave out walls most of whose points were seen through the openings of a larger facade."""
    kept = []
    for inner in fronts:
        some = some_of(inner.wall.inliers, rng)
        larger = (f for f in fronts if f.cells.area > inner.cells.area)
        if not any(_behind(outer, inner, some, scan, cloud) for outer in larger):
            kept.append(inner)
    return kept


def _behind(outer: Front, inner: Front, rows: Int, scan: Scan, cloud: Cloud) -> bool:
    """Whether `inner`, with the points `rows` of the cloud, is an interior behind `outer`.

    Without rays: from some plausible place in front of `outer` most of them are seen,
    not edge-on, through the holes of `outer` and hardly any through what is shut.
    """
    wall, xyz = outer.wall, cloud.xyz[rows]
    if outer.side.told_by == "rays":
        return seen_through(wall, outer.cells, xyz, scan.sensor_of(cloud.index[rows]))[0] > _SEEN_THROUGH
    shut = float(outer.cells.shut.sum() / max(outer.cells.whole.sum(), 1))
    for place in outer.side.sensors @ wall.axes.T + wall.point:
        sight = place - inner.wall.point
        if abs(sight @ inner.wall.normal) < _GRAZING * np.linalg.norm(sight):
            continue
        some = xyz[:: max(1, len(xyz) // _SIGHTS)]
        inside, closed = seen_through(wall, outer.cells, some, place[None], 0.5)
        if inside > _SEEN_THROUGH and closed < _LEAK * inside * shut:
            return True
    return False
