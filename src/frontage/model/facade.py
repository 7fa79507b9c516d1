"""A facade: a plane with a frame, an outline and parallel layers."""

from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Float, Int, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model.estimate import Estimate
from frontage.model.world import WorldRef


@dataclass(frozen=True, eq=False)
class Layer:
    """A surface parallel to the facade plane: y m (positive = recess), sigma m, area m2, outline (k, 2) m."""

    y: float
    sigma: float
    area: float
    outline: Float

    def __post_init__(self) -> None:
        freeze(self, outline=((None, 2), np.float64))


@dataclass(frozen=True, eq=False)
class Facade:
    """A main facade of a building.

    id                 "B07/F1"
    building           "B07"
    local_from_facade  pose of the facade frame: X right as seen from the street, Y into the building,
                       Z up in the plane, origin = barycentre of the plane's inliers (paper A, eq. 2-4);
                       covariance (6, 6), translation m and rotation rad in the *facade* axes
    world              local -> world
    outline            (k, 2) m (x, z): polygon of the facade in its own frame
    layers             surfaces parallel to the plane, the wall itself (y = 0) among them
    support            (m,) int64 into the scan: points near the plane and within the outline, with balconies
                       and reveals; later stages work on them
    inliers            (k,) int64 into the scan: points *on* the plane
    roughness          m, robust standard deviation of the inliers about the plane
    spacing            m, median distance of neighbouring points on the wall
    coverage           share of the outline that has points on the wall, 0..1
    sigma_plane        m, standard error of the plane's offset at the barycentre
    oriented_by        "rays", "city model" or "evidence": what the street side was inferred from
    curvature          m, sagitta of a parabola fitted along x, and its sigma
    """

    id: str
    building: str
    local_from_facade: Estimate[Rigid3]
    world: WorldRef
    outline: Float
    layers: tuple[Layer, ...]
    support: Int
    inliers: Int
    roughness: float
    spacing: float
    coverage: float
    oriented_by: str
    curvature: tuple[float, float] = (0.0, float("inf"))
    notes: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        freeze(
            self, outline=((None, 2), np.float64), support=((None,), np.int64), inliers=((None,), np.int64)
        )

    def __repr__(self) -> str:
        """Say where it is and how well its plane is known."""
        x0, z0, x1, z1 = self.extent
        sigma = f"plane known to {self.sigma_plane * 1000:.2f} mm"
        return f"<Facade {self.id}: {x1 - x0:.1f} x {z1 - z0:.1f} m, {len(self.inliers):,} points, {sigma}>"

    def _repr_svg_(self) -> str:
        """Show the outline in a notebook, 20 px per metre."""
        x0, z0, x1, z1 = self.extent
        corners = " ".join(f"{20 * (x - x0):.1f},{20 * (z1 - z):.1f}" for x, z in self.outline)
        shape = f'<polygon points="{corners}" fill="#e8e4da" stroke="#555"/>'
        size = f'width="{20 * (x1 - x0):.0f}" height="{20 * (z1 - z0):.0f}"'
        return f'<svg xmlns="http://www.w3.org/2000/svg" {size}><title>{self.id}</title>{shape}</svg>'

    @property
    def frame(self) -> Rigid3:
        """`local_from_facade` without its covariance."""
        return self.local_from_facade.value

    @property
    def sigma_plane(self) -> float:
        """Standard error of the plane's offset at the barycentre, m."""
        return float(self.local_from_facade.sigma[1])

    @property
    def height_of_zero(self) -> float:
        """Height in m, above the datum of the CRS, of z = 0 of the facade frame."""
        return float(self.world.to_world(self.frame.t)[2])

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """x0, z0, x1, z1 in m: the bounding box of the outline."""
        (x0, z0), (x1, z1) = self.outline.min(0), self.outline.max(0)
        return float(x0), float(z0), float(x1), float(z1)
