"""Chooses the coarse solids of a building: those of the city model, or blocks behind its facades."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.model import Building, Facade, Failed, Surface, WorldRef
from frontage.model.citymodel import Shell
from frontage.solids.coarse.cloud_blocks import cloud_blocks
from frontage.solids.coarse.eaves import clean_outline
from frontage.solids.coarse.extrude import ground_block
from frontage.solids.coarse.host import Host, host_solid
from frontage.solids.coarse.plan_facade import PlanFacade
from frontage.solids.options import BuildOptions
from frontage.solids.relief import FacadeReliefs
from frontage.solids.walls import find_walls
from frontage.validation.validate import validate


@dataclass(frozen=True, eq=False)
class CoarseModel:
    """The coarse solids of a building, one per part of it.

    source  "model" (the city model) or "cloud" (blocks behind the facades)
    hosts   valid, closed solids
    names   of the parts, as in the city model; "" is the building itself
    notes   why a better source was not used
    """

    source: str
    hosts: tuple[Host, ...]
    names: tuple[str, ...]
    notes: tuple[str, ...] = ()


def coarse_model(
    building: Building,
    facades: Sequence[Facade],
    shells: Sequence[Shell],
    world: WorldRef,
    options: BuildOptions,
) -> CoarseModel | Failed:
    """Chooses the first source that gives valid solids with a wall near some facade.

    In this order: the solids of the city model, its ground polygons extruded to the facades' heights, blocks
    behind the facades. Returns S302, S304, S305 or S306 if none of them does.
    """
    reason = ""
    if shells:
        solids = _from_model(building, facades, shells, world, options)
        if isinstance(solids, CoarseModel) and (not facades or _has_wall_near(solids, facades, options)):
            return solids
        ground = _from_ground(building, facades, shells, world, options)
        if isinstance(ground, CoarseModel) and _has_wall_near(ground, facades, options):
            return ground
        far = f"{building.id}: no wall of the city model is within {options.max_offset:g} m of a facade"
        reason = solids.message if isinstance(solids, Failed) else far
    if not facades:
        return Failed("S305", reason or f"{building.id}: no facade and no city model to build from")
    return _from_cloud(building, facades, world, options, (reason,) if reason else ())


def _has_wall_near(coarse: CoarseModel, facades: Sequence[Facade], options: BuildOptions) -> bool:
    """Decides whether some facade was measured on a wall of the coarse solids."""
    outlines = [FacadeReliefs(f.id, f.frame, f.outline, ()) for f in facades]
    return any(find_walls(h.solid, o, options) for o in outlines for h in coarse.hosts)


def _from_model(
    building: Building,
    facades: Sequence[Facade],
    shells: Sequence[Shell],
    world: WorldRef,
    options: BuildOptions,
) -> CoarseModel | Failed:
    """Makes a host of every part of the city model; a part that does not close becomes a block."""
    parts: dict[str, list[Surface]] = {}
    for shell in shells:
        if not shell.installation:
            parts.setdefault(shell.part, []).extend(shell.surfaces)
    hosts, names, notes = [], [], []
    last_failure: Failed | None = None
    for name, surfaces in parts.items():
        made = _as_it_is(name or building.id, surfaces, world)
        if isinstance(made, Failed):
            fronts = _in_plan(building, facades)
            block = ground_block(name or building.id, surfaces, world, fronts=fronts, options=options)
            if isinstance(block, Host) and not validate(block.solid):
                made = Host(block.solid, (made.message, *block.notes))
        if isinstance(made, Failed):
            last_failure = made
            notes.append(made.message)
            continue
        hosts.append(made)
        names.append(name)
    if not hosts:
        nothing = Failed("S302", f"{building.id}: the city model holds no polygons of this building")
        return last_failure or nothing
    return CoarseModel("model", tuple(hosts), tuple(names), tuple(notes))


def _from_ground(
    building: Building,
    facades: Sequence[Facade],
    shells: Sequence[Shell],
    world: WorldRef,
    options: BuildOptions,
) -> CoarseModel | Failed:
    """Extrudes the model's ground polygons from the foot to the top of the facades.

    For models whose heights mean nothing, such as footprints from maps.
    """
    if not facades:
        return Failed("S305", f"{building.id}: no facade gives the height of the building")
    fronts = _in_plan(building, facades)
    low, high = min(f.low for f in fronts), max(f.high for f in fronts)
    hosts: list[Host] = []
    names: list[str] = []
    for shell in shells:
        for s in shell.surfaces:
            if s.semantics == "GroundSurface" and not shell.installation:
                rings = [np.column_stack([r[:, :2], np.full(len(r), low)]) for r in (s.ring, *s.holes)]
                ground = Surface(rings[0], s.semantics, s.source_id, tuple(rings[1:]))
                made = ground_block(building.id, [ground], world, high, fronts=fronts, options=options)
                if isinstance(made, Host) and not validate(made.solid):
                    hosts.append(made)
                    names.append(shell.part or (building.id if names else ""))
    if not hosts:
        return Failed("S302", f"{building.id}: the city model has no usable ground polygon")
    note = f"{building.id}: a block with the model's plan and the facades' heights"
    return CoarseModel("model", tuple(hosts), tuple(names), (note,))


def _from_cloud(
    building: Building,
    facades: Sequence[Facade],
    world: WorldRef,
    options: BuildOptions,
    notes: tuple[str, ...],
) -> CoarseModel | Failed:
    """Makes valid blocks behind the measured facades."""
    blocks = cloud_blocks(building.id, facades, building.ground_z, options.block_depth, world)
    if isinstance(blocks, Failed):
        return blocks
    for host in blocks:
        if findings := validate(host.solid):
            text = f"{building.id}: the block behind its facades is not valid ({findings[0].message})"
            return Failed("S306", text, "give a city model")
    names = ("", *(f"{building.id}-{k}" for k in range(2, len(blocks) + 1)))
    return CoarseModel("cloud", blocks, names, notes)


def _as_it_is(name: str, surfaces: Sequence[Surface], world: WorldRef) -> Host | Failed:
    """Makes a valid host of the polygons as they are, or under a lid."""
    made = host_solid(name, surfaces, world, lid=True)
    if isinstance(made, Host) and validate(made.solid):
        return Failed("S306", f"{name}: the city model's solid is not valid", "repair the model")
    return made


def _in_plan(building: Building, facades: Sequence[Facade]) -> list[PlanFacade]:
    """Returns the facades in plan, between the feet and the eaves of their clean outlines."""
    return [PlanFacade.of(f, clean_outline(f, building.ground_z)) for f in facades]
