"""Measures how deep a relief may go before it meets another face of the solid."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float
from frontage.model import Solid
from frontage.solids.brep import GRID_PER_M, newell_normal, rings_of
from frontage.solids.walls import HostWall

_HALVINGS = 12  # of the bisection for the free depth
_EDGE_ON_BUFFER = 0.5  # 0.1 mm that the border of a face seen edge on is widened by
_PARALLEL_SLOPE = 1e-9  # a face whose y changes less than this over its own plane lies at one depth


@dataclass(frozen=True, eq=False)
class Clearance:
    """The faces around a wall, in 0.1 mm of the wall frame.

    faces  rings (k, 3) of every face, the outer one first
    boxes  bounding boxes (f, 2, 3)
    gap    distance to keep from them
    """

    faces: tuple[tuple[Float, ...], ...]
    boxes: Float
    gap: float

    @classmethod
    def of(cls, solid: Solid, wall: HostWall, gap: float) -> "Clearance":
        """Takes all faces of a solid but the wall's own and the ground at its foot; `gap` in 0.1 mm."""
        in_wall = wall.local_from_wall.inverse.apply(solid.vertices / GRID_PER_M) * GRID_PER_M
        skipped = {*wall.faces, *wall.ground.values()}
        own = [f for k, f in enumerate(solid.faces) if k not in skipped]
        faces = tuple(tuple(in_wall[list(r)] for r in rings_of(f)) for f in own)
        boxes = np.array([[f[0].min(0), f[0].max(0)] for f in faces]).reshape(-1, 2, 3)
        return cls(faces, boxes, gap)

    def free_height(self, polygon: Polygon, height: int) -> int:
        """Returns the part of a height (0.1 mm, either sign) that a relief may use; 0 if there is no room."""
        if height == 0:
            return 0
        shape = polygon.buffer(self.gap / 2, join_style="mitre")
        sign = 1 if height > 0 else -1
        close = self._faces_near(shape, height + sign * self.gap)
        if not self._meets(close, shape, height + sign * self.gap):
            return height
        low, high = 0.0, float(abs(height))
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            hit = self._meets(close, shape, sign * (middle + self.gap))
            low, high = (low, middle) if hit else (middle, high)
        return int(sign * low)

    def _faces_near(self, shape: Polygon, reach: float) -> Sequence[int]:
        """Returns the faces whose boxes meet that of a shape extruded from the wall to y = `reach`."""
        x0, z0, x1, z1 = shape.bounds
        low = np.array([x0, min(0.0, reach), z0])
        high = np.array([x1, max(0.0, reach), z1])
        return np.nonzero(((self.boxes[:, 0] <= high) & (self.boxes[:, 1] >= low)).all(1))[0].tolist()

    def _meets(self, faces: Sequence[int], shape: Polygon, reach: float) -> bool:
        """Decides whether a shape extruded from the wall to y = `reach` meets one of the faces."""
        ends = sorted((np.sign(reach), reach))
        return any(_slice_along_y(self.faces[k], *ends).intersects(shape) for k in faces)


def _slice_along_y(rings: Sequence[Float], near: float, far: float) -> BaseGeometry:
    """Returns the part of a face with ``near <= y <= far``, projected along y.

    A face seen edge on gives its widened border, because no area is left of it.
    """
    ring = rings[0]
    n = newell_normal(ring)
    axis = int(np.argmax(np.abs(n)))
    keep = [k for k in range(3) if k != axis]
    flat = shapely.make_valid(Polygon(ring[:, keep], [r[:, keep] for r in rings[1:]]))
    origin = ring.mean(0)

    def lifted(uv: Float) -> Float:
        """Returns points (k, 2) of the dropped-axis plane on the face's plane (k, 3)."""
        full = np.zeros((len(uv), 3))
        full[:, keep] = uv
        full[:, axis] = origin[axis] - (uv - origin[keep]) @ n[keep] / n[axis]
        return full

    corners = lifted(np.array(shapely.get_coordinates(shapely.box(*flat.bounds))[:-1]))
    if corners[:, 1].min() < near or corners[:, 1].max() > far:
        slope = -n[keep] / n[1] if axis == 1 else np.array([float(k == 1) for k in keep])
        flat = _band(flat, slope, float(origin[1] - slope @ origin[keep]), near, far)
    projected = shapely.transform(flat, lambda uv: lifted(uv)[:, [0, 2]])
    if axis == 1:
        return projected
    border = shapely.transform(flat.boundary, lambda uv: lifted(uv)[:, [0, 2]])
    return shapely.union(border.buffer(_EDGE_ON_BUFFER), shapely.make_valid(projected).buffer(0))


def _band(flat: BaseGeometry, slope: Float, constant: float, near: float, far: float) -> BaseGeometry:
    """Returns the part of a polygon where ``near <= constant + slope . uv <= far``."""
    steep = float(np.linalg.norm(slope))
    if steep < _PARALLEL_SLOPE:
        return flat if near <= constant <= far else Polygon()
    along = slope / steep
    across = np.array([-along[1], along[0]])
    size = 2 * float(np.abs(shapely.get_coordinates(flat)).max()) + 1.0
    a, b = (near - constant) / steep, (far - constant) / steep
    sides = (size * across, -size * across)
    strip = Polygon([a * along + sides[1], b * along + sides[1], b * along + sides[0], a * along + sides[0]])
    return flat.intersection(strip).buffer(0)
