"""Doors of balconies: a balcony hides the lower part of the opening that leads to it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.model.estimate import Provenance
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY
from frontage.model.opening import Opening, OpeningKind, Protrusion, ProtrusionKind
from frontage.openings.boxes import Box
from frontage.openings.protrusions.beams import FacadeBeams

# m from the underside of a balcony to the foot of the door (slab, threshold), and its error
_FLOOR, _SIGMA = 0.2, 0.06
_LEAST = MASONRY.door_height - 2.0 * _SIGMA  # m from a floor that errs to the head of a door
_BESIDE = 0.1  # m that an opening may reach beyond the balcony
_NARROW = 0.6  # m, least width of a door
_RISE = 1.5  # m of wall hidden above a rail per m that it stands out: seen from below at 56 degrees
_CORE = 0.15  # share of the width that is left out at either side
_FEW = 3  # beams that show wall: fewer may be strays
_MARGIN = 0.1  # m above the floor and below the opening's foot that are left out


def with_balcony_doors(
    openings: Sequence[Opening], protrusions: Sequence[Protrusion], beams: FacadeBeams, facade: Facade
) -> tuple[Opening, ...]:
    """Returns the openings, those that lead to a balcony as doors that reach down to its floor.

    An opening leads to a balcony that stands before its foot where no beam shows wall between that foot and
    the floor, and where no other opening lies there. A foot that is known as well as the floor is known from
    other openings of its row. It stays, unless this is the only opening that leads there, because a balcony
    has a door. Of several, each may be the door, so that a foot which only other openings tell may as well
    lie on the floor, and its standard error says so. The same holds where all would be lower than a door, by
    more than the floor may err. The lower border of a door is inferred: its error is that of the floor, and
    one border of four counts less in the confidence.
    """
    balconies = [p for p in protrusions if p.kind is ProtrusionKind.BALCONY]
    lowered: dict[int, Opening] = {}
    for balcony in balconies:
        told = ((k, _floor(o, balcony, beams, facade)) for k, o in enumerate(openings))
        floors = {k: z for k, z in told if z is not None and not _is_taken(z, openings[k], openings)}
        high = [k for k, z in floors.items() if openings[k].ring[:, 1].max() - z > _LEAST]
        for k in high or floors:
            if high and (len(high) == 1 or not _is_known(openings[k])):
                lowered.setdefault(k, _lowered(openings[k], floors[k]))
            elif not high or openings[k].provenance is not Provenance.MEASURED:
                lowered.setdefault(k, _doubted(openings[k], floors[k]))
    return tuple(lowered.get(k, o) for k, o in enumerate(openings))


def _floor(opening: Opening, balcony: Protrusion, beams: FacadeBeams, facade: Facade) -> float | None:
    """Returns the height z m of the floor of a balcony that an opening leads to, None if it does not."""
    x0, z0, x1, z1 = _box(opening.ring)
    if opening.on or len(_foot(opening)) < 2 or x1 - x0 < _NARROW:
        return None
    a, low, b, high = _box(balcony.ring)
    floor = low + _FLOOR
    hidden = high + _RISE * abs(float(balcony.front.value))
    beside = x0 > a - _BESIDE and x1 < b + _BESIDE
    if not beside or not low - _BESIDE <= z0 <= hidden or z1 < high:
        return None
    return None if _shows_wall(beams, (x0, floor + _MARGIN, x1, z0 - _MARGIN), facade) else floor


def _is_taken(floor: float, opening: Opening, openings: Sequence[Opening]) -> bool:
    """Returns whether another opening lies between the foot of an opening and a floor at z m."""
    x0, z0, x1, _ = _box(opening.ring)
    boxes = (_box(other.ring) for other in openings if other is not opening)
    return any(a < x1 and x0 < c and b < z0 and floor < d for a, b, c, d in boxes)


def _foot(opening: Opening) -> Int:
    """Returns the numbers of the lowest vertices of an opening."""
    z = opening.ring[:, 1]
    return np.flatnonzero(z < z.min() + 1e-6)


def _is_known(opening: Opening) -> bool:
    """Returns whether the standard error of the foot of an opening is below that of a balcony's floor."""
    return bool((np.diag(opening.ring_covariance)[2 * _foot(opening) + 1] < _SIGMA**2).all())


def _shows_wall(beams: FacadeBeams, box: Box, facade: Facade) -> bool:
    """Returns whether more beams ended on the wall in a box, without its sides, than went through it."""
    x0, z0, x1, z1 = box
    core = (x0 + _CORE * (x1 - x0), z0, x1 - _CORE * (x1 - x0), z1)
    if z1 <= z0:
        return False
    _, depth = beams.at(0.0, core, 0.0)
    near = 3.0 * facade.roughness
    on, through = int((np.abs(depth) <= near).sum()), int((depth > near).sum())
    return on >= _FEW and on > through


def _lowered(opening: Opening, floor: float) -> Opening:
    """Returns the opening as a door with its foot on the floor at z m; a foot measured there stays."""
    if _is_known(opening) and abs(float(opening.ring[:, 1].min()) - floor) < 2.0 * _SIGMA:
        return replace(opening, kind=OpeningKind.DOOR)
    ring = opening.ring.copy()
    ring[_foot(opening), 1] = floor
    return replace(
        opening,
        kind=OpeningKind.DOOR,
        ring=ring,
        ring_covariance=_with_foot_error(opening, _SIGMA),
        confidence=0.75 * opening.confidence,
    )


def _doubted(opening: Opening, floor: float) -> Opening:
    """Returns the opening with a foot that lies on the floor at z m with equal probability."""
    apart = float(opening.ring[:, 1].min()) - floor
    error = float(np.hypot(_SIGMA, apart / np.sqrt(2.0)))
    return replace(opening, ring_covariance=_with_foot_error(opening, error))


def _with_foot_error(opening: Opening, sigma: float) -> Float:
    """Returns the covariance (2k, 2k) m2 of a ring whose foot is known to `sigma` m."""
    covariance, index = opening.ring_covariance.copy(), 2 * _foot(opening) + 1
    covariance[index, :] = covariance[:, index] = 0.0
    covariance[np.ix_(index, index)] = sigma**2  # the whole foot errs together
    return covariance


def _box(ring: Float) -> Box:
    """Returns the bounding box of a ring."""
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    return float(x0), float(z0), float(x1), float(z1)
