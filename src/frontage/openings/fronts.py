"""Openings on the fronts of protrusions: the front of an oriel is a wall of its own.

Paper B (section 3.2.3, figure 10) searches protrusions recursively, by the same steps as the facade.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import shapely

from frontage.geometry.arrays import Float, Int, rising
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import polygon_ring, rectangle
from frontage.model.canonical import canonical_order, steady
from frontage.model.estimate import Estimate
from frontage.model.facade import Facade
from frontage.model.opening import Opening, Protrusion
from frontage.model.scan import Scan
from frontage.openings.boxes import Box

_ROOM = 3.0  # m around a front within which the beams through its openings end
_MOSTLY = 0.8  # share of a front that lies in the outline of its facade, where that bounds the front
_BEHIND = 0.8  # share of an opening that lies behind a front, where it is seen through windows of the front
_COVERED = 0.5  # share of an opening that a front must hide from the street
_CELL, _MOST_CELLS = 2.0, 20  # spacings of the cells that tell how much of it a front fills, and their number

Finder = Callable[[Facade, Scan], tuple[Opening, ...]]


@dataclass(frozen=True, eq=False)
class FrontSearch:
    """Searches the fronts of a facade's protrusions, each once.

    find  the search of one wall: takes a facade and its working cloud, returns the openings
    """

    facade: Facade
    scan: Scan
    find: Finder
    _searched: dict[tuple[float, ...], tuple[Opening, ...]] = field(default_factory=dict)

    @cached_property
    def q(self) -> Float:
        """The points of the scan (n, 3) m in the facade frame."""
        return steady(self.facade.frame.inverse.apply(self.scan.xyz))

    @cached_property
    def _along(self) -> tuple[Float, Int]:
        """The x coordinates (n,) m of the points in rising order, and the rows of these points in `q`."""
        order = rising(self.q[:, 0])
        return self.q[order, 0], order

    def rows_within(self, box: Box) -> Int:
        """Returns the rows (k,) of the points in `q` whose x and z lie within a box, in rising order."""
        x, rows = self._along
        some = np.sort(rows[x.searchsorted(box[0], "right") : x.searchsorted(box[2])])
        z = self.q[some, 2]
        return np.asarray(some[(z > box[1]) & (z < box[3])])

    def openings(self, wall: Protrusion) -> tuple[Opening, ...]:
        """Returns the openings on a front.

        Rings are in the frame of the facade, which fronts are parallel to; depths count from the front.
        """
        key = (*wall.ring.ravel().tolist(), float(wall.front.value))
        if key not in self._searched:
            (x0, z0), (x1, z1) = wall.ring.min(0) - _ROOM, wall.ring.max(0) + _ROOM
            front, rows = _own_facade(self.facade, wall, self.q, self.rows_within((x0, z0, x1, z1)))
            self._searched[key] = self.find(front, self.scan.take(rows))
        return self._searched[key]

    def hides(self, wall: Protrusion, opening: Opening) -> bool:
        """Returns whether an opening of the main wall is hidden by a front, or seen through its windows only.

        An opening that lies mostly beside the front stays, and so does one that reaches beyond the front and
        that no points of the front fill.
        """
        around = shapely.Polygon(wall.ring)
        if not is_hidden(opening, around) or is_hidden(opening, around, _BEHIND):
            return is_hidden(opening, around)
        low, high = opening.ring.min(0), opening.ring.max(0)
        x, y, z = self.q[self.rows_within((*low, *high))].T
        near = np.abs(y - float(wall.front.value)) <= 3.0 * self.facade.roughness
        x, z = x[near], z[near]
        bins = np.clip((high - low) / (_CELL * self.facade.spacing), 1, _MOST_CELLS).astype(int)
        shown = np.histogram2d(x, z, bins.tolist(), [[low[0], high[0]], [low[1], high[1]]])[0] > 0
        return float(shown.mean()) > _COVERED


def openings_on_fronts(
    main: Sequence[Opening], protrusions: Sequence[Protrusion], fronts: FrontSearch
) -> list[Opening]:
    """Returns the openings of the `main` wall, with those of the fronts in place of what these hide.

    `Opening.on` names the front. The foremost front comes last, for it hides what lies behind it: what seems
    to be there was seen through its openings. An opening that reaches beyond a front stays where the front
    does not fill it and has no opening there. The openings of a niche replace the opening that it was taken
    for.
    """
    openings = list(main)
    for wall in sorted((p for p in protrusions if p.kind.is_wall), key=lambda p: -float(p.front.value)):
        around, own = shapely.Polygon(wall.ring), fronts.openings(wall)
        if wall.front.value < 0.0:
            openings = [o for o in openings if not any(_overlap(o, fore) for fore in own)]
            openings = [o for o in openings if not fronts.hides(wall, o)]
        else:
            openings = [o for o in openings if not is_hidden(o, around)]
        openings += [replace(o, on=wall.id) for o in own]
    return openings


def _overlap(a: Opening, b: Opening) -> bool:
    """Returns whether two openings have an area in common as seen from the street."""
    one, other = (shapely.make_valid(shapely.Polygon(o.ring)) for o in (a, b))
    return bool(shapely.relate_pattern(one, other, "T********"))


def is_hidden(opening: Opening, front: shapely.Polygon, share: float = _COVERED) -> bool:
    """Returns whether more than a `share` of an opening lies behind (or before) a front."""
    ring = shapely.make_valid(shapely.Polygon(opening.ring))
    return bool(shapely.intersection(ring, front).area > share * ring.area)


def _own_facade(facade: Facade, wall: Protrusion, q: Float, near: Int) -> tuple[Facade, Int]:
    """Makes a facade whose plane is the front of a protrusion.

    The beams through the front end on those points of q (n, 3) m whose rows (k,) are `near`. Returns the
    facade with these rows in canonical order; its support indexes them.
    """
    (x0, z0), (x1, z1) = wall.ring.min(0), wall.ring.max(0)
    y = float(wall.front.value)
    frame = facade.frame
    moved = Rigid3(frame.to, frame.frm, frame.R, frame.apply(np.array([[0.0, y, 0.0]]))[0])
    rows = near[canonical_order(q[near])]
    own = q[rows]
    deep = (own[:, 1] > y - 0.5) & (own[:, 1] < y + 1.0)
    held = deep & (own[:, 0] >= x0) & (own[:, 0] <= x1) & (own[:, 2] >= z0) & (own[:, 2] <= z1)
    on = held & (np.abs(own[:, 1] - y) <= 3.0 * facade.roughness)
    if on.any():  # without slanting cheeks and roofs
        (x0, z0), (x1, z1) = own[on][:, [0, 2]].min(0), own[on][:, [0, 2]].max(0)
        held &= (own[:, 0] >= x0) & (own[:, 0] <= x1) & (own[:, 2] >= z0) & (own[:, 2] <= z1)
    pose = Estimate(moved, facade.local_from_facade.covariance, facade.local_from_facade.dof)
    return replace(
        facade,
        id=wall.id,
        local_from_facade=pose,
        outline=_common(rectangle(float(x0), float(z0), float(x1), float(z1)), facade.outline),
        layers=(),
        support=np.flatnonzero(held),
        inliers=np.flatnonzero(on),
        curvature=(0.0, float("inf")),
        notes=(),
    ), rows


def _common(ring: Float, outline: Float) -> Float:
    """Returns the part of a front's ring (k, 2) m within the outline (n, 2) m of its facade.

    Capitals below an entablature widen its rectangle into the air between them. Where the outline has a gap
    behind a front, as it may behind a wide bay, the whole ring is returned.
    """
    front, around = shapely.Polygon(ring), shapely.make_valid(shapely.Polygon(outline))
    largest = max(shapely.get_parts(shapely.intersection(front, around)), key=shapely.area, default=front)
    return polygon_ring(largest) if largest.area > _MOSTLY * front.area else ring
