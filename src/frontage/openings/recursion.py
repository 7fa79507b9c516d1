"""Openings on the fronts of protrusions: an oriel's front is a wall of its own, with the same steps."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import shapely

from frontage.geometry.arrays import Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.model.estimate import Estimate, Failed
from frontage.model.facade import Facade
from frontage.model.opening import Elements, Opening, Protrusion
from frontage.model.scan import Scan
from frontage.openings.protrusion_kinds import is_wall

_ROOM = 3.0  # m around a front within which beams through its openings end
_COVERED = 0.5  # share of an opening that a front hides from the street

Finder = Callable[[Facade, Scan], Elements | Failed]


def openings_on_fronts(
    facade: Facade, scan: Scan, main: Sequence[Opening], protrusions: Sequence[Protrusion], find: Finder
) -> tuple[Opening, ...]:
    """The openings of the `main` wall, with those of the fronts in place of what these hide.

    `find` is the finder of the main wall, run on a facade of the front's own. Rings keep the facade's frame
    (the fronts are parallel to it), depths count from the front, `Opening.on` names it.
    """
    openings = list(main)
    walls = [p for p in protrusions if is_wall(p.kind)]
    q = facade.frame.inverse.apply(scan.xyz) if walls else np.empty((0, 3))
    for wall in walls:
        around = shapely.Polygon(wall.ring)
        openings = [o for o in openings if o.on or not is_hidden(o, around)]
        front, rows = own_facade(facade, wall, q)
        found = find(front, scan.take(rows))
        openings += [replace(o, on=wall.id) for o in found.openings] if isinstance(found, Elements) else []
    return tuple(openings)


def is_hidden(opening: Opening, front: shapely.Polygon) -> bool:
    """Whether most of an opening lies behind (or before) a front."""
    ring = shapely.make_valid(shapely.Polygon(opening.ring))
    return bool(shapely.intersection(ring, front).area > _COVERED * ring.area)


def own_facade(facade: Facade, wall: Protrusion, q: Float) -> tuple[Facade, Int]:
    """A facade whose plane is a protrusion's front, and the rows of the points q (n, 3) its beams end on;
    its support indexes these.
    """
    (x0, z0), (x1, z1) = wall.ring.min(0), wall.ring.max(0)
    y = float(wall.front.value)
    frame = facade.frame
    moved = Rigid3(frame.to, frame.frm, frame.R, frame.apply(np.array([[0.0, y, 0.0]]))[0])
    near = (q[:, 0] > x0 - _ROOM) & (q[:, 0] < x1 + _ROOM) & (q[:, 2] > z0 - _ROOM) & (q[:, 2] < z1 + _ROOM)
    rows = np.flatnonzero(near)
    own = q[rows]
    deep = (own[:, 1] > y - 0.5) & (own[:, 1] < y + 1.0)
    held = deep & (own[:, 0] >= x0) & (own[:, 0] <= x1) & (own[:, 2] >= z0) & (own[:, 2] <= z1)
    on = held & (np.abs(own[:, 1] - y) <= 3.0 * facade.roughness)
    pose = Estimate(moved, facade.local_from_facade.covariance, facade.local_from_facade.dof)
    return replace(
        facade,
        id=wall.id,
        local_from_facade=pose,
        outline=rectangle(float(x0), float(z0), float(x1), float(z1)),
        layers=(),
        support=np.flatnonzero(held),
        inliers=np.flatnonzero(on),
        curvature=(0.0, float("inf")),
        notes=(),
    ), rows
