"""A facade in plan: a directed line with the building on one side, and the heights of foot and eaves."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from shapely.geometry import Polygon

from frontage.geometry.arrays import Float
from frontage.geometry.ring import at_depth
from frontage.model import Facade

_COLUMNS = 100  # at which the lower border of an outline is looked up


@dataclass(eq=False)
class PlanFacade:
    """A facade in plan, in metres of the local frame; its ends move to the corners of the building.

    ends               (2, 2) from left to right as seen from the street
    inward             unit vector (2,) into the building
    low, high          heights of its foot and its eaves
    foot               height of the lower border that was measured: the ceiling of an arcade under it
    held               the rectangle that holds its openings: positions (m) along the facade and heights,
                       from left, low to right, high; None without openings
    eaves              (k, 2): position along the facade, height
    corner_neighbours  facades that meet it at an outer corner
    """

    ends: Float
    inward: Float
    low: float = 0.0
    high: float = 1.0
    foot: float = 0.0
    held: tuple[float, float, float, float] | None = None
    eaves: Float = field(default_factory=lambda: np.zeros((0, 2)))
    corner_neighbours: list["PlanFacade"] = field(default_factory=list)

    @classmethod
    def of(cls, facade: Facade, outline: Float, openings: Sequence[Float] = ()) -> "PlanFacade":
        """Returns a facade in plan, between the foot and the eaves of its clean outline (k, 2) m (x, z).

        `openings` are the rings (k, 2) m (x, z) of what was found on it.
        """
        corners = facade.frame.apply(np.insert(outline, 1, 0.0, axis=1))
        ends = np.array([[outline[:, 0].min(), 0, 0], [outline[:, 0].max(), 0, 0]])
        inward = facade.frame.R[:2, 1] / np.linalg.norm(facade.frame.R[:2, 1])
        low, high = float(corners[:, 2].min()), float(corners[:, 2].max())
        foot = float(facade.frame.t[2] + facade.frame.R[2, 2] * lower_border(facade.outline))
        made = cls(facade.frame.apply(ends)[:, :2], inward, low, high, foot)
        if len(openings):
            held = facade.frame.apply(at_depth(np.concatenate(openings), 0.0))
            flat = np.column_stack([(held[:, :2] - made.ends[0]) @ made.along, held[:, 2]])
            made.held = (*flat.min(0).tolist(), *flat.max(0).tolist())
        made.eaves = np.column_stack([corners[2:, :2] @ made.along, corners[2:, 2]])[::-1]
        return made

    @property
    def along(self) -> Float:
        """The unit vector (2,) from its left to its right end."""
        return np.array([self.inward[1], -self.inward[0]])

    @property
    def length(self) -> float:
        """The distance between its ends, m."""
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))

    def depth_of(self, points: Float) -> Float:
        """Returns how far behind its plane points (k, 2) lie, m."""
        return np.asarray((points - self.ends[0]) @ self.inward, np.float64)

    def strip(self, left: float, right: float, depth: float) -> Polygon:
        """Returns the rectangle from its plane to `depth` m behind it, between two positions (m) along it.

        A negative depth gives the rectangle in front of it.
        """
        a, b = (self.ends[0] + s * self.along for s in (left, right))
        return Polygon([a, b, b + depth * self.inward, a + depth * self.inward])

    def own_strip(self, depth: float) -> Polygon:
        """Returns the strip over its own length."""
        return self.strip(0.0, self.length, depth)


def lower_border(outline: Float) -> float:
    """Returns the median height (m) of the lower border of an outline (k, 2) m (x, z).

    Piers, and a ragged edge below the ceiling of an arcade, hardly change the median.
    """
    polygon = shapely.make_valid(Polygon(outline))
    x0, low, x1, high = polygon.bounds
    x = np.linspace(x0, x1, _COLUMNS + 2)[1:-1]
    columns = shapely.linestrings([[(v, low - 1.0), (v, high + 1.0)] for v in x])
    return float(np.nanmedian(shapely.bounds(shapely.intersection(columns, polygon))[:, 1]))


def cross2d(a: Float, b: Float) -> float:
    """Returns the cross product of two vectors (2,); for unit vectors the sine of the angle from a to b."""
    return float(a[0] * b[1] - a[1] * b[0])
