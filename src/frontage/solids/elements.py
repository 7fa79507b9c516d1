"""What was found on a facade as reliefs of its wall: which parts shape the solid, which only hang on it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float
from frontage.model import Elements, Facade, Opening, Protrusion, ProtrusionKind
from frontage.solids.relief import FacadeReliefs, Relief

_YIELDING = (
    ProtrusionKind.PLINTH,
    ProtrusionKind.PILASTER,
)  # bodies that go round openings; the others hide what is behind them
_MOST = 0.5  # share of an opening that lies on a body


@dataclass(frozen=True, eq=False)
class FacadeParts:
    """A facade's reliefs, and the protrusions that hang on it without being a part of the body."""

    reliefs: FacadeReliefs
    attached: tuple[Protrusion, ...] = ()


def facade_parts(facade: Facade, elements: Elements, chord_error: float) -> FacadeParts:
    """Openings become recesses at their measured depth, flush faces where none was measured.

    A protrusion of the body, and whatever is set back or carries openings, is a relief with the
    openings that lie on it inside; depths count from the surface that an opening stands in. A plinth or
    pilaster goes round the openings that reach into it. All other protrusions are `attached`. Rings lose the
    vertices that a chord within `chord_error` (m) of them replaces.
    """
    carrying = {o.on for o in elements.openings}
    chosen = [p for p in elements.protrusions if is_body(p) or p.id in carrying]
    bodies = sorted(chosen, key=lambda p: -_area(p).area)
    below = _homes(bodies, bodies)
    inside = _homes(elements.openings, bodies)

    def on(number: int | None) -> tuple[Relief, ...]:
        """What lies on a body, or on the wall: bodies first, they are the larger pieces."""
        front = 0.0 if number is None else float(bodies[number].front.value)
        found: list[Relief] = []
        for k, p in enumerate(bodies):
            if below[k] == number:
                others = [o for o, h in zip(elements.openings, inside, strict=True) if h == number]
                deep = float(p.front.value) - front
                for name, ring in _around(p, others):
                    own = on(k) if name == p.id else ()
                    found.append(Relief(name, _plain(ring, chord_error), deep, "WallSurface", own))
        openings = [o for o, h in zip(elements.openings, inside, strict=True) if h == number]
        return (*found, *(_relief(o, chord_error) for o in openings))

    attached = tuple(p for p in elements.protrusions if p not in chosen)
    return FacadeParts(FacadeReliefs(facade.id, facade.frame, facade.outline, on(None)), attached)


def is_body(protrusion: Protrusion) -> bool:
    """Whether a protrusion shapes the building's body: by its kind, or because it is set back."""
    return protrusion.kind.is_body or float(protrusion.front.value) > 0


def semantics_of(opening: Opening) -> str:
    """The semantic class of the surface that closes an opening: Window or Door."""
    return opening.kind.surface.semantics


def _relief(opening: Opening, chord_error: float) -> Relief:
    depth = None if opening.depth is None else float(opening.depth.value)
    return Relief(opening.id, _plain(opening.ring, chord_error), depth, semantics_of(opening))


def _homes(
    things: Sequence[Opening] | Sequence[Protrusion], bodies: Sequence[Protrusion]
) -> list[int | None]:
    """For every thing the body it says it is on, else the smallest larger one that holds most of it; None:
    it stands in the wall."""
    areas = [_area(p) for p in bodies]
    names = {p.id: k for k, p in enumerate(bodies)}
    found: list[int | None] = []
    for thing in things:
        if isinstance(thing, Opening) and thing.on in names:
            found.append(names[thing.on])
            continue
        ring = _area(thing)
        larger = [k for k, a in enumerate(areas) if a.area > ring.area]
        holding = [k for k in larger if areas[k].intersection(ring).area > _MOST * ring.area]
        found.append(min(holding, key=lambda k: float(areas[k].area)) if holding else None)
    return found


def _around(body: Protrusion, openings: Sequence[Opening]) -> list[tuple[str, Float]]:
    """The ring of a plinth or pilaster without the openings beside it, any other body's ring as it is.

    Its pieces, largest first, with their names.
    """
    ring = _area(body)
    if body.kind not in _YIELDING:
        return [(body.id, body.ring)]
    cut = [a for o in openings if (a := _area(o)).intersects(ring) and not a.contains(ring)]
    if not cut or not ring.intersects(shapely.union_all(cut)):
        return [(body.id, body.ring)]
    rest = shapely.get_parts(ring.difference(shapely.union_all(cut)))
    pieces = sorted((p for p in rest if isinstance(p, Polygon)), key=lambda p: -float(p.area))
    names = [body.id, *(f"{body.id}-{k}" for k in range(2, len(pieces) + 1))]
    return [(n, np.asarray(p.exterior.coords)[:-1]) for n, p in zip(names, pieces, strict=True) if p.area > 0]


def _area(thing: Opening | Protrusion) -> BaseGeometry:
    return shapely.make_valid(Polygon(thing.ring))


def _plain(ring: Float, chord_error: float) -> Float:
    """A ring (k, 2) with fewer vertices, all within `chord_error` m of it; rings of four stay.

    Of one that crosses itself the largest part.
    """
    if not Polygon(ring).is_valid:
        parts = shapely.get_parts(shapely.make_valid(Polygon(ring)))
        areas = [p for p in parts if isinstance(p, Polygon)]
        if not areas:
            return ring
        ring = np.asarray(max(areas, key=lambda p: float(p.area)).exterior.coords, np.float64)[:-1]
    if len(ring) <= 4:
        return ring
    plain = Polygon(ring).simplify(chord_error)
    if not isinstance(plain, Polygon) or plain.is_empty or not plain.is_valid:
        return ring
    return np.asarray(plain.exterior.coords, np.float64)[:-1]
