"""The walls of a city model's building: its upright polygons that lie in one plane are one wall."""

from collections.abc import Iterable, Sequence, Set
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Surface

_UPRIGHT = np.sin(np.radians(10.0))  # of the normal's height: walls lean by less
_SAME_WAY = np.cos(np.radians(1.0))
_SAME_PLANE = 0.005  # m that the corners of a polygon may lie off the wall's plane
_FOUNDING = 0.3  # m2: smaller polygons join a wall, but do not make one
_GRID = 1e-5  # m: corners of neighbouring polygons that are so close are one
_PROBE = 0.3  # m before and behind a wall, where its inside is looked for


@dataclass(frozen=True, eq=False)
class ModelWall:
    """A wall: its frame (x right, y into the building, z up the wall), origin at its lower left corner.

    pieces  polygons (x, z) m of the model's faces, by their number
    """

    local_from_wall: Rigid3
    pieces: dict[int, shapely.Geometry]

    def area(self, without: Set[int] = frozenset()) -> shapely.Geometry:
        """The wall (x, z) m with its holes, faces `without` left out."""
        return shapely.union_all([p for k, p in self.pieces.items() if k not in without], grid_size=_GRID)

    def seen(self, xyz: Float) -> Float:
        """Local points (n, 3) in the wall's frame."""
        return self.local_from_wall.inverse.apply(xyz)


def area_vector(ring: Float) -> Float:
    """Normal (3,) of a ring (k, 3), as long as its area in m2 (Newell's method)."""
    arms = ring - ring[0]
    return np.asarray(np.cross(arms, np.roll(arms, -1, axis=0)).sum(0) / 2)


def plane_frame(normal: Float, origin: Float) -> Rigid3:
    """Frame of a plane with outward `normal`: y against it, x level (any way for a level plane), z up."""
    y = -normal / np.linalg.norm(normal)
    x = np.cross(y, [0.0, 0.0, 1.0]) if abs(y[2]) < 0.999 else np.array([1.0, 0.0, 0.0])
    x = x - (x @ y) * y
    x /= np.linalg.norm(x)
    return Rigid3("local", "facade", np.column_stack([x, y, np.cross(x, y)]), origin)


def polygons(geometry: shapely.Geometry, least: float = 1e-6) -> list[shapely.Polygon]:
    """The polygons of a geometry that are larger than `least` m2."""
    parts = shapely.get_parts(shapely.get_parts(geometry))
    return [p for p in parts if isinstance(p, shapely.Polygon) and p.area > least]


def flat_polygon(face: Surface, frame: Rigid3) -> shapely.Geometry:
    """A face in the plane (x, z) of a frame; crossing rings are repaired."""
    rings = [frame.inverse.apply(r)[:, [0, 2]] for r in (face.ring, *face.holes)]
    polygon = shapely.Polygon(rings[0], rings[1:])
    if polygon.is_valid:
        return polygon
    return shapely.multipolygons(polygons(shapely.make_valid(polygon)))


def footprint_of(faces: Sequence[Surface]) -> shapely.Geometry:
    """What a building covers in plan: its ground surfaces, all its faces where it has none; may be empty."""
    ground = [f for f in faces if f.semantics == "GroundSurface"] or faces
    flat = [shapely.Polygon(f.ring[:, :2]) for f in ground]
    return shapely.multipolygons(polygons(shapely.union_all([shapely.make_valid(p) for p in flat]), 0.01))


def in_plan(geometry: shapely.Geometry, frame: Rigid3) -> shapely.Geometry:
    """A geometry in plan (x, y local) in the (x, y) of a frame that stands upright, or nearly so."""
    (a, b), (c, d) = frame.R[:2, :2].T
    x0, y0 = frame.t[:2]

    def moved(xy: Float) -> Float:  # by columns: a ring's last point comes out as its first one does
        x, y = xy[:, 0] - x0, xy[:, 1] - y0
        return np.column_stack([a * x + b * y, c * x + d * y])

    return shapely.transform(geometry, moved)


def find_walls(faces: Sequence[Surface], footprint: shapely.Geometry) -> list[ModelWall]:
    """The walls of a building, the largest polygon's first; they look away from the `footprint`."""
    walls = []
    for group in _coplanar(faces):
        normal, point = area_vector(faces[group[0]].ring), faces[group[0]].ring[0]
        if _looks_inward(faces[group[0]], normal, footprint):
            normal = -normal
        frame = plane_frame(normal, point)
        flat = shapely.union_all([flat_polygon(faces[k], frame) for k in group])
        if flat.is_empty:
            continue
        x0, z0, _, _ = flat.bounds
        frame = Rigid3("local", "facade", frame.R, frame.apply(np.array([[x0, 0.0, z0]]))[0])
        walls.append(ModelWall(frame, {k: flat_polygon(faces[k], frame) for k in group}))
    return walls


def _coplanar(faces: Sequence[Surface]) -> list[list[int]]:
    """Numbers of the wall polygons of each plane, the largest first."""
    vectors = np.array([area_vector(f.ring) for f in faces]).reshape(-1, 3)
    size = np.linalg.norm(vectors, axis=1)
    unit = vectors / np.maximum(size, 1e-12)[:, None]
    groups: list[list[int]] = []
    normals: Float = np.empty((0, 3))
    offsets: Float = np.empty(0)
    for k in _largest_first(size):
        if faces[k].semantics != "WallSurface" or size[k] < 1e-6 or abs(unit[k, 2]) > _UPRIGHT:
            continue
        off = np.abs(faces[k].ring @ normals.T - offsets).max(0)
        same = np.flatnonzero((normals @ unit[k] > _SAME_WAY) & (off < _SAME_PLANE))
        if len(same):
            groups[same[0]].append(k)
        elif size[k] >= _FOUNDING:
            groups.append([k])
            normals = np.vstack([normals, unit[k]])
            offsets = np.append(offsets, faces[k].ring.mean(0) @ unit[k])
    return groups


def _largest_first(size: Float) -> Iterable[int]:
    found: list[int] = np.argsort(-size, kind="stable").tolist()
    return found


def _looks_inward(face: Surface, normal: Float, footprint: shapely.Geometry) -> bool:
    """Whether a face has the building before it and nothing behind it."""
    middle, step = face.ring.mean(0)[:2], _PROBE * normal[:2] / np.linalg.norm(normal)
    before, behind = (shapely.Point(middle + sign * step) for sign in (1.0, -1.0))
    return bool(footprint.contains(before) and not footprint.contains(behind))
