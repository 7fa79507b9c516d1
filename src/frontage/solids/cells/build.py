"""Cuts the reliefs of facades into a coarse solid: paper B, section 3.2.3, by cell decomposition (3.1)."""

from collections.abc import Sequence

from frontage.model import Failed, Solid
from frontage.solids.brep import unmatched_edges
from frontage.solids.build_log import BuildLog
from frontage.solids.cells.carve import carve
from frontage.solids.cells.clearance import Clearance
from frontage.solids.cells.context import BuildContext
from frontage.solids.cells.depths import level_slivers, limit_depths
from frontage.solids.cells.drawn_fronts import with_drawn_fronts
from frontage.solids.cells.pinches import partition_without_pinches
from frontage.solids.cells.place import place_reliefs
from frontage.solids.cells.placing_area import PlacingArea
from frontage.solids.cells.project import ProjectedRelief, assign_to_walls, without_protrusions
from frontage.solids.cells.set_off import on_a_step, on_and_off
from frontage.solids.coarse.reseat import reseat_walls
from frontage.solids.options import BuildOptions
from frontage.solids.relief import Built, FacadeReliefs, names_of
from frontage.solids.walls import HostWall, find_again, find_walls


def build_solid(
    host: Solid, facades: Sequence[FacadeReliefs], options: BuildOptions | None = None
) -> Built | Failed:
    """Cuts openings into a closed host solid and puts protrusions in front of it.

    The facades are in the local frame whose origin is that of the host's grid. Facades are taken in their
    order, and so are the reliefs of each. Reliefs that cannot be placed are in `Built.failed` (S310 to S316,
    S399), what was changed is in `Built.notes`. Returns S301 if the host is not closed.
    """
    context = BuildContext(options or BuildOptions(), BuildLog())
    if unmatched_edges(host.faces):
        edges = len(unmatched_edges(host.faces))
        text = f"{host.building}: the host is not closed ({edges} free edges)"
        return Failed("S301", text, "repair the host")
    if context.options.reseat:
        host = reseat_walls(host, facades, context.options, context.log)
    solid, offsets = host, dict[str, float]()
    for facade in (part for f in facades for part in with_drawn_fronts(f, host, context.options)):
        others = [f for f in facades if f.id != facade.id]
        solid, own_offsets = _cut_facade(solid, facade, others, context)
        offsets |= own_offsets
    in_solid = {f.opening for f in solid.faces}
    kept = {i: d for i, d in offsets.items() if i in in_solid}
    return Built(solid, host, kept, tuple(context.log.failed), tuple(context.log.notes))


def _cut_facade(
    solid: Solid, facade: FacadeReliefs, others: Sequence[FacadeReliefs], context: BuildContext
) -> tuple[Solid, dict[str, float]]:
    """Cuts the reliefs of one facade; also returns their offsets (m) from the measured plane."""
    if not facade.reliefs:
        return solid, {}
    walls = find_walls(solid, facade, context.options)
    on, off = on_and_off(facade, walls)
    solid, offsets = _cut_reliefs(solid, on, walls, context)
    if not off.reliefs:
        return solid, offsets
    if far := on_a_step(solid, off, others, context.options):
        off, walls = far
        context.log.note(f"{off.id}: stands on a step of {off.reliefs[0].depth:.2f} m of the host's wall")
    else:
        walls = find_walls(solid, off, context.options)
    solid, own = _cut_reliefs(solid, off, walls, context)
    return solid, offsets | own


def _cut_reliefs(
    solid: Solid, facade: FacadeReliefs, walls: Sequence[HostWall], context: BuildContext
) -> tuple[Solid, dict[str, float]]:
    """Cuts the reliefs of a facade into walls; also returns their offsets (m) from the measured plane."""
    if not facade.reliefs:
        return solid, {}
    if not walls:
        names = ", ".join(name for r in facade.reliefs for name in names_of(r))
        text = f"{facade.id}: no wall of the host lies where it was measured; left out: {names}"
        context.log.failed.append(Failed("S310", text, "check the registration, or raise max_offset"))
        return solid, {}
    by_wall, offsets = assign_to_walls(facade, walls, context)
    before = solid
    for number, reliefs in sorted(by_wall.items()):
        wall = find_again(solid, before, walls[number])
        if wall is None:
            for r in reliefs:
                context.log.refuse(
                    "S310", r.relief, "its wall was already cut for other reliefs", "merge the facades"
                )
            continue
        own = reliefs if context.options.depth else without_protrusions(reliefs, context)
        solid = _cut_wall(solid, wall, own, context)
    return solid, offsets


def _cut_wall(
    solid: Solid, wall: HostWall, reliefs: Sequence[ProjectedRelief], context: BuildContext
) -> Solid:
    """Cuts reliefs into one wall; returns the solid unchanged if none of them has a place."""
    placed = place_reliefs(PlacingArea.of(solid, wall), reliefs, context)
    placed = limit_depths(placed, Clearance.of(solid, wall, context.gap), context)
    placed = level_slivers(placed, context.gap)
    partition, placed = partition_without_pinches(wall, placed, context)
    if not placed:
        return solid
    finer = carve(solid, wall, partition, placed)
    if unmatched_edges(finer.faces):
        for p in placed:
            context.log.refuse(
                "S399", p.relief, "the cut would leave the solid open", "please report this case"
            )
        return solid
    return finer
