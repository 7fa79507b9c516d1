"""Which coarse solid a building is built from: the city model's, or a block made from the cloud."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.model import Building, Facade, Failed, Surface, WorldRef
from frontage.model.citymodel import Shell
from frontage.solids.hosts.blocks import cloud_blocks
from frontage.solids.hosts.eaves import clean_outline
from frontage.solids.hosts.host import Host, ground_block, host_solid
from frontage.solids.hosts.walls import find_walls
from frontage.solids.relief import BuildOptions, FacadeReliefs
from frontage.validation.validate import validate


@dataclass(frozen=True, eq=False)
class Coarse:
    """The coarse solids of a building, one per part of it.

    source  "model" or "cloud"
    hosts   valid, closed solids
    names   of the parts, as the city model has them; "" is the building itself
    """

    source: str
    hosts: tuple[Host, ...]
    names: tuple[str, ...]
    notes: tuple[str, ...] = ()


def coarse_solids(
    building: Building,
    facades: Sequence[Facade],
    shells: Sequence[Shell],
    world: WorldRef,
    options: BuildOptions,
) -> Coarse | Failed:
    """The model's solids where they close, are valid and have a wall near some facade; else blocks."""
    why: tuple[str, ...] = ()
    if shells:
        model = _from_model(building, shells, world)
        if isinstance(model, Coarse) and (not facades or _meets(model, facades, options)):
            return model
        flat = _from_ground(building, facades, shells, world)
        if isinstance(flat, Coarse) and _meets(flat, facades, options):
            return flat
        far = f"{building.id}: no wall of the city model is within {options.max_offset:g} m of a facade"
        why = (model.message if isinstance(model, Failed) else far,)
    if not facades:
        return Failed("S305", why[0] if why else f"{building.id}: no facade and no city model to build from")
    made = cloud_blocks(building.id, facades, building.ground_z, options.block_depth, world)
    if isinstance(made, Failed):
        return made
    for host in made:
        if findings := validate(host.solid):
            text = f"{building.id}: the block behind its facades is not valid ({findings[0].message})"
            return Failed("S306", text, "give a city model")
    names = ("", *(f"{building.id}-{k}" for k in range(2, len(made) + 1)))
    return Coarse("cloud", made, names, why)


def part_of(hosts: Sequence[Host], facade: Facade, options: BuildOptions) -> int | None:
    """The number of the host with the largest wall under a facade; None: none has any."""
    seen = FacadeReliefs(facade.id, facade.frame, facade.outline, ())
    size = [sum(p.area for w in find_walls(h.solid, seen, options) for p in w.polygons) for h in hosts]
    best = max(range(len(hosts)), key=lambda k: size[k])
    return best if size[best] > 0 else None


def _meets(coarse: Coarse, facades: Sequence[Facade], options: BuildOptions) -> bool:
    return any(part_of(coarse.hosts, f, options) is not None for f in facades)


def _from_model(building: Building, shells: Sequence[Shell], world: WorldRef) -> Coarse | Failed:
    """A host per part of the model; a part that does not close becomes a block over its ground."""
    parts: dict[str, list[Surface]] = {}
    for shell in shells:
        if not shell.installation:
            parts.setdefault(shell.part, []).extend(shell.surfaces)
    hosts, names, notes = [], [], []
    trouble: Failed | None = None
    for name, surfaces in parts.items():
        made = _host(name or building.id, surfaces, world)
        if isinstance(made, Failed):
            trouble = made
            notes.append(made.message)
            continue
        hosts.append(made)
        names.append(name)
    if not hosts:
        return trouble or Failed("S302", f"{building.id}: the city model holds no polygons of it")
    return Coarse("model", tuple(hosts), tuple(names), tuple(notes))


def _from_ground(
    building: Building, facades: Sequence[Facade], shells: Sequence[Shell], world: WorldRef
) -> Coarse | Failed:
    """The model's plan between the foot and the top of the facades: its heights mean nothing, as on maps."""
    if not facades:
        return Failed("S305", f"{building.id}: no facade that says how high it is")
    low, high = _heights(facades, building.ground_z)
    hosts: list[Host] = []
    names: list[str] = []
    for shell in shells:
        for s in shell.surfaces:
            if s.semantics == "GroundSurface" and not shell.installation:
                rings = [np.column_stack([r[:, :2], np.full(len(r), low)]) for r in (s.ring, *s.holes)]
                ground = Surface(rings[0], s.semantics, s.source_id, tuple(rings[1:]))
                made = ground_block(building.id, [ground], world, high)
                if isinstance(made, Host) and not validate(made.solid):
                    hosts.append(made)
                    names.append(shell.part or (building.id if names else ""))
    if not hosts:
        return Failed("S302", f"{building.id}: the city model has no usable ground polygon")
    note = f"{building.id}: the model gives the plan, the facades the heights of the block"
    return Coarse("model", tuple(hosts), tuple(names), (note,))


def _host(name: str, surfaces: Sequence[Surface], world: WorldRef) -> Host | Failed:
    """A valid host: the polygons as they are, under a lid, or the ground pulled up to the walls' tops."""
    made = host_solid(name, surfaces, world, lid=True)
    if isinstance(made, Host) and not validate(made.solid):
        return made
    block = ground_block(name, surfaces, world)
    if isinstance(block, Host) and not validate(block.solid):
        why = made.message if isinstance(made, Failed) else f"{name}: the city model's solid is not valid"
        return Host(block.solid, (why, *block.notes))
    if isinstance(made, Failed):
        return made
    return Failed("S306", f"{name}: the city model's solid is not valid", "repair the model")


def _heights(facades: Sequence[Facade], ground_z: float) -> tuple[float, float]:
    """The lowest and the highest point of the facades' outlines, m local."""
    rings = [np.insert(clean_outline(f, ground_z), 1, 0.0, axis=1) for f in facades]
    z = np.concatenate([f.frame.apply(r)[:, 2] for f, r in zip(facades, rings, strict=True)])
    return float(z.min()), float(z.max())
