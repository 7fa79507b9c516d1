"""Makes triangles from outlines: plates with holes, extrusions, boxes and lofts, each in its own frame."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from frontage.geometry.arrays import Array, Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import at_depth
from frontage.simulate.scene import Part, SceneMesh, SceneSurface, SurfaceMaterial


class MeshBuilder:
    """Collects the materials, surfaces and triangles of a scene."""

    def __init__(self) -> None:
        self.materials: dict[SurfaceMaterial, int] = {}
        self.surfaces: list[SceneSurface] = []
        self._vertices: list[Float] = []
        self._corners: list[Int] = []
        self._surface: list[Array] = []
        self._count = 0

    def material(self, material: SurfaceMaterial) -> int:
        """Return the index of a material; equal materials are stored once."""
        return self.materials.setdefault(material, len(self.materials))

    def surface(self, surface: SceneSurface) -> int:
        """Register a surface and return its index."""
        self.surfaces.append(surface)
        return len(self.surfaces) - 1

    def add(self, vertices: Float, corners: Int, surface: int) -> None:
        """Add triangles: vertices (v, 3) m local, corners (t, 3) into them."""
        self._vertices.append(np.asarray(vertices, np.float64))
        self._corners.append(np.asarray(corners, np.int64) + self._count)
        self._surface.append(np.full(len(corners), surface, np.int32))
        self._count += len(vertices)

    def mesh(self) -> SceneMesh:
        """Return the mesh of everything that was added so far."""
        if not self._vertices:
            return SceneMesh(np.zeros((0, 3)), np.zeros((0, 3), np.int64), np.zeros(0, np.int32))
        parts = (np.concatenate(a) for a in (self._vertices, self._corners, self._surface))
        return SceneMesh(*parts)


@dataclass(frozen=True)
class Pen:
    """Adds shapes to a mesh builder, given in one frame (x right, y into the wall, z up).

    `prefix` begins the ids of the surfaces that it registers; house, facade and opening are the indices of
    what these surfaces belong to, -1 = none.
    """

    builder: MeshBuilder
    local_from_frame: Rigid3
    prefix: str = ""
    house: int = -1
    facade: int = -1
    opening: int = -1

    def with_prefix(self, prefix: str, *, facade: int | None = None, opening: int | None = None) -> "Pen":
        """Return the same pen with another prefix and, if given, another facade and opening."""
        return replace(
            self,
            prefix=prefix,
            facade=self.facade if facade is None else facade,
            opening=self.opening if opening is None else opening,
        )

    def in_frame(self, local_from_frame: Rigid3) -> "Pen":
        """Return the same pen for shapes given in another frame."""
        return replace(self, local_from_frame=local_from_frame)

    def surface(
        self,
        name: str,
        part: Part,
        material: SurfaceMaterial,
        *,
        u: tuple[float, float, float] = (1.0, 0.0, 0.0),
        v: tuple[float, float, float] = (0.0, 0.0, 1.0),
        roughness: float = 0.0,
        correlation: float = 0.3,
    ) -> int:
        """Register the surface "prefix/name" with texture axes u and v in this frame; return its index."""
        frame = self.local_from_frame
        origin, axes = frame.t, frame.rotate(np.array([u, v], float))
        surface = SceneSurface(
            f"{self.prefix}/{name}" if self.prefix else name,
            part,
            self.builder.material(material),
            self.house,
            self.facade,
            self.opening,
            (float(origin[0]), float(origin[1]), float(origin[2])),
            (float(axes[0, 0]), float(axes[0, 1]), float(axes[0, 2])),
            (float(axes[1, 0]), float(axes[1, 1]), float(axes[1, 2])),
            roughness,
            correlation,
        )
        return self.builder.surface(surface)

    def triangles(self, surface: int, xyz: Float, corners: Int) -> None:
        """Add triangles: vertices (v, 3) m in this frame, corners (t, 3) into them."""
        self.builder.add(self.local_from_frame.apply(xyz), corners, surface)

    def plate(
        self, surface: int, ring: Float, y: float, holes: Sequence[Float] = (), inward: bool = False
    ) -> None:
        """Add a polygon in the plane at `y`, facing the street or, if `inward`, the inside of the house."""
        xz, corners = triangulate(ring, holes)
        xyz = at_depth(xz, y)
        self.triangles(surface, xyz, corners[:, ::-1] if inward else corners)

    def strip(self, surface: int, ring: Float, y0: float, y1: float, outward: bool = False) -> None:
        """Add the side faces of a ring from y0 to y1 > y0, facing its middle (a reveal) or `outward`."""
        near = at_depth(ring, y0)
        far = near + np.array([0.0, y1 - y0, 0.0])
        xyz, corners = band(near, far)
        self.triangles(surface, xyz, corners[:, ::-1] if outward else corners)

    def block(
        self,
        surface: int,
        ring: Float,
        y0: float,
        y1: float,
        *,
        holes: Sequence[Float] = (),
        back: bool = True,
    ) -> None:
        """Add a solid with a ring's outline between y0 and y1, without its `back` where that is hidden."""
        self.plate(surface, ring, y0, holes)
        self.strip(surface, ring, y0, y1, outward=True)
        for hole in holes:
            self.strip(surface, hole, y0, y1)
        if back:
            self.plate(surface, ring, y1, holes, inward=True)

    def box(self, surface: int, low: Sequence[float], high: Sequence[float], inward: bool = False) -> None:
        """Add an upright box between two corners, with faces that point outwards or, if `inward`, inwards."""
        corner = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)], float)
        xyz = np.asarray(low) + corner * (np.asarray(high, float) - np.asarray(low, float))
        self.triangles(surface, xyz, _BOX[:, ::-1] if inward else _BOX)

    def polygon(self, surface: int, ring: Float) -> None:
        """Add a planar polygon (k, 3) without holes, counter-clockwise as seen from outside."""
        self.triangles(surface, ring, fan(ring))


