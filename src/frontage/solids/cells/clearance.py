"""How deep may a relief go before it meets another face of the solid?"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float
from frontage.model import Solid
from frontage.solids.hosts.walls import Wall
from frontage.solids.relief import GRID
from frontage.solids.rims import normal, rings_of

_HALVINGS = 12


@dataclass(frozen=True, eq=False)
class Clearance:
    """The faces beside a wall in its own axes, 0.1 mm: rings with the outer one first, boxes (f, 2, 3)."""

    faces: tuple[tuple[Float, ...], ...]
    boxes: Float
    gap: float

    @classmethod
    def of(cls, solid: Solid, wall: Wall, gap: float) -> "Clearance":
        """All faces but the wall's own and the ground at its foot."""
        local = wall.local_from_wall.inverse.apply(solid.vertices / GRID) * GRID
        skipped = {*wall.faces, *wall.ground.values()}
        own = [f for k, f in enumerate(solid.faces) if k not in skipped]
        faces = tuple(tuple(local[list(r)] for r in rings_of(f)) for f in own)
        boxes = np.array([[f[0].min(0), f[0].max(0)] for f in faces]).reshape(-1, 2, 3)
        return cls(faces, boxes, gap * GRID)

    def free(self, polygon: Polygon, height: int) -> int:
        """The part of a height (0.1 mm, either sign) that a relief may use, the gap kept; 0: none."""
        if height == 0:
            return 0
        shape = polygon.buffer(self.gap / 2, join_style="mitre")
        sign = 1 if height > 0 else -1
        close = self._close(shape, height + sign * self.gap)
        if not self._meets(close, shape, height + sign * self.gap):
            return height
        low, high = 0.0, float(abs(height))
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            hit = self._meets(close, shape, sign * (middle + self.gap))
            low, high = (low, middle) if hit else (middle, high)
        return int(sign * low)

    def _close(self, shape: Polygon, reach: float) -> Sequence[int]:
        x0, z0, x1, z1 = shape.bounds
        low = np.array([x0, min(0.0, reach), z0])
        high = np.array([x1, max(0.0, reach), z1])
        return np.nonzero(((self.boxes[:, 0] <= high) & (self.boxes[:, 1] >= low)).all(1))[0].tolist()

    def _meets(self, faces: Sequence[int], shape: Polygon, reach: float) -> bool:
        ends = sorted((np.sign(reach), reach))
        return any(_shadow(self.faces[k], *ends).intersects(shape) for k in faces)


def _shadow(rings: Sequence[Float], near: float, far: float) -> BaseGeometry:
    """The part of a face with ``near <= y <= far``, seen along y: a polygon, or lines where edge on."""
    ring = rings[0]
    n = normal(ring)
    axis = int(np.argmax(np.abs(n)))
    keep = [k for k in range(3) if k != axis]
    flat = shapely.make_valid(Polygon(ring[:, keep], [r[:, keep] for r in rings[1:]]))
    origin = ring.mean(0)

    def lifted(uv: Float) -> Float:
        full = np.zeros((len(uv), 3))
        full[:, keep] = uv
        full[:, axis] = origin[axis] - (uv - origin[keep]) @ n[keep] / n[axis]
        return full

    corners = lifted(np.array(shapely.get_coordinates(shapely.box(*flat.bounds))[:-1]))
    if corners[:, 1].min() < near or corners[:, 1].max() > far:
        slope = -n[keep] / n[1] if axis == 1 else np.array([float(k == 1) for k in keep])
        flat = _band(flat, slope, float(origin[1] - slope @ origin[keep]), near, far)
    seen = shapely.transform(flat, lambda uv: lifted(uv)[:, [0, 2]])
    if axis == 1:
        return seen
    border = shapely.transform(flat.boundary, lambda uv: lifted(uv)[:, [0, 2]])  # edge on: no area is left
    return shapely.union(border.buffer(0.5), shapely.make_valid(seen).buffer(0))


def _band(flat: BaseGeometry, slope: Float, constant: float, near: float, far: float) -> BaseGeometry:
    """The part of a polygon where ``near <= constant + slope . uv <= far``."""
    steep = float(np.linalg.norm(slope))
    if steep < 1e-9:
        return flat if near <= constant <= far else Polygon()
    along = slope / steep
    across = np.array([-along[1], along[0]])
    size = 2 * float(np.abs(shapely.get_coordinates(flat)).max()) + 1.0
    a, b = (near - constant) / steep, (far - constant) / steep
    sides = (size * across, -size * across)
    strip = Polygon([a * along + sides[1], b * along + sides[1], b * along + sides[0], a * along + sides[0]])
    return flat.intersection(strip).buffer(0)
