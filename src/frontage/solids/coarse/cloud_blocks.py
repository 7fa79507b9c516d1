"""Blocks behind the measured facades: the hosts of buildings without a city model.

A facade that stands alone gives a block under its own eaves. Several facades give upright blocks over their
footprints, from the lowest foot to the highest eaves of the facades on the border, or under those eaves where
they step or slope.
"""

from collections.abc import Sequence

import numpy as np
from shapely.geometry import Polygon

from frontage.model import Facade, Failed, Surface, WorldRef
from frontage.solids.coarse.eaves import clean_outline
from frontage.solids.coarse.extrude import facade_block, ground_block
from frontage.solids.coarse.footprints import footprints
from frontage.solids.coarse.host import Host
from frontage.solids.coarse.plan_facade import PlanFacade
from frontage.solids.coarse.roofs import block_under_eaves

_SAME_SHARE = 0.01  # a footprint this close in area to the strip behind its one facade is that strip


def cloud_blocks(
    building: str, facades: Sequence[Facade], ground_z: float, depth: float, world: WorldRef
) -> tuple[Host, ...] | Failed:
    """Makes closed blocks behind a building's facades, `depth` m deep where the facades leave them open.

    `ground_z` is the height of the ground (m local), nan if unknown. Returns S305 without facades, S304 if
    the facades enclose no block.
    """
    if not facades:
        return Failed("S305", f"{building}: no facade to make a block from")
    outlines = [clean_outline(f, ground_z) for f in facades]
    in_plan = [PlanFacade.of(f, o) for f, o in zip(facades, outlines, strict=True)]
    hosts = []
    for plan, own in footprints(in_plan, depth):
        if len(own) == 1 and _is_strip_of(plan, own[0], depth):
            k = in_plan.index(own[0])
            made = facade_block(building, facades[k].frame, outlines[k], depth, world)
        else:
            made = _block(building, plan, own, depth, world)
        if isinstance(made, Failed):
            return made
        hosts.append(made)
    if not hosts:
        return Failed("S304", f"{building}: its facades enclose no block", "give a city model")
    return tuple(hosts)


def _is_strip_of(plan: Polygon, facade: PlanFacade, depth: float) -> bool:
    """Decides whether a footprint is just the strip behind a facade."""
    return bool(plan.symmetric_difference(facade.own_strip(depth)).area < _SAME_SHARE * plan.area)


def _block(
    building: str, plan: Polygon, own: Sequence[PlanFacade], depth: float, world: WorldRef
) -> Host | Failed:
    """Makes a block over a footprint: under the eaves of its highest facade, or with a flat roof."""
    some = f"{len(own)} facades" if len(own) > 1 else "a facade"
    note = f"{building}: no city model; a block behind {some}, {depth:g} m deep where they leave it open"
    if made := block_under_eaves(building, plan, own, world):
        return Host(made.solid, (f"{note}, under the eaves of the highest one, is used", *made.notes))
    low, high = min(f.low for f in own), max(f.high for f in own)
    rings = [np.insert(np.asarray(r.coords)[:-1], 2, low, axis=1) for r in (plan.exterior, *plan.interiors)]
    flat = ground_block(building, [Surface(rings[0], "GroundSurface", "", tuple(rings[1:]))], world, high)
    if isinstance(flat, Failed):
        return flat
    return Host(flat.solid, (f"{note}, is used", *flat.notes[1:]))
