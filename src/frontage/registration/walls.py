"""The city model as planes that a scanner can meet: outer walls and roofs, without what neighbours hide."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import shapely

from frontage.geometry.arrays import Array, Float, Int
from frontage.model import CityBuilding, CityModel, Surface

UPRIGHT = 0.25  # |z| of the normal below which a polygon is a wall
_BESIDE_M = 0.6  # m; walls back to back nearer than this hide one another
_SAME_PLANE_M = 0.1  # m, distance within which polygons of one building are one wall
_SAME_PLANE_COS = np.cos(np.radians(3.0))  # cosine between the normals of polygons of one wall: 3 degrees
_LEAST_AREA_M2 = 0.5  # m2 that must be left of a wall
_SKIPPED = ("Window", "Door", "ClosureSurface", "InteriorWallSurface", "FloorSurface", "CeilingSurface")


@dataclass(frozen=True, eq=False)
class ModelPatch:
    """One plane of one building, with all its coplanar polygons.

    building   number of the building; `kind` "wall" or "roof"
    source     id of its largest polygon
    normal     (3,) unit, outwards
    point      (3,) m local, on the plane: the middle of a wall's foot
    along, up  (3,) unit, in the plane: horizontal, and normal x along
    polygon    what is exposed, in (along, up) m from `point`; `area` m2 of it
    length     m, extent along
    """

    building: int
    kind: str
    source: str
    normal: Float
    point: Float
    along: Float
    up: Float
    polygon: Any
    length: float
    area: float

    def coordinates(self, xyz: Float) -> tuple[Float, Float, Float]:
        """Returns distance from the plane (outwards positive), place along and up of points (n, 3) m."""
        d = xyz - self.point
        return d @ self.normal, d @ self.along, d @ self.up


@dataclass(frozen=True, eq=False)
class ModelWalls:
    """The patches of a city model.

    names       of its buildings
    base        (b,) m local, their lowest heights
    footprints  of its buildings, polygons in plan
    """

    patches: tuple[ModelPatch, ...]
    names: tuple[str, ...]
    base: Float
    footprints: tuple[Any, ...]

    @property
    def normals(self) -> Float:
        """Outward normals (j, 3) of the patches."""
        return np.array([p.normal for p in self.patches]).reshape(-1, 3)

    @property
    def building(self) -> Int:
        """Number of every patch's building (j,)."""
        return np.array([p.building for p in self.patches], np.int64)

    def of_kind(self, kind: str) -> tuple[ModelPatch, ...]:
        """Returns the patches of a kind, "wall" or "roof"."""
        return tuple(p for p in self.patches if p.kind == kind)


def model_walls(model: CityModel) -> ModelWalls:
    """Returns the exposed walls and roofs of a city model, in its local frame.

    Each building's best shell below LoD3 is used, or else the next best.
    """
    found: list[ModelPatch] = []
    names: list[str] = []
    base: list[float] = []
    footprints: list[Any] = []
    for b in model.buildings:
        surfaces = _surfaces(b)
        if not surfaces:
            continue
        plan = _footprint(surfaces)
        found += _patches(surfaces, len(names), plan)
        names.append(b.id)
        base.append(min(float(s.ring[:, 2].min()) for s in surfaces))
        footprints.append(plan)
    exposed = (_exposed(p, found) for p in found)
    return ModelWalls(
        tuple(p for p in exposed if p.area >= _LEAST_AREA_M2), tuple(names), np.array(base), tuple(footprints)
    )


def ring_normal(ring: Float) -> Float:
    """Returns the normal (3,) of a ring (k, 3) m; its length is twice the area, m2 (Newell's sum)."""
    q = ring - ring.mean(0)
    return np.asarray(np.cross(q, np.roll(q, -1, 0)).sum(0))


def _surfaces(building: CityBuilding) -> list[Surface]:
    """Returns the polygons of the shell that suits best: LoD2, otherwise the finest one."""
    shells = [s for s in building.shells if not s.lod.startswith("0")]
    if not shells:
        return []
    best = max(shells, key=lambda s: (s.lod.startswith("2"), s.lod))
    parts = [s for shell in shells if shell.lod == best.lod for s in shell.surfaces]
    return [s for s in parts if s.semantics not in _SKIPPED and np.linalg.norm(ring_normal(s.ring)) > 1e-6]


