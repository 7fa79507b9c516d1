"""Chooses the coarse solids of a building: those of the city model, or blocks behind its facades."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from frontage.geometry.arrays import Float
from frontage.model import Building, Facade, Failed, Surface, WorldRef
from frontage.model.citymodel import Shell
from frontage.solids.coarse.cloud_blocks import cloud_blocks
from frontage.solids.coarse.eaves import clean_outline
from frontage.solids.coarse.extrude import ground_block, ground_plan, level_grounds
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
    openings: Mapping[str, Sequence[Float]] | None = None,
) -> CoarseModel | Failed:
    """Chooses the first source that gives valid solids with a wall near some facade.

    In this order: the solids of the city model, its ground polygons extruded to the facades' heights, blocks
    behind the facades. `openings` are the rings (k, 2) m (x, z) of what was found on a facade, by its id:
    they need a wall. Returns S302, S304, S305 or S306 if no source gives one.
    """
    case = _Case(building, facades, shells, world, options, openings or {})
    reason = ""
    if shells:
        solids = _from_model(case)
        if isinstance(solids, CoarseModel) and (not facades or _has_wall_near(solids, facades, options)):
            return solids
        ground = _from_ground(case)
        if isinstance(ground, CoarseModel) and _has_wall_near(ground, facades, options):
            return ground
        far = f"{building.id}: no wall of the city model is within {options.max_offset:g} m of a facade"
        reason = solids.message if isinstance(solids, Failed) else far
    if not facades:
        return Failed("S305", reason or f"{building.id}: no facade and no city model to build from")
    return _from_cloud(case, (reason,) if reason else ())


@dataclass(frozen=True, eq=False)
class _Case:
    """A building, its facades and its shells in the city model, as `coarse_model` takes them."""

    building: Building
    facades: Sequence[Facade]
    shells: Sequence[Shell]
    world: WorldRef
    options: BuildOptions
    openings: Mapping[str, Sequence[Float]]

    def fronts(self) -> list[PlanFacade]:
        """Returns the facades in plan, between the feet and the eaves of their clean outlines."""
        outlines = [clean_outline(f, self.building.ground_z) for f in self.facades]
        pairs = zip(self.facades, outlines, strict=True)
        return [PlanFacade.of(f, o, self.openings.get(f.id, ())) for f, o in pairs]

    def parts(self) -> dict[str, list[Surface]]:
        """Returns the surfaces of the building's parts by name, without installations."""
        parts: dict[str, list[Surface]] = {}
        for shell in self.shells:
            if not shell.installation:
                parts.setdefault(shell.part, []).extend(shell.surfaces)
        return parts

    def block(self, name: str, part: str, surfaces: Sequence[Surface], top: float | None) -> Host | Failed:
        """Makes a valid block over the ground of a part, beside the grounds of the others."""
        others = [s for other, own in self.parts().items() if other != part for s in own]
        beside = ground_plan([s for s in others if s.semantics == "GroundSurface"])
        fronts, options = self.fronts(), self.options
        made = ground_block(name, surfaces, self.world, top, fronts=fronts, beside=beside, options=options)
        if isinstance(made, Host) and validate(made.solid):
            made = ground_block(name, surfaces, self.world, top)
            if isinstance(made, Host):
                note = f"{name}: its block is not extended to measured fronts, because it would not be valid"
                made = Host(made.solid, (*made.notes, note))
        if isinstance(made, Host) and (findings := validate(made.solid)):
            text = f"{name}: the block over its ground is not valid ({findings[0].message})"
            return Failed("S306", text, "repair the model")
        return made


def _has_wall_near(coarse: CoarseModel, facades: Sequence[Facade], options: BuildOptions) -> bool:
    """Decides whether some facade was measured on a wall of the coarse solids."""
    outlines = [FacadeReliefs(f.id, f.frame, f.outline, ()) for f in facades]
    return any(find_walls(h.solid, o, options) for o in outlines for h in coarse.hosts)


def _from_model(case: _Case) -> CoarseModel | Failed:
    """Makes a host of every part of the city model; a part that does not close becomes a block."""
    hosts, names, notes = [], [], []
    last_failure: Failed | None = None
    for part, surfaces in case.parts().items():
        name = part or case.building.id
        made = _as_it_is(name, surfaces, case.world)
        if isinstance(made, Failed):
            block = case.block(name, part, surfaces, None)
            if isinstance(block, Host):
                made = Host(block.solid, (made.message, *block.notes))
        if isinstance(made, Failed):
            last_failure = made
            notes.append(made.message)
            continue
        hosts.append(made)
        names.append(part)
    if not hosts:
        nothing = Failed("S302", f"{case.building.id}: the city model holds no polygons of this building")
        return last_failure or nothing
    return CoarseModel("model", tuple(hosts), tuple(names), tuple(notes))


def _from_ground(case: _Case) -> CoarseModel | Failed:
    """Extrudes the model's grounds from the foot to the top of the facades.

    For models whose heights mean nothing, such as footprints from maps.
    """
    building = case.building.id
    if not case.facades:
        return Failed("S305", f"{building}: no facade gives the height of the building")
    fronts = case.fronts()
    low, high = min(f.low for f in fronts), max(f.high for f in fronts)
    hosts: list[Host] = []
    names: list[str] = []
    for part, surfaces in case.parts().items():
        for ground in level_grounds([s for s in surfaces if s.semantics == "GroundSurface"], low):
            made = case.block(building, part, [ground], high)
            if isinstance(made, Host):
                hosts.append(made)
                names.append(part or (building if names else ""))
    if not hosts:
        return Failed("S302", f"{building}: the city model has no usable ground polygon")
    note = f"{building}: a block with the model's plan and the facades' heights"
    return CoarseModel("model", tuple(hosts), tuple(names), (note,))


def _from_cloud(case: _Case, notes: tuple[str, ...]) -> CoarseModel | Failed:
    """Makes valid blocks behind the measured facades."""
    building, depth = case.building, case.options.block_depth
    blocks = cloud_blocks(building.id, case.facades, building.ground_z, depth, case.world)
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
