"""The placement of a city model, decided once its CRS and its first coordinates are known."""

from dataclasses import replace

import numpy as np
from pyproj import CRS, Transformer

from frontage.errors import CrsError
from frontage.geometry.arrays import Float
from frontage.io import crs as systems
from frontage.io.axes import domain_of, is_formal, north_first
from frontage.io.crs import LARGEST_M
from frontage.io.placement import Placement, PlacementRequest
from frontage.io.transform import show, within
from frontage.model import WorldRef


class DeferredPlacement:
    """Converts file coordinates to local metres; it is decided by the first points that are converted.

    A reader passes on what the file states about its CRS as it comes across it. The order of the axes is part
    of the decision, because many files do not keep to the order of their CRS.

    name    the file, for messages
    world   the world of the run; None = decided from the file
    crs     the CRS of the file, over what the file states
    bounds  (x0, y0, x1, y1) or (x0, y0, z0, x1, y1, z1), m world, or None for everything
    """

    def __init__(
        self, name: str, world: WorldRef | None, crs: str | None, bounds: tuple[float, ...] | None
    ) -> None:
        self._name = name
        self._wanted = PlacementRequest(name, world, None if world is None else world.crs, crs)
        self._stated: str | None = None
        self._east_first = False
        self._domain: Float | None = None  # lowest and highest (2, 2) x and y that the CRS allows
        self._bounds = None if bounds is None else np.asarray(bounds, np.float64).reshape(2, -1)
        self._placement: Placement | None = None
        self._swap = False
        self._extent: Float | None = None  # lowest and highest corner (2, 3) m world of all that was seen
        self.notes: list[str] = []

    def state_crs(self, crs: str | None, east_first: bool = False) -> None:
        """Pass on the CRS that the file states; the first one counts. A local system ("#...") is ignored.

        `east_first`: the format puts east before north, whatever the authority of the CRS does.
        """
        self._east_first |= east_first
        if crs and not crs.startswith("#"):
            self._stated = self._stated or crs

    def state_anchor(self, crs: str | None, position: str) -> None:
        """Pass on the origin "x y z", in a CRS, of a local system; it counts where the world has a CRS."""
        values = np.array(position.split(), np.float64)
        local = self._wanted.world is not None and self._wanted.world.crs is None
        if crs and values.shape == (3,) and not local and self._wanted.crs is None:
            self._stated = self._stated or crs
            x, y, z = (float(v) for v in values)
            self._wanted = replace(self._wanted, offset=(x, y, z))

    @property
    def world(self) -> WorldRef | None:
        """The world of the local coordinates; None before it is decided."""
        return self._placement.world if self._placement else self._wanted.world

    @property
    def bounded(self) -> bool:
        """Whether only a part of the file is wanted."""
        return self._bounds is not None

    def to_local(self, points: Float) -> Float:
        """Convert file coordinates (n, 3), n > 0, to local metres. Raises CrsError."""
        if self._placement is None:
            self._decide(points)
        assert self._placement is not None
        ordered = points[:, [1, 0, 2]] if self._swap else points
        self._refuse_outside(ordered)
        return self._placement.to_local(ordered)

    def _refuse_outside(self, points: Float) -> None:
        """Raise CrsError for a point (n, 3), east first, that its CRS does not define."""
        if not (np.nan_to_num(np.abs(points[:, 2])) < LARGEST_M).all():
            raise CrsError(
                f"{self._name}: heights beyond {LARGEST_M:g} lie outside the domain of any CRS; correct them",
                code="I204",
            )
        if self._domain is None:
            return
        xy = points[:, :2] + self._wanted.offset[:2]
        outside = ((xy < self._domain[0]) | (xy > self._domain[1])).any(1)
        if outside.any():
            (x0, y0), (x1, y1) = self._domain
            raise CrsError(
                f"{self._name}: coordinates such as {show(points[outside][0])} lie outside the domain of "
                f"their CRS (x {x0:g} to {x1:g}, y {y0:g} to {y1:g}); correct them, or state the right crs",
                code="I204",
            )

    def touches(self, points: Float) -> bool:
        """Whether the bounding box of file coordinates (n, 3) meets the bounds; False without points."""
        if self._bounds is None:
            return True
        points = points[np.isfinite(points).all(1)]
        if not len(points):
            return False
        local = self.to_local(points)
        assert self.world is not None
        k = self._bounds.shape[1]
        box = self.world.to_world(np.stack([local.min(0), local.max(0)]))
        seen = np.concatenate([box, self._extent]) if self._extent is not None else box
        self._extent = np.stack([seen.min(0), seen.max(0)])
        return bool((box[0, :k] <= self._bounds[1]).all() and (box[1, :k] >= self._bounds[0]).all())

    def advice(self) -> str:
        """Where the buildings lie that were compared with the bounds, and what to do; "" without any."""
        if self._extent is None or self._bounds is None:
            return ""
        box, near = self._extent, self._bounds
        place = f"they lie at x {box[0, 0]:.0f} to {box[1, 0]:.0f}, y {box[0, 1]:.0f} to {box[1, 1]:.0f}"
        if _gap(box[:, :2], near[:, :2]) > 0.0 and _gap(box[:, [1, 0]], near[:, :2]) == 0.0:
            return f"{place}; x and y are swapped: write the file with east before north, or state its CRS"
        apart = _gap(box, near)
        if apart == 0.0:
            return f"{place}, all around the bounds: check the bounds"
        return f"{place}, {apart:.0f} m away: check the CRS of the model and of the scans"

    def _decide(self, points: Float) -> None:
        text = self._wanted.crs or self._stated
        crs = systems.parse_crs(text, self._name) if text else None
        meant = crs or (systems.parse_crs(self._wanted.target) if self._wanted.target else None)
        if meant is not None:
            self._swap = self._north_first(meant, text or "", points + self._wanted.offset)
        sample = points[:, [1, 0, 2]] if self._swap else points
        self._domain = domain_of(crs)
        self._refuse_outside(sample)
        self._placement = self._wanted.place(crs, sample)
        self.notes += self._placement.notes

    def _north_first(self, crs: CRS, text: str, points: Float) -> bool:
        """Whether north stands before east: as the CRS is named, unless only the other order fits."""
        if self._east_first and self._wanted.target is None:
            return False
        formal = is_formal(text) and not self._east_first and north_first(crs)
        turned = points[:, [1, 0, 2]]
        expected, other = (turned, points) if formal else (points, turned)
        if self._fits(crs, expected) or not self._fits(crs, other):
            return formal
        order = "east before north" if formal else "north before east"
        self.notes.append(
            f"{self._name}: coordinates such as {show(points[0])} fit {crs.name} only with {order}: "
            f"the axes were taken in that order"
        )
        return not formal

    def _fits(self, crs: CRS, points: Float) -> bool:
        """Whether points (n, 3) lie in the area of use of their CRS and of the world's."""
        if not within(crs, points):
            return False
        if self._wanted.target is None:
            return True
        target = systems.horizontal(systems.parse_crs(self._wanted.target))
        there = Transformer.from_crs(systems.horizontal(crs), target, always_xy=True)
        xy = np.column_stack(there.transform(points[:, 0], points[:, 1]))
        return within(target, np.column_stack([xy, np.zeros(len(xy))]))


def _gap(a: Float, b: Float) -> float:
    """The distance in m between two boxes (2, k), 0 where they meet."""
    k = min(a.shape[1], b.shape[1])
    a, b = a[:, :k], b[:, :k]
    return float(np.linalg.norm(np.maximum(0.0, np.maximum(a[0] - b[1], b[0] - a[1]))))
