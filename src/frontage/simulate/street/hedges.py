"""Hedges in front of houses that are set back from the street, with gaps at the doors."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import DOORS
from frontage.simulate.meshing import Pen
from frontage.simulate.scene import House, Part, SurfaceMaterial

LEAST_SETBACK_M = 1.5  # depth of the smallest front garden
_GAP_M = 0.35  # by which a path is wider than its door, on each side


@dataclass(frozen=True)
class PlotFront:
    """The street side of a plot: from s0 to s1 m, ground heights z0 and z1 at both ends.

    entrances   spans (m) of s that lead to doors, gates and garages
    """

    s0: float
    s1: float
    z0: float
    z1: float
    entrances: tuple[tuple[float, float], ...]

    def height(self, s: Float) -> Float:
        """Return the height (n,) m of the ground at s (n,) m."""
        return self.z0 + (self.z1 - self.z0) * (s - self.s0) / (self.s1 - self.s0)

    @property
    def runs(self) -> list[tuple[float, float]]:
        """The spans between the entrances that are longer than half a metre."""
        starts = [self.s0, *(b for _, b in sorted(self.entrances))]
        ends = [*(a for a, _ in sorted(self.entrances)), self.s1]
        return [(a, b) for a, b in zip(starts, ends, strict=True) if b - a > 0.5]


def entrance_spans(house: House) -> list[tuple[float, float]]:
    """Return the spans of x (m, front's frame) that lead to the ground floor's doors, gates and garages."""
    doors = [o for o in house.facades[0].openings if o.floor == 0 and o.kind in DOORS]
    return [(float(o.ring[:, 0].min()) - _GAP_M, float(o.ring[:, 0].max()) + _GAP_M) for o in doors]


def draw_hedge(pen: Pen, front: PlotFront, line: float, towards: float, rng: np.random.Generator) -> None:
    """Draw a hedge just behind the building line (d = `line`) with a pen in the street's frame.

    `towards` is 1 or -1, the direction of d in which the house lies. A hedge consists of loose leaves, more
    densely than a tree.
    """
    thick = float(rng.uniform(0.4, 0.7))
    d = line + towards * (0.1 + thick / 2)
    green = float(rng.uniform(0.07, 0.13))
    leaf = SurfaceMaterial("hedge", "leaves", (green * 0.55, green, green * 0.3), (0.12, 0.16, 0.06), 0.5)
    high = float(rng.uniform(0.9, 1.5))
    surface = pen.surface("leaves", Part.TREE, leaf)
    for a, b in front.runs:
        count = int(1500 * (b - a) * high)
        at = rng.uniform((a, d - thick / 2, 0.03), (b, d + thick / 2, high), (count, 3))
        at[:, 2] += front.height(at[:, 0])
        u = rng.normal(size=(count, 3))
        u *= 0.035 / np.linalg.norm(u, axis=1, keepdims=True)
        v = np.cross(u, rng.normal(size=(count, 3)))
        v *= 0.022 / np.linalg.norm(v, axis=1, keepdims=True)
        xyz = np.stack([at - u, at - v, at + u, at + v], axis=1).reshape(-1, 3)
        first = 4 * np.arange(count)[:, None]
        corners = np.concatenate([first + np.array([0, 1, 2]), first + np.array([0, 2, 3])])
        pen.triangles(surface, xyz, corners)
