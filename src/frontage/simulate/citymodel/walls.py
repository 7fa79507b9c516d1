"""Groups the upright polygons of a city model's building into walls, one for each plane."""

from collections.abc import Iterable, Sequence, Set
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Surface

_LEAN_SIN = np.sin(np.radians(10.0))  # greatest vertical component of a wall's unit normal
_PARALLEL_COS = np.cos(np.radians(1.0))  # least cosine between the normals of one wall
_SAME_PLANE_M = 0.005  # greatest distance of a polygon's corners from the wall's plane
_FOUNDING_M2 = 0.3  # smaller polygons may join a wall, but do not start one
_GRID_M = 1e-5  # corners of neighbouring polygons that are this close are merged
_PROBE_M = 0.3  # distance in front of and behind a wall at which its inside is looked for


@dataclass(frozen=True, eq=False)
class ModelWall:
    """A wall: its frame has x right, y into the building, z up the wall, origin at the lower left corner.

    pieces   polygons (x, z) m of the model's faces, by the number of the face
    """

    local_from_wall: Rigid3
    pieces: dict[int, shapely.Geometry]

    def area(self, without: Set[int] = frozenset()) -> shapely.Geometry:
        """Return the area (x, z) m of the wall with its holes, leaving out the faces `without`."""
        return shapely.union_all([p for k, p in self.pieces.items() if k not in without], grid_size=_GRID_M)

    def to_wall(self, xyz: Float) -> Float:
        """Transform local points (n, 3) to the wall's frame."""
        return self.local_from_wall.inverse.apply(xyz)


def area_vector(ring: Float) -> Float:
    """Return the normal (3,) of a ring (k, 3), with its area in m2 as length (Newell's method)."""
    arms = ring - ring[0]
    return np.asarray(np.cross(arms, np.roll(arms, -1, axis=0)).sum(0) / 2)


def plane_frame(normal: Float, origin: Float) -> Rigid3:
    """Return the frame of a plane with outward `normal`: y against it, x level and z up.

    For a level plane, the direction of x is arbitrary.
    """
    y = -normal / np.linalg.norm(normal)
    x = np.cross(y, [0.0, 0.0, 1.0]) if abs(y[2]) < 0.999 else np.array([1.0, 0.0, 0.0])
    x = x - (x @ y) * y
    x /= np.linalg.norm(x)
    return Rigid3("local", "facade", np.column_stack([x, y, np.cross(x, y)]), origin)


def polygons(geometry: shapely.Geometry, least: float = 1e-6) -> list[shapely.Polygon]:
    """Return the polygons of a geometry that are larger than `least` m2."""
    parts = shapely.get_parts(shapely.get_parts(geometry))
    return [p for p in parts if isinstance(p, shapely.Polygon) and p.area > least]


def flat_polygon(face: Surface, frame: Rigid3) -> shapely.Geometry:
    """Project a face to the plane (x, z) of a frame; crossing rings are repaired."""
    rings = [frame.inverse.apply(r)[:, [0, 2]] for r in (face.ring, *face.holes)]
    polygon = shapely.Polygon(rings[0], rings[1:])
    if polygon.is_valid:
        return polygon
    return shapely.multipolygons(polygons(shapely.make_valid(polygon)))


def footprint_of(faces: Sequence[Surface]) -> shapely.Geometry:
    """Return the area of a building in plan: of its ground surfaces or, without any, of all its faces.

    The result may be empty.
    """
    ground = [f for f in faces if f.semantics == "GroundSurface"] or faces
    flat = [shapely.Polygon(f.ring[:, :2]) for f in ground]
    return shapely.multipolygons(polygons(shapely.union_all([shapely.make_valid(p) for p in flat]), 0.01))


def in_plan(geometry: shapely.Geometry, frame: Rigid3) -> shapely.Geometry:
    """Transform a geometry in plan (x, y local) to the (x, y) of a frame that is upright, or nearly so."""
    (a, b), (c, d) = frame.R[:2, :2].T
    x0, y0 = frame.t[:2]

    def moved(xy: Float) -> Float:  # by columns, so that the last point of a ring stays equal to its first
        x, y = xy[:, 0] - x0, xy[:, 1] - y0
        return np.column_stack([a * x + b * y, c * x + d * y])

    return shapely.transform(geometry, moved)


def find_walls(faces: Sequence[Surface], footprint: shapely.Geometry) -> list[ModelWall]:
    """Return the walls of a building, facing away from its `footprint`, in order of their largest polygon."""
    walls = []
    for group in _coplanar(faces):
        normal, point = area_vector(faces[group[0]].ring), faces[group[0]].ring[0]
        if _faces_inward(faces[group[0]], normal, footprint):
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
    """Groups the numbers of the wall polygons by plane, the largest first."""
    vectors = np.array([area_vector(f.ring) for f in faces]).reshape(-1, 3)
    size = np.linalg.norm(vectors, axis=1)
    unit = vectors / np.maximum(size, 1e-12)[:, None]
    groups: list[list[int]] = []
    normals: Float = np.empty((0, 3))
    offsets: Float = np.empty(0)
    for k in _largest_first(size):
        if faces[k].semantics != "WallSurface" or size[k] < 1e-6 or abs(unit[k, 2]) > _LEAN_SIN:
            continue
        off = np.abs(faces[k].ring @ normals.T - offsets).max(0)
        same = np.flatnonzero((normals @ unit[k] > _PARALLEL_COS) & (off < _SAME_PLANE_M))
        if len(same):
            groups[same[0]].append(k)
        elif size[k] >= _FOUNDING_M2:
            groups.append([k])
            normals = np.vstack([normals, unit[k]])
            offsets = np.append(offsets, faces[k].ring.mean(0) @ unit[k])
    return groups


def _largest_first(size: Float) -> Iterable[int]:
    found: list[int] = np.argsort(-size, kind="stable").tolist()
    return found


def _faces_inward(face: Surface, normal: Float, footprint: shapely.Geometry) -> bool:
    """Checks whether the building lies in front of a face, and not behind it."""
    middle, step = face.ring.mean(0)[:2], _PROBE_M * normal[:2] / np.linalg.norm(normal)
    before, behind = (shapely.Point(middle + sign * step) for sign in (1.0, -1.0))
    return bool(footprint.contains(before) and not footprint.contains(behind))
