"""The host where there is no city model: blocks behind the facades that were measured.

A facade that stands alone gives a block with its own eaves. Several give upright blocks over their footprints
(`plan`), each from the lowest foot of the facades on its border to the highest eaves, or under those, where
they step or slope (`roofs`).
"""

from collections.abc import Sequence

import numpy as np
from shapely.geometry import Polygon

from frontage.geometry.arrays import Float
from frontage.model import Facade, Failed, Surface, WorldRef
from frontage.solids.hosts.eaves import clean_outline
from frontage.solids.hosts.host import Host, facade_block, ground_block
from frontage.solids.hosts.plan import Front, footprints
from frontage.solids.hosts.roofs import roofed

_SAME = 0.01  # of its area that a block differs by from the strip behind its one facade


def cloud_blocks(
    building: str, facades: Sequence[Facade], ground_z: float, depth: float, world: WorldRef
) -> tuple[Host, ...] | Failed:
    """Closed blocks, `depth` m deep, behind a building's facades; `ground_z` m local, nan = not known."""
    if not facades:
        return Failed("S305", f"{building}: no facade, so there is nothing to make a block from")
    outlines = [clean_outline(f, ground_z) for f in facades]
    fronts = [front_of(f, o) for f, o in zip(facades, outlines, strict=True)]
    hosts = []
    for plan, own in footprints(fronts, depth):
        alone = plan.symmetric_difference(own[0].quad(depth)).area < _SAME * plan.area
        if alone and len(own) == 1:
            k = fronts.index(own[0])
            made = facade_block(building, facades[k].frame, outlines[k], depth, world)
        else:
            made = _prism(building, plan, own, depth, world)
        if isinstance(made, Failed):
            return made
        hosts.append(made)
    if not hosts:
        return Failed("S304", f"{building}: its facades enclose no block", "give a city model")
    return tuple(hosts)


def _prism(
    building: str, plan: Polygon, own: Sequence[Front], depth: float, world: WorldRef
) -> Host | Failed:
    """An upright block over a footprint, from the lowest foot to the highest eaves on its border."""
    some = f"{len(own)} facades" if len(own) > 1 else "a facade"
    note = f"{building}: no city model; a block behind {some}, {depth:g} m deep where they leave it open"
    if made := roofed(building, plan, own, world):
        return Host(made.solid, (f"{note}, under the eaves of the highest one, stands for it", *made.notes))
    low, high = min(f.low for f in own), max(f.high for f in own)
    rings = [np.insert(np.asarray(r.coords)[:-1], 2, low, axis=1) for r in (plan.exterior, *plan.interiors)]
    flat = ground_block(building, [Surface(rings[0], "GroundSurface", "", tuple(rings[1:]))], world, high)
    if isinstance(flat, Failed):
        return flat
    return Host(flat.solid, (f"{note}, stands for it", *flat.notes[1:]))


def front_of(facade: Facade, outline: Float) -> Front:
    """A facade in plan, between the foot and the eaves of its clean outline (k, 2) m."""
    corners = facade.frame.apply(np.insert(outline, 1, 0.0, axis=1))
    ends = np.array([[outline[:, 0].min(), 0, 0], [outline[:, 0].max(), 0, 0]])
    inward = facade.frame.R[:2, 1] / np.linalg.norm(facade.frame.R[:2, 1])
    low, high = float(corners[:, 2].min()), float(corners[:, 2].max())
    front = Front(facade.frame.apply(ends)[:, :2], inward, low, high)
    front.eaves = np.column_stack([corners[2:, :2] @ front.along, corners[2:, 2]])[::-1]
    return front