def _footprint(surfaces: Sequence[Surface]) -> Any:
    """Returns the plan of a building: the union of all polygons that are not upright."""
    flat = [s for s in surfaces if abs(_unit(ring_normal(s.ring))[2]) > UPRIGHT]
    rings = [shapely.Polygon(s.ring[:, :2]).buffer(0) for s in flat]
    return shapely.union_all(rings) if rings else shapely.Polygon()


def _unit(v: Float) -> Float:
    """Returns a vector of unit length."""
    return np.asarray(v / np.linalg.norm(v))


def _patches(surfaces: Sequence[Surface], building: int, plan: Any) -> list[ModelPatch]:
    """Returns the planes of one building: coplanar polygons are joined, the largest first."""
    planes: list[tuple[Float, Float, list[Surface]]] = []
    for s in sorted(surfaces, key=lambda s: -float(np.linalg.norm(ring_normal(s.ring)))):
        n = _outwards(_unit(ring_normal(s.ring)), s.ring.mean(0), plan)
        if n[2] < -UPRIGHT:
            continue
        for normal, point, members in planes:
            if normal @ n > _SAME_PLANE_COS and np.abs((s.ring - point) @ normal).max() < _SAME_PLANE_M:
                members.append(s)
                break
        else:
            planes.append((n, s.ring.mean(0), [s]))
    return [_patch(n, members, building) for n, _, members in planes]


def _outwards(normal: Float, centre: Float, plan: Any) -> Float:
    """Returns the normal, turned round where the wall would face into its own building."""
    if abs(normal[2]) > UPRIGHT:
        return normal
    out, inside = (shapely.Point((centre + sign * 0.2 * normal)[:2]) for sign in (1, -1))
    wrong = plan.contains(out) and not plan.contains(inside)
    return -normal if wrong else normal


def _patch(normal: Float, members: Sequence[Surface], building: int) -> ModelPatch:
    """Makes a patch of coplanar polygons."""
    kind = "wall" if abs(normal[2]) <= UPRIGHT else "roof"
    level = np.hypot(normal[0], normal[1])
    along = np.array([-normal[1], normal[0], 0.0]) / level if level > 1e-6 else np.array([1.0, 0.0, 0.0])
    up = np.cross(normal, along)
    first = members[0].ring
    u, h = first @ along, first @ up
    middle = first.mean(0)
    point = middle + along * (0.5 * (u.max() + u.min()) - middle @ along) + up * (h.min() - middle @ up)
    polygon = shapely.union_all([_project(s, point, along, up) for s in members])
    x0, _, x1, _ = polygon.bounds
    return ModelPatch(
        building, kind, members[0].source_id, normal, point, along, up, polygon, x1 - x0, float(polygon.area)
    )


def _project(s: Surface, point: Float, along: Float, up: Float) -> Any:
    """Projects a polygon onto a plane, in (along, up) m."""

    def plane(ring: Float) -> Array:
        return np.column_stack([(ring - point) @ along, (ring - point) @ up])

    return shapely.Polygon(plane(s.ring), [plane(h) for h in s.holes]).buffer(0)


def _exposed(patch: ModelPatch, all_patches: Sequence[ModelPatch]) -> ModelPatch:
    """Removes from a patch what a wall back to back with it hides (party walls)."""
    if patch.kind == "roof":
        return patch
    for other in all_patches:
        if other.kind != "wall" or other is patch or patch.normal @ other.normal > -0.98:
            continue
        if abs((other.point - patch.point) @ patch.normal) > _BESIDE_M:
            continue
        ring = shapely.get_coordinates(other.polygon)
        xyz = other.point + ring[:, :1] * other.along + ring[:, 1:] * other.up
        d, u, h = patch.coordinates(xyz)
        hidden = shapely.MultiPoint(np.column_stack([u, h])).convex_hull
        if np.abs(d).max() < 2 * _BESIDE_M and hidden.area > 0:
            patch = replace(patch, polygon=patch.polygon.difference(hidden.buffer(0.02)))
    return replace(patch, area=float(patch.polygon.area))
