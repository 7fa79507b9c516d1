"""Building footprints from city models and maps: where one house ends and the next begins.

A footprint is the union of a building's ground surfaces, or of its coarsest level seen from above.
"""

import logging
from collections.abc import Iterator, Sequence
from pathlib import Path

import shapely

from frontage.errors import FileError
from frontage.geometry.arrays import Float
from frontage.io.citymodels.read import read_city_model
from frontage.model import WorldRef
from frontage.model.building import Footprint
from frontage.model.citymodel import CityBuilding, Shell

log = logging.getLogger(__name__)
_SLIVER_M2 = 0.5  # smaller pieces come from badly joined surfaces and are not buildings


def read_footprints(
    path: str | Path,
    world: WorldRef,
    crs: str | None = None,
    bounds: tuple[float, ...] | None = None,
) -> tuple[Footprint, ...]:
    """Read the outline of every building of a map or city model: local metres, counter-clockwise, not closed.

    A building of several separate pieces gives one footprint per piece, with "#2", ... appended to its id.
    Buildings that do not touch `bounds` (x0, y0, x1, y1) m world are left out.

    Raises FileError (missing, truncated, corrupt, no buildings, none within the bounds), CrsError (no CRS
    where the world has one, or the other way round).
    """
    model = read_city_model(path, world, bounds, crs)
    for note in (*model.notes, *(p.message for p in model.problems)):
        log.warning(note)
    found = footprints_of(model.buildings)
    if not found:
        raise FileError(path, "holds no buildings with a footprint", "check the model", code="I105")
    return found


def footprints_of(buildings: Sequence[CityBuilding]) -> tuple[Footprint, ...]:
    """The footprints of buildings of a city model, as `read_footprints` gives them."""
    return tuple(f for b in buildings for f in _footprints(b))


def _ground(shells: Sequence[Shell]) -> list[Float]:
    """The ground surfaces of the coarsest level that has any, else all polygons of the coarsest level."""
    levels = sorted({s.lod for s in shells})
    for lod in levels:
        rings = [p.ring for s in shells if s.lod == lod for p in s.surfaces if p.semantics == "GroundSurface"]
        if rings:
            return rings
    return [p.ring for s in shells if s.lod == levels[0] for p in s.surfaces] if levels else []


def _footprints(building: CityBuilding) -> Iterator[Footprint]:
    """The union of a building's ground polygons seen from above, piece by piece, largest first."""
    flat = [
        shapely.Polygon(ring[:, :2]) for ring in _ground([s for s in building.shells if not s.installation])
    ]
    if crossing := sum(not q.is_valid for q in flat):
        log.warning("%s: %d ground polygons cross themselves and were divided", building.id, crossing)
    whole = shapely.union_all([shapely.make_valid(q) for q in flat if q.area > 0])
    pieces = [q for q in shapely.get_parts(whole) if q.geom_type == "Polygon" and q.area >= _SLIVER_M2]
    for k, piece in enumerate(sorted(pieces, key=lambda q: -q.area), 1):
        closed = shapely.get_coordinates(shapely.get_exterior_ring(piece))
        ring = closed[:-1] if shapely.is_ccw(shapely.get_exterior_ring(piece)) else closed[:0:-1]
        yield Footprint(building.id if k == 1 else f"{building.id}#{k}", ring, building.address)
