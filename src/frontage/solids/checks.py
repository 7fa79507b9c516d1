"""Validates the finished parts of a building together."""

from collections.abc import Sequence

from frontage.model import Feature, Polygons, Shape, Solid
from frontage.solids.brep import GRID_PER_M, rings_of
from frontage.solids.relief import Built
from frontage.validation.validate import validate_feature


def parts_overlap(built: Sequence[Built]) -> bool:
    """Decides whether solids of one level of detail overlap (601): then they are no parts of one building."""
    if len(built) < 2:
        return False
    for lod, solids in (("2", [b.host for b in built]), ("3", [b.solid for b in built])):
        parts = tuple(_building_part(s, lod) for s in solids)
        if validate_feature(Feature("whole", "Building", (), parts), quantum=1 / GRID_PER_M):
            return True
    return False


def _building_part(solid: Solid, lod: str) -> Feature:
    xyz = solid.vertices / GRID_PER_M
    faces = Polygons.of([[xyz[list(r)] for r in rings_of(f)] for f in solid.faces])
    return Feature(solid.building, "BuildingPart", (Shape("Solid", ((faces,),), lod),))
