"""A building from its facades: coarse solid, reliefs, fine solid, what hangs on it (paper B, section 3.2)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from frontage.model import (
    Building,
    Elements,
    Facade,
    Failed,
    Feature,
    Polygons,
    Protrusion,
    Shape,
    Solid,
    WorldRef,
)
from frontage.model.citymodel import Shell
from frontage.solids.cells.build import build_solid
from frontage.solids.elements import FacadeParts, facade_parts
from frontage.solids.hosts.host import Host
from frontage.solids.hosts.hosts import Coarse, coarse_solids
from frontage.solids.hosts.walls import find_walls
from frontage.solids.installations import THINNEST, Installation, installation
from frontage.solids.relief import GRID, BuildOptions, Built, FacadeReliefs, Relief
from frontage.validation.validate import validate, validate_feature

_SAID = 3  # findings named in a warning


@dataclass(frozen=True, eq=False)
class Assembled:
    """A building's solids.

    coarse         where the host comes from
    built          one per part of the host, in its order; where `fine` is false it is the host unchanged
    installations  closed solids of their own
    failed         what is not in the model, and why
    apart          whether the parts reach into each other, so that they cannot be parts of one building
    """

    building: str
    coarse: Coarse
    built: tuple[Built, ...]
    fine: tuple[bool, ...]
    installations: tuple[Installation, ...] = ()
    failed: tuple[Failed, ...] = ()
    notes: tuple[str, ...] = ()
    apart: bool = False


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
    # The largest first: the cheek of an oriel is there once the front that the oriel stands on is built.
    fronts = sorted(fronts, key=lambda front: -shapely.Polygon(front[0].outline).area)
    coarse = coarse_solids(building, [f for f, _ in fronts], shells, world, options)
    if isinstance(coarse, Failed):
        return coarse
    parts = [facade_parts(f, e, options.chord_error) for f, e in fronts]
    shared = [_shared(p.reliefs, coarse.hosts, options) for p in parts]
    built = [_cut(building.id, h, [s[k] for s in shared], options) for k, h in enumerate(coarse.hosts)]
    hung = [
        _hung(p, part, [b.host for b in built], world, options)
        for part in parts
        for p in (part.attached if options.depth else ())
    ]
    failed = [f for b in built for f in b.failed] + [i for i in hung if isinstance(i, Failed)]
    notes = [n for h in coarse.hosts for n in h.notes] + [n for b in built for n in b.notes]
    notes += [i for i in hung if isinstance(i, str)]
    return Assembled(
        building.id,
        coarse,
        tuple(built),
        tuple(any(f.opening for f in b.solid.faces) for b in built),
        tuple(i for i in hung if isinstance(i, Installation)),
        tuple(failed),
        (*coarse.notes, *notes),
        _overlap(built),
    )


def _cut(building: str, host: Host, own: Sequence[FacadeReliefs], options: BuildOptions) -> Built:
    """A host with its reliefs; as it was where that is not valid."""
    made = build_solid(host.solid, own, options)
    good = made if isinstance(made, Built) else Built(host.solid, host.solid, failed=(made,))
    if trouble := _findings(building, good):
        return Built(host.solid, host.solid, failed=(*good.failed, trouble), notes=good.notes)
    return good


def _overlap(built: Sequence[Built]) -> bool:
    """601: whether solids of one level of detail overlap."""
    if len(built) < 2:
        return False
    for lod, solids in (("2", [b.host for b in built]), ("3", [b.solid for b in built])):
        parts = [_feature(s, lod) for s in solids]
        if validate_feature(Feature("whole", "Building", (), tuple(parts)), quantum=1 / GRID):
            return True
    return False


def _feature(solid: Solid, lod: str) -> Feature:
    xyz = solid.vertices / GRID
    faces = Polygons.of([[xyz[list(r)] for r in (f.ring, *f.holes)] for f in solid.faces])
    return Feature(solid.building, "BuildingPart", (Shape("Solid", ((faces,),), lod),))


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


def _shared(facade: FacadeReliefs, hosts: Sequence[Host], options: BuildOptions) -> list[FacadeReliefs]:
    """A facade's reliefs by host: each goes where the host's walls cover most of it."""
    if len(hosts) == 1:
        return [facade]
    walls = [_seen(facade, h.solid, options) for h in hosts]
    whole = max(range(len(hosts)), key=lambda k: walls[k].area)
    chosen: list[list[Relief]] = [[] for _ in hosts]
    for relief in facade.reliefs:
        ring = shapely.make_valid(Polygon(relief.ring))
        share = [float(w.intersection(ring).area) for w in walls]
        chosen[int(np.argmax(share)) if max(share) > 0 else whole].append(relief)
    return [replace(facade, reliefs=tuple(own)) for own in chosen]


def _seen(facade: FacadeReliefs, solid: Solid, options: BuildOptions) -> BaseGeometry:
    """The walls of a solid that a facade was measured on, in its frame (x, z) m."""
    back = facade.local_from_facade.inverse
    rings = [
        back.apply(solid.vertices[list(solid.faces[k].ring)] / GRID)[:, [0, 2]]
        for w in find_walls(solid, facade, options)
        for k in w.faces
    ]
    return shapely.union_all([shapely.make_valid(Polygon(r)) for r in rings])


def _hung(
    protrusion: Protrusion,
    part: FacadeParts,
    hosts: Sequence[Solid],
    world: WorldRef,
    options: BuildOptions,
) -> Installation | Failed | str:
    """An installation in front of the host's wall, or of the body that it hangs on; what does not stand out
    from that is a note."""
    facade, ring = part.reliefs, protrusion.ring
    back = _under(protrusion, facade.reliefs)
    if back - float(protrusion.front.value) < THINNEST:
        return f"{protrusion.id}: stands out by less than {THINNEST:g} m from what it is on: left out"
    flat = np.insert(ring, 1, 0.0, axis=1)
    place, best = None, -np.inf
    for wall in (w for host in hosts for w in find_walls(host, facade, options)):
        motion = wall.local_from_wall.inverse @ facade.local_from_facade
        seen = motion.apply(flat)[:, [0, 2]]
        area = shapely.make_valid(Polygon(seen * GRID))
        share = sum(float(p.intersection(area).area) for p in wall.polygons)
        # a cornice above the eaves hangs on the wall that ends below it
        share = share or -min(float(p.distance(area)) for p in wall.polygons)
        if share > best and share > -options.max_offset * GRID:
            place, best, ring = wall.local_from_wall, share, seen
    if place is None:
        return Failed("S310", f"{protrusion.id}: hangs on no wall of the host", "check the registration")
    return installation(protrusion, facade.id, place, ring, back, world)


def _under(protrusion: Protrusion, reliefs: Sequence[Relief]) -> float:
    """The y of the surface that a protrusion hangs on: of the body around it, else the wall's, 0."""
    centre = Polygon(protrusion.ring).representative_point()
    for relief in reliefs:
        if relief.semantics == "WallSurface" and relief.depth and Polygon(relief.ring).contains(centre):
            return relief.depth + _under(protrusion, relief.inside)
    return 0.0