_QUADS = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
_BOX = np.concatenate([_QUADS[:, [0, 1, 2]], _QUADS[:, [0, 2, 3]]])


def band(near: Float, far: Float) -> tuple[Float, Int]:
    """Connect two closed rings (k, 3) of the same length: vertices (2 k, 3), corners (2 k, 3)."""
    k = len(near)
    a = np.arange(k)
    b = (a + 1) % k
    corners = np.concatenate([np.column_stack([a, b, b + k]), np.column_stack([a, b + k, a + k])])
    return np.concatenate([near, far]), corners


def triangulate(ring: Float, holes: Sequence[Float] = ()) -> tuple[Float, Int]:
    """Triangulate a polygon: vertices (v, 2), corners (t, 3) counter-clockwise (constrained Delaunay).

    No vertex is added, so that neighbouring surfaces that share a ring meet without gaps.

    Raises ValueError when rings touch or cross.
    """
    if len(holes) == 0 and len(ring) <= 4 and (quick := _convex(np.asarray(ring, np.float64))) is not None:
        return np.asarray(ring, np.float64), quick
    polygon = shapely.Polygon(ring, [np.asarray(h) for h in holes])
    if not polygon.is_valid:
        raise ValueError(f"polygon to be triangulated: {shapely.is_valid_reason(polygon)}")
    vertices = np.concatenate([np.asarray(r, np.float64) for r in (ring, *holes)])
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    xz = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    order = {(x, z): i for i, (x, z) in enumerate(vertices.tolist())}
    corners = np.array([[order[x, z] for x, z in t] for t in xz.tolist()], np.int64).reshape(-1, 3)
    a, b, c = (vertices[corners[:, k]] for k in range(3))
    turn = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    corners[turn < 0] = corners[turn < 0][:, ::-1]
    return vertices, corners


def _convex(ring: Float) -> Int | None:
    """Triangulates a strictly convex triangle or quadrilateral (k, 2); returns None for any other ring."""
    ahead = np.roll(ring, -1, axis=0) - ring
    after = np.roll(ahead, -1, axis=0)
    turn = ahead[:, 0] * after[:, 1] - ahead[:, 1] * after[:, 0]
    if not (turn.min() > 0 or turn.max() < 0):
        return None
    corners = np.array([[0, 1, 2], [0, 2, 3]][: len(ring) - 2])
    return corners if turn[0] > 0 else corners[:, ::-1]


def fan(ring: Float) -> Int:
    """Triangulate a planar 3-D ring (k, 3), which may be concave: corners (t, 3)."""
    ring = np.asarray(ring, np.float64)
    normal = np.cross(ring, np.roll(ring, -1, axis=0)).sum(0)
    drop = int(np.argmax(np.abs(normal)))
    keep = [(1, 2), (2, 0), (0, 1)][drop]
    _, corners = triangulate(ring[:, keep])
    return corners if normal[drop] > 0 else corners[:, ::-1]


def inset(ring: Float, distance: float) -> Float:
    """Move a counter-clockwise ring (k, 2) inward by `distance` (outward if negative), edge by edge.

    The result has as many vertices as the ring, in the same order.
    """
    ahead = np.roll(ring, -1, axis=0) - ring
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    normal = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    before = np.roll(normal, 1, axis=0)
    middle = normal + before
    scale = 2.0 / (middle**2).sum(1, keepdims=True)
    return np.asarray(ring + distance * scale * middle)


def loft(rings: Float) -> tuple[Float, Int]:
    """Make a closed body through convex rings (m, k, 3): vertices (m k, 3) and corners (t, 3).

    Every ring is counter-clockwise as seen from the last one; the first and the last ring are the ends.
    """
    m, k, _ = rings.shape
    a = np.arange(k)
    b = (a + 1) % k
    quads = np.concatenate([np.column_stack([a, b, b + k]), np.column_stack([a, b + k, a + k])])
    sides = (quads[None] + (np.arange(m - 1) * k)[:, None, None]).reshape(-1, 3)
    cap = np.column_stack([np.zeros(k - 2, np.int64), a[1:-1], a[2:]])
    return rings.reshape(-1, 3), np.concatenate([sides, cap[:, ::-1], cap + (m - 1) * k])
