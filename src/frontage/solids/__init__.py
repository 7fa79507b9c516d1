"""Builds closed, valid solids with windows, doors and protrusions: paper B, sections 3.1 and 3.2.3.

`assemble` is the entry function: it takes a building's facades with what was found on them and cuts it into
the coarse solid of the city model, or into a block made from the facades, by cell decomposition. The steps
can be used alone: `host_solid`, `ground_block` and `facade_block` make coarse solids, `build_solid` the fine
one, and `match_model` finds the building of a city model that facades belong to.
"""

from frontage.solids.assemble import Assembled, assemble
from frontage.solids.cells.build import build_solid
from frontage.solids.coarse.extrude import facade_block, ground_block
from frontage.solids.coarse.host import Host, host_solid
from frontage.solids.frames.seat import WindowFrame
from frontage.solids.installations.installation import Installation
from frontage.solids.model_match import ModelMatch, facades_of_matches, match_model
from frontage.solids.options import BuildOptions
from frontage.solids.relief import Built, FacadeReliefs, Relief

__all__ = [
    "Assembled",
    "BuildOptions",
    "Built",
    "FacadeReliefs",
    "Host",
    "Installation",
    "ModelMatch",
    "Relief",
    "WindowFrame",
    "assemble",
    "build_solid",
    "facade_block",
    "facades_of_matches",
    "ground_block",
    "host_solid",
    "match_model",
]
