"""Street cloud -> buildings: which points belong to which house, and what stands in front (paper
A, section 2.1)."""

from frontage.buildings.collect import BuildingSplit
from frontage.buildings.find import find_buildings
from frontage.buildings.options import BuildingOptions

__all__ = ["BuildingOptions", "BuildingSplit", "find_buildings"]
