"""A building of a city model before it is drawn: its walls, which of them are facades, their openings."""

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

_FACADE = (2.0, 2.0, 6.0)  # m, m, m2: width, height and area from which a wall without openings is a facade
_GRID = 0.25  # m, between places that no room may hold
_KEPT = (-0.2, 0.0, 0.25)  # m behind walls: air before them, and the wall itself
_SEAM = 0.3  # m: bands as high as this do not divide a facade


@dataclass(frozen=True, eq=False)
class ModelFacade:
    """A wall that is a facade: its number, outline (k, 2) m (x, z) above the ground, what is in and on it."""

    wall: int
    outline: Float
    openings: tuple[ModelOpening, ...]
    protrusions: tuple[ProtrusionPlan, ...]


@dataclass(frozen=True, eq=False)
class ModelDraft:
    """A building of a model: faces of its body, walls made of them, facades, other faces.

    gone         faces that are drawn anew: openings and their reveals
    fixtures     faces of installations (balconies, chimneys), part by part
    footprint    polygon(s) in plan, m local; base = height of the ground, m local
    lost         number of windows and doors without a wall
    outdoors     places (n, 3) m local just before the walls and in them
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
        """Pose of a facade."""
        return self.walls[facade.wall].local_from_wall


def read_model_house(building: CityBuilding, id: str) -> ModelDraft | None:
    """The finest level of a building taken apart; None for one without walls or a footprint."""
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
    fixtures = tuple(s.surfaces for s in shells if s.installation)
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
    """Points on a grid over all walls and their openings, a little before them and within them."""
    out: list[Float] = [np.empty((0, 3))]
    for number, wall in enumerate(walls):
        holes = [shapely.Polygon(o.ring) for o in openings if o.wall == number]
        area = shapely.union_all([wall.area(gone), *holes])
        if area.is_empty:
            continue
        x0, z0, x1, z1 = area.bounds
        x, z = np.meshgrid(np.arange(x0 + _GRID / 2, x1, _GRID), np.arange(z0 + _GRID / 2, z1, _GRID))
        shapely.prepare(area)
        on = shapely.contains_xy(area, x, z)
        for y in _KEPT:
            out.append(wall.local_from_wall.apply(np.column_stack([x[on], np.full(on.sum(), y), z[on]])))
    return np.concatenate(out)


def _base(faces: tuple[Surface, ...]) -> float:
    """Height of the ground: what half of the ground surfaces' area lies below; else the lowest corner."""
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
    """A wall as a facade, if it is one: it has openings, or is large."""
    own = tuple(o for o in openings if o.wall == number)
    area = shapely.union_all([wall.area(gone), *(shapely.Polygon(o.ring) for o in own)])
    whole = area.buffer(_SEAM / 2, join_style="mitre").buffer(-_SEAM / 2, join_style="mitre")
    x0, z0, x1, z1 = whole.bounds if not whole.is_empty else (0.0, 0.0, 0.0, 0.0)
    foot = base - float(wall.local_from_wall.t[2])
    seen = polygons(whole.intersection(shapely.box(x0 - 1, max(foot, z0 - 1), x1 + 1, z1 + 1)))
    if not seen:
        return None
    outline = max(seen, key=lambda p: float(p.area))
    width, height = x1 - x0, outline.bounds[3] - outline.bounds[1]
    large = width >= _FACADE[0] and height >= _FACADE[1] and outline.area >= _FACADE[2]
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
    """Facades with the installations that stand out of them; one belongs to the facade it touches most."""
    held: dict[int, list[ProtrusionPlan]] = {}
    for fixture in fixtures:
        points = np.concatenate([f.ring for f in fixture])
        best, place = 0.0, None
        for k, facade in enumerate(facades):
            at = walls[facade.wall].seen(points)
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
