"""Sorts what was found on a facade into reliefs, which shape the solid, and parts attached to it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float
from frontage.model import Elements, Estimate, Facade, Opening, Protrusion, ProtrusionKind
from frontage.solids.relief import FacadeReliefs, Relief

# Kinds that openings interrupt; other volumes hide what is behind them.
_INTERRUPTED_KINDS = (ProtrusionKind.PLINTH, ProtrusionKind.PILASTER)
_MIN_SHARE = 0.5  # share of an opening's area that must lie on a volume for the opening to stand on it


@dataclass(frozen=True, eq=False)
class FacadeParts:
    """The reliefs of a facade, and the protrusions that are attached to it as installations."""

    reliefs: FacadeReliefs
    attached: tuple[Protrusion, ...] = ()


def facade_parts(facade: Facade, elements: Elements, chord_error: float) -> FacadeParts:
    """Turns the elements of a facade into reliefs and attached protrusions.

    Openings become recesses of their measured depth, or flush faces where no depth was measured. A protrusion
    that belongs to the building's volume, is set back, or carries openings becomes a relief that holds the
    openings on it; their depths count from its front. Openings interrupt a plinth or pilaster. All
    other protrusions are `attached`. Rings lose the vertices that a chord within `chord_error` (m) replaces.
    """
    carriers = {o.on for o in elements.openings}
    chosen = [p for p in elements.protrusions if is_volume(p) or p.id in carriers]
    volumes = sorted(chosen, key=lambda p: -_area(p).area)
    carrier_of_volume = _carriers(volumes, volumes)
    carrier_of_opening = _carriers(elements.openings, volumes)

    def reliefs_on(carrier: int | None) -> tuple[Relief, ...]:
        """Returns the reliefs on a volume, or on the wall (None): volumes first, they are the larger ones."""
        front = 0.0 if carrier is None else float(volumes[carrier].front.value)
        openings = [o for o, c in zip(elements.openings, carrier_of_opening, strict=True) if c == carrier]
        found: list[Relief] = []
        for k, volume in enumerate(volumes):
            if carrier_of_volume[k] == carrier:
                depth = float(volume.front.value) - front
                for name, ring in _uninterrupted_pieces(volume, openings):
                    inside = reliefs_on(k) if name == volume.id else ()
                    found.append(Relief(name, _simplified(ring, chord_error), depth, "WallSurface", inside))
        return (*found, *(_opening_relief(o, chord_error) for o in openings))

    attached = tuple(p for p in elements.protrusions if p not in chosen)
    return FacadeParts(FacadeReliefs(facade.id, facade.frame, facade.outline, reliefs_on(None)), attached)


def is_volume(protrusion: Protrusion) -> bool:
    """Decides whether a protrusion shapes the building's volume: by its kind, or because it is set back."""
    return protrusion.kind.is_body or float(protrusion.front.value) > 0


def semantics_of(opening: Opening) -> str:
    """Returns the CityGML class of an opening: "Door" or "Window"."""
    return opening.kind.surface.semantics


def depth_of(opening: Opening) -> Estimate[float] | None:
    """Returns the depth of an opening, or that of its frame in the photos where only this was measured."""
    if opening.depth is None and opening.glazing is not None:
        return opening.glazing.depth
    return opening.depth


def _opening_relief(opening: Opening, chord_error: float) -> Relief:
    estimate = depth_of(opening)
    depth = None if estimate is None else float(estimate.value)
    return Relief(opening.id, _simplified(opening.ring, chord_error), depth, semantics_of(opening))


def _carriers(
    things: Sequence[Opening] | Sequence[Protrusion], volumes: Sequence[Protrusion]
) -> list[int | None]:
    """Returns for every element the index of the volume that it stands on; None = the wall itself.

    That is the volume an opening names, else the smallest larger volume that holds most of the element.
    """
    areas = [_area(p) for p in volumes]
    index = {p.id: k for k, p in enumerate(volumes)}
    found: list[int | None] = []
    for thing in things:
        if isinstance(thing, Opening) and thing.on in index:
            found.append(index[thing.on])
            continue
        ring = _area(thing)
        larger = [k for k, a in enumerate(areas) if a.area > ring.area]
        holding = [k for k in larger if areas[k].intersection(ring).area > _MIN_SHARE * ring.area]
        found.append(min(holding, key=lambda k: float(areas[k].area)) if holding else None)
    return found


def _uninterrupted_pieces(volume: Protrusion, openings: Sequence[Opening]) -> list[tuple[str, Float]]:
    """Returns the pieces of a plinth or pilaster between the openings beside it, largest first, with names.

    Any other volume is returned whole.
    """
    whole = [(volume.id, volume.ring)]
    ring = _area(volume)
    if volume.kind not in _INTERRUPTED_KINDS:
        return whole
    cut = [a for o in openings if (a := _area(o)).intersects(ring) and not a.contains(ring)]
    if not cut or not ring.intersects(shapely.union_all(cut)):
        return whole
    rest = shapely.get_parts(ring.difference(shapely.union_all(cut)))
    pieces = sorted((p for p in rest if isinstance(p, Polygon)), key=lambda p: -float(p.area))
    names = [volume.id, *(f"{volume.id}-{k}" for k in range(2, len(pieces) + 1))]
    return [(n, np.asarray(p.exterior.coords)[:-1]) for n, p in zip(names, pieces, strict=True) if p.area > 0]


def _area(thing: Opening | Protrusion) -> BaseGeometry:
    return shapely.make_valid(Polygon(thing.ring))


def _simplified(ring: Float, chord_error: float) -> Float:
    """Returns a ring (k, 2) with fewer vertices, all within `chord_error` m of it; quadrilaterals stay.

    Of a ring that crosses itself, the largest part is kept.
    """
    if not Polygon(ring).is_valid:
        parts = shapely.get_parts(shapely.make_valid(Polygon(ring)))
        areas = [p for p in parts if isinstance(p, Polygon)]
        if not areas:
            return ring
        ring = np.asarray(max(areas, key=lambda p: float(p.area)).exterior.coords, np.float64)[:-1]
    if len(ring) <= 4:
        return ring
    simple = Polygon(ring).simplify(chord_error)
    if not isinstance(simple, Polygon) or simple.is_empty or not simple.is_valid:
        return ring
    return np.asarray(simple.exterior.coords, np.float64)[:-1]
