"""The ground: carriageway, kerbs, pavements and the yards behind the building lines."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.simulate.meshing import Pen, triangulate
from frontage.simulate.scene import Part, SurfaceMaterial

KERB_M = 0.12  # height of the pavement above the gutter
_UNDER_WALLS_M = 0.1  # by which the ground reaches under the outer walls


@dataclass(frozen=True)
class StreetProfile:
    """The cross-section of a street between two building lines, d = 0 and d = -width.

    width      m, from building line to building line
    pavement   m, width of each pavement
    slope      rise along s, m per m
    """

    width: float
    pavement: float
    slope: float

    def height(self, s: float, d: float) -> float:
        """Return the height of the ground at (s, d), m."""
        depth, z = self._section
        return self.slope * s + float(np.interp(d, depth, z))

    def centre_line(self, s0: float, s1: float) -> Float:
        """Return points (k, 3) m, street frame, along the middle of the carriageway, at most 10 m apart."""
        d = -self.width / 2
        return np.array([[s, d, self.height(s, d)] for s in np.linspace(s0, s1, 2 + int((s1 - s0) // 10))])

    @property
    def _section(self) -> tuple[list[float], list[float]]:
        w, p = self.width, self.pavement
        low = -0.02 * p
        gutter, crown = low - KERB_M, low - KERB_M + 0.02 * (w / 2 - p)
        d = [-w - 60, -w, -w + p, -w + p + 0.001, -w / 2, -p - 0.001, -p, 0.0, 60.0]
        return d, [0.0, 0.0, low, gutter, crown, gutter, low, 0.0, 0.0]


def draw_ground(
    pen: Pen,
    profile: StreetProfile,
    span: tuple[float, float],
    houses: Sequence[shapely.Geometry],
    rng: np.random.Generator,
    *,
    behind: float = 40.0,
) -> None:
    """Draw the ground over a `span` of s (m) with a pen in the street's frame, except inside houses.

    `houses` are footprints in (s, d); the ground extends `behind` m beyond both building lines.
    """
    s0, s1 = span
    cellars = shapely.union_all([h.buffer(-_UNDER_WALLS_M, join_style="mitre") for h in houses])
    seed = [int(v) for v in rng.integers(2**31, size=4)]
    asphalt = SurfaceMaterial(
        "asphalt", "asphalt", (0.07, 0.07, 0.075), (0.11, 0.11, 0.11), 0.18, 0.0, seed=seed[0]
    )
    slab = float(rng.uniform(0.3, 0.5))
    paving = SurfaceMaterial(
        "paving", "paving", (0.32, 0.31, 0.29), (0.16, 0.15, 0.14), 0.35, 0.0, (slab, slab), seed[1]
    )
    kerb = SurfaceMaterial(
        "kerb", "stone", (0.42, 0.41, 0.40), (0.3, 0.3, 0.3), 0.45, 0.0, (1.0, 0.15), seed[2]
    )
    yard = SurfaceMaterial(
        "yard", "paving", (0.22, 0.24, 0.16), (0.14, 0.16, 0.10), 0.4, 0.0, (0.1, 0.1), seed[3]
    )
    w, p = profile.width, profile.pavement
    strips = (
        ("road", asphalt, -w + p + 0.001, -w / 2, 0.004), ("road", asphalt, -w / 2, -p - 0.001, 0.004),
        ("kerb", kerb, -p - 0.001, -p, 0.0), ("kerb", kerb, -w + p, -w + p + 0.001, 0.0),
        ("pavement", paving, -p, 0.0, 0.003), ("pavement", paving, -w, -w + p, 0.003),
        ("yard", yard, 0.0, behind, 0.01), ("yard", yard, -w - behind, -w, 0.01),
    )  # fmt: skip
    for k, (name, material, d0, d1, rough) in enumerate(strips):
        surface = pen.surface(f"{name}{k}", Part.GROUND, material, v=(0.0, 1.0, 0.0), roughness=rough)
        for piece in shapely.get_parts(shapely.box(s0, d0, s1, d1).difference(cellars)):
            _draw_piece(pen, surface, piece, profile)


def _draw_piece(pen: Pen, surface: int, piece: shapely.Polygon, profile: StreetProfile) -> None:
    rings = [np.asarray(r.coords)[:-1] for r in (piece.exterior, *piece.interiors)]
    plan, corners = triangulate(rings[0], rings[1:])
    z = np.array([profile.height(s, d) for s, d in plan])
    pen.triangles(surface, np.column_stack([plan, z]), corners)
