"""A building from its facades: coarse solid, reliefs, fine solid, what hangs on it (paper B, section 3.2)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from shapely.geometry import Polygon

from frontage.geometry.rigid import Rigid3
from frontage.model import Building, Elements, Facade, Failed, Protrusion, WorldRef
from frontage.model.citymodel import Shell
from frontage.solids.build import build_solid
from frontage.solids.elements import FacadeParts, facade_parts
from frontage.solids.hosts import Coarse, coarse_solids, part_of
from frontage.solids.installations import Installation, installation
from frontage.solids.relief import BuildOptions, Built, Relief
from frontage.solids.validate import validate
from frontage.solids.walls import find_walls

_SAID = 3  # findings named in a warning


@dataclass(frozen=True, eq=False)
class Assembled:
    """A building's solids.

    coarse         where the host comes from
    built          one per part of the host, in its order; where `fine` is false it is the host unchanged
    installations  closed solids of their own
    failed         what is not in the model, and why
    """

    building: str
    coarse: Coarse
    built: tuple[Built, ...]
    fine: tuple[bool, ...]
    installations: tuple[Installation, ...] = ()
    failed: tuple[Failed, ...] = ()
    notes: tuple[str, ...] = ()


def assemble(
    building: Building,
    fronts: Sequence[tuple[Facade, Elements]],
    shells: Sequence[Shell],
    world: WorldRef,
    options: BuildOptions | None = None,
) -> Assembled | Failed:
    """The building's fine solids; every solid in the result has passed the validator.

    `shells`: the building in the city model, level of detail 2 or below; empty without a model. Failed where
    there is no coarse solid at all.
    """
    options = options or BuildOptions()
    coarse = coarse_solids(building, [f for f, _ in fronts], shells, world, options)
    if isinstance(coarse, Failed):
        return coarse
    parts = [facade_parts(f, e, options.chord_error) for f, e in fronts]
    home = [part_of(coarse.hosts, f, options) for f, _ in fronts]
    built, fine, failed = [], [], list[Failed]()
    for number, host in enumerate(coarse.hosts):
        own = [p.reliefs for p, h in zip(parts, home, strict=True) if (h or 0) == number]
        made = build_solid(host.solid, own, options)
        good = made if isinstance(made, Built) else Built(host.solid, host.solid, failed=(made,))
        if trouble := _findings(building.id, good):
            good = Built(host.solid, host.solid, failed=(*good.failed, trouble), notes=good.notes)
        built.append(good)
        fine.append(any(f.opening for f in good.solid.faces))
        failed += good.failed
    hung = [
        _hung(p, part, built[h or 0], world, options)
        for part, h in zip(parts, home, strict=True)
        for p in (part.attached if options.depth else ())
    ]
    failed += [i for i in hung if isinstance(i, Failed)]
    notes = [n for h in coarse.hosts for n in h.notes] + [n for b in built for n in b.notes]
    return Assembled(
        building.id,
        coarse,
        tuple(built),
        tuple(fine),
        tuple(i for i in hung if isinstance(i, Installation)),
        tuple(failed),
        (*coarse.notes, *notes),
    )


def _findings(building: str, built: Built) -> Failed | None:
    """Why a solid must not be written."""
    findings = validate(built.solid)
    if not findings:
        return None
    said = "; ".join(f"{f.code} {f.message}" for f in findings[:_SAID])
    text = (
        f"{building}: the fine solid is not valid ({len(findings)} findings: {said}); the coarse one is kept"
    )
    return Failed("S320", text, "please report this case")


def _hung(
    protrusion: Protrusion, part: FacadeParts, built: Built, world: WorldRef, options: BuildOptions
) -> Installation | Failed:
    """An installation in front of the host's wall, or of the body that it hangs on."""
    facade, ring = part.reliefs, protrusion.ring
    flat = np.insert(ring, 1, 0.0, axis=1)
    place, best = facade.local_from_facade, 0.0
    for wall in find_walls(built.host, facade, options):
        motion = wall.local_from_wall.inverse @ facade.local_from_facade
        seen = Polygon(motion.apply(flat)[:, [0, 2]]).buffer(0)
        share = sum(float(p.intersection(seen).area) for p in wall.polygons)
        if share > best:
            place, best = wall.local_from_wall, share
            ring = motion.apply(flat)[:, [0, 2]]
    place = Rigid3(place.to, "wall", place.R, place.t)
    return installation(protrusion, facade.id, place, ring, _under(protrusion, facade.reliefs), world)


def _under(protrusion: Protrusion, reliefs: Sequence[Relief]) -> float:
    """The y of the surface that a protrusion hangs on: of the body around it, else the wall's, 0."""
    centre = Polygon(protrusion.ring).representative_point()
    for relief in reliefs:
        if relief.semantics == "WallSurface" and relief.depth and Polygon(relief.ring).contains(centre):
            return relief.depth + _under(protrusion, relief.inside)
    return 0.0
