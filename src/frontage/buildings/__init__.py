"""Buildings: which points of a street cloud belong to which house, and what stands before it.

This room implements the building detection of paper A, section 2.1 (octree and connected components), and
goes beyond it: ground and occluders are taken out, and terraces are cut into houses along their fronts, with
the help of footprints where a map is given. The entry function is `find_buildings`.
"""

from frontage.buildings.assembly.collect import BuildingSplit
from frontage.buildings.find import find_buildings
from frontage.buildings.options import BuildingOptions

__all__ = ["BuildingOptions", "BuildingSplit", "find_buildings"]
