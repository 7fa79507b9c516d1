"""Solids: windows, doors and protrusions put into a coarse solid by cells (paper B, 3.2), and the validator.

`assemble` makes a building from its facades and what was found on them. Its steps: `host_solid`,
`ground_block` and `facade_block` give the coarse solid, `build_solid` the fine one.
``validate(solid)`` checks Frontage's own integer solids, `validate_shape` and `validate_feature` what was
read from files: ISO 19107 with the error codes and tolerances of val3dity, in the standard's order: rings,
polygons, shells, solids, composites, buildings.
"""

from frontage.solids.assemble import Assembled, assemble
from frontage.solids.cells.build import build_solid
from frontage.solids.hosts.host import Host, facade_block, ground_block, host_solid
from frontage.solids.installations import Installation
from frontage.solids.relief import BuildOptions, Built, FacadeReliefs, Relief

__all__ = [
    "Assembled",
    "BuildOptions",
    "Built",
    "FacadeReliefs",
    "Host",
    "Installation",
    "Relief",
    "assemble",
    "build_solid",
    "facade_block",
    "ground_block",
    "host_solid",
]
