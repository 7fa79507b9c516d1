"""Builds a building's fine solids from its facades: paper B, section 3.2.3 (facade modelling).

The window cells are cut out of the existing coarse building model; where there is none, a block made from the
facades takes its place. Protrusions that do not belong to the building's volume become solids of their own.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import shapely

from frontage.model import Building, Elements, Facade, Failed, WorldRef
from frontage.model.citymodel import Shell
from frontage.solids.checks import parts_overlap
from frontage.solids.coarse.choose import CoarseModel, coarse_model
from frontage.solids.coarse.host import Host
from frontage.solids.distribute import distribute_reliefs
from frontage.solids.elements import FacadeParts, facade_parts
from frontage.solids.frames.seat import WindowFrame, window_frames
from frontage.solids.installations.apart import apart
from frontage.solids.installations.attach import attach
from frontage.solids.installations.installation import Installation
from frontage.solids.options import BuildOptions
from frontage.solids.relief import Built, FacadeReliefs
from frontage.solids.sound import sound_solid


@dataclass(frozen=True, eq=False)
class Assembled:
    """The solids of a building.

    coarse         the coarse solids, and where they come from
    built          one solid per part of the coarse model, in its order
    fine           for each of `built`, whether anything was cut; if not, it is the coarse solid unchanged
    installations  solids of their own, in front of the walls
    frames         window frames with their bars, solids of their own in the openings
    failed         what is not in the model, and why
    notes          what was changed while building
    parts_overlap  whether the solids reach into each other, so that they cannot be parts of one building
    """

    building: str
    coarse: CoarseModel
    built: tuple[Built, ...]
    fine: tuple[bool, ...]
    installations: tuple[Installation, ...] = ()
    failed: tuple[Failed, ...] = ()
    notes: tuple[str, ...] = ()
    parts_overlap: bool = False
    frames: tuple[WindowFrame, ...] = ()


def assemble(
    building: Building,
    facades: Sequence[tuple[Facade, Elements]],
    shells: Sequence[Shell],
    world: WorldRef,
    options: BuildOptions | None = None,
) -> Assembled | Failed:
    """Builds the fine solids of a building; every solid in the result has passed the validator.

    `facades` are its facades with what was found on them, `shells` the building in the city model at LoD2 or
    below (empty without a model); both in the local frame of `world`. Returns S302, S304, S305 or S306 if
    there is no coarse solid to build from.
    """
    options = options or BuildOptions()
    facades = _largest_first(facades)
    openings = {f.id: [o.ring for o in e.openings] for f, e in facades}
    coarse = coarse_model(building, [f for f, _ in facades], shells, world, options, openings)
    if isinstance(coarse, Failed):
        return coarse
    parts = [facade_parts(f, e, options.chord_error) for f, e in facades]
    built = [sound_solid(building.id, h.solid, own, options) for h, own in _by_host(coarse, parts, options)]
    installed = [i for p in parts for i in _installations(p, built, world, options)]
    collected = _collected(building.id, coarse, built, installed)
    frames, notes = window_frames(built, facades, world, options)
    return replace(collected, frames=tuple(frames), notes=(*collected.notes, *notes))


def _largest_first(facades: Sequence[tuple[Facade, Elements]]) -> list[tuple[Facade, Elements]]:
    """Sorts facades by area, so that an oriel's front wall is built before the facades of its cheeks."""
    return sorted(facades, key=lambda f: -shapely.Polygon(f[0].outline).area)


def _by_host(
    coarse: CoarseModel, parts: Sequence[FacadeParts], options: BuildOptions
) -> list[tuple[Host, list[FacadeReliefs]]]:
    """Returns every host with the reliefs of all facades that go into it."""
    solids = [h.solid for h in coarse.hosts]
    shares = [distribute_reliefs(p.reliefs, solids, options) for p in parts]
    return [(h, [share[k] for share in shares]) for k, h in enumerate(coarse.hosts)]


def _installations(
    part: FacadeParts, built: Sequence[Built], world: WorldRef, options: BuildOptions
) -> list[Installation | Failed | str]:
    """Returns the installations of a facade; none in a model without depth."""
    return attach(part, built, world, options) if options.depth else []


def _collected(
    building: str,
    coarse: CoarseModel,
    built: Sequence[Built],
    installed: Sequence[Installation | Failed | str],
) -> Assembled:
    """Puts solids, installations, failures and notes together."""
    failed = [f for b in built for f in b.failed] + [i for i in installed if isinstance(i, Failed)]
    installations, opened = apart([i for i in installed if isinstance(i, Installation)], built)
    notes = [n for h in coarse.hosts for n in h.notes] + [n for b in built for n in b.notes]
    notes += [i for i in installed if isinstance(i, str)] + opened
    return Assembled(
        building,
        coarse,
        tuple(built),
        tuple(any(f.opening for f in b.solid.faces) for b in built),
        tuple(installations),
        tuple(failed),
        (*coarse.notes, *notes),
        parts_overlap(built),
    )
