"""A building of a city model before it is drawn: its walls, the facades among them, and their openings."""

from collections.abc import Set
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import polygon_ring
from frontage.model import CityBuilding, Surface
from frontage.simulate.citymodel.openings import ModelOpening, find_openings, reveals_of
from frontage.simulate.citymodel.walls import ModelWall, find_walls, footprint_of, polygons
from frontage.simulate.scene import ProtrusionPlan

_FACADE_WIDTH_M, _FACADE_HEIGHT_M, _FACADE_M2 = 2.0, 2.0, 6.0  # least size of a facade without openings
_GRID_M = 0.25  # spacing of the points that no room may contain
_OUTDOORS_M = (-0.2, 0.0, 0.25)  # y of these points: in front of the walls, and within them
_SEAM_M = 0.3  # bands up to this height do not divide a facade


@dataclass(frozen=True, eq=False)
class ModelFacade:
    """A wall that is a facade: its number, and its outline (k, 2) m (x, z) above the ground."""

    wall: int
    outline: Float
    openings: tuple[ModelOpening, ...]
    protrusions: tuple[ProtrusionPlan, ...]


@dataclass(frozen=True, eq=False)
class ModelDraft:
    """A building of a city model, taken apart.

    faces        faces of its body, which the walls are made of
    gone         numbers of the faces that are drawn anew: openings and their reveals
    fixtures     faces of the installations (balconies, chimneys), one tuple for each
    footprint    polygons in plan, m local
    base         height of the ground, m local
    lost         number of windows and doors that lie in no wall
    outdoors     points (n, 3) m local just in front of the walls and within them
    """

    id: str
    address: str
    faces: tuple[Surface, ...]
    walls: tuple[ModelWall, ...]
    facades: tuple[ModelFacade, ...]
    gone: Set[int]
    fixtures: tuple[tuple[Surface, ...], ...]
    footprint: shapely.Geometry
    base: float
    lost: int
    outdoors: Float

    def frame(self, facade: ModelFacade) -> Rigid3:
        """Return the pose local_from_facade of a facade."""
        return self.walls[facade.wall].local_from_wall


def read_model_house(building: CityBuilding, id: str) -> ModelDraft | None:
    """Take the finest level of detail of a building apart; None if it has no walls or no footprint."""
    shells = building.level()
    body = [s for s in shells if not s.installation]
    faces = tuple(f for s in body for f in s.surfaces if f.semantics != "ClosureSurface")
    footprint = footprint_of(faces)
    walls = tuple(find_walls(faces, footprint))
    if not walls or footprint.is_empty:
        return None
    openings, taken, lost = find_openings(faces, body, walls)
    gone = taken | reveals_of(faces, walls, openings)
    base = _base(faces)
    fixtures = tuple(s.surfaces for s in shells if s.installation and not s.frame_of)
    facades = [f for k in range(len(walls)) if (f := _facade(k, walls[k], openings, gone, base))]
    front = _with_protrusions(id, facades, walls, fixtures)
    address = building.address or f"{id[1:].lstrip('0')} {building.id}"
    return ModelDraft(
        id,
        address,
        faces,
        walls,
        front,
        gone,
        fixtures,
        footprint,
        base,
        lost,
        _outdoors(walls, openings, gone),
    )


def _outdoors(walls: tuple[ModelWall, ...], openings: list[ModelOpening], gone: Set[int]) -> Float:
    """Returns points (n, 3) on a grid over all walls and their openings, in front of them and within them."""
    out: list[Float] = [np.empty((0, 3))]
    for number, wall in enumerate(walls):
        holes = [shapely.Polygon(o.ring) for o in openings if o.wall == number]
        area = shapely.union_all([wall.area(gone), *holes])
        if area.is_empty:
            continue
        x0, z0, x1, z1 = area.bounds
        x, z = np.meshgrid(np.arange(x0 + _GRID_M / 2, x1, _GRID_M), np.arange(z0 + _GRID_M / 2, z1, _GRID_M))
        shapely.prepare(area)
        on = shapely.contains_xy(area, x, z)
        for y in _OUTDOORS_M:
            out.append(wall.local_from_wall.apply(np.column_stack([x[on], np.full(on.sum(), y), z[on]])))
    return np.concatenate(out)


def _base(faces: tuple[Surface, ...]) -> float:
    """Returns the height of the ground: the median over the ground surfaces' area, or the lowest corner."""
    ground = [f for f in faces if f.semantics == "GroundSurface"]
    if not ground:
        return float(min(f.ring[:, 2].min() for f in faces))
    height = np.array([f.ring[:, 2].mean() for f in ground])
    size = np.array([abs(shapely.Polygon(f.ring[:, :2]).area) for f in ground])
    order = np.argsort(height, kind="stable")
    total = np.cumsum(size[order])
    return float(height[order][np.searchsorted(total, total[-1] / 2)])


def _facade(
    number: int, wall: ModelWall, openings: list[ModelOpening], gone: Set[int], base: float
) -> ModelFacade | None:
    """Returns a wall as a facade if it has openings or is large, else None."""
    own = tuple(o for o in openings if o.wall == number)
    area = shapely.union_all([wall.area(gone), *(shapely.Polygon(o.ring) for o in own)])
    whole = area.buffer(_SEAM_M / 2, join_style="mitre").buffer(-_SEAM_M / 2, join_style="mitre")
    x0, z0, x1, z1 = whole.bounds if not whole.is_empty else (0.0, 0.0, 0.0, 0.0)
    foot = base - float(wall.local_from_wall.t[2])
    seen = polygons(whole.intersection(shapely.box(x0 - 1, max(foot, z0 - 1), x1 + 1, z1 + 1)))
    if not seen:
        return None
    outline = max(seen, key=lambda p: float(p.area))
    width, height = x1 - x0, outline.bounds[3] - outline.bounds[1]
    large = width >= _FACADE_WIDTH_M and height >= _FACADE_HEIGHT_M and outline.area >= _FACADE_M2
    if not own and not large:
        return None
    plain = shapely.Polygon(outline.exterior).simplify(0.001)
    return ModelFacade(number, polygon_ring(plain), own, ())


def _with_protrusions(
    id: str,
    facades: list[ModelFacade],
    walls: tuple[ModelWall, ...],
    fixtures: tuple[tuple[Surface, ...], ...],
) -> tuple[ModelFacade, ...]:
    """Adds the installations that stand out of the facades, each to the facade that it covers most."""
    held: dict[int, list[ProtrusionPlan]] = {}
    for fixture in fixtures:
        points = np.concatenate([f.ring for f in fixture])
        best, place = 0.0, None
        for k, facade in enumerate(facades):
            at = walls[facade.wall].to_wall(points)
            near, far = float(at[:, 1].min()), float(at[:, 1].max())
            shown = shapely.box(*at[:, [0, 2]].min(0), *at[:, [0, 2]].max(0))
            shared = shown.intersection(shapely.Polygon(facade.outline)).area
            if near < -0.05 and far > -0.3 and near > -4.0 and shared > max(best, 0.3 * shown.area):
                best, place = shared, (k, shown, near, min(far, 0.0))
        if place is not None:
            k, shown, near, far = place
            own = held.setdefault(k, [])
            name = f"{id}/F{k + 1}/installation{len(own) + 1}"
            own.append(
                ProtrusionPlan(name, "installation", polygon_ring(shown), (near, max(far, near + 0.01)))
            )
    return tuple(
        ModelFacade(f.wall, f.outline, f.openings, tuple(held.get(k, ()))) for k, f in enumerate(facades)
    )
