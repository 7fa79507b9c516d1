"""What a protrusion is: by its size, how far it stands out, where it is and how much of it beams pass."""

from collections.abc import Sequence
from dataclasses import dataclass

from frontage.model.facade import Facade
from frontage.model.opening import Opening, ProtrusionKind
from frontage.openings.protrusions.boxes import Box

_STOREY = 1.7  # m: lower than a person, nothing is a room
_RAIL = 0.6  # m, least height of balconies from the underside of the slab to the rail
_FEET = 0.6  # m, least width of a balcony
_ROOF = 0.4  # m that awnings stand out at least: hoods above windows do less
_STAND = 0.25  # m, least depth of a balcony
_SLAB = 0.8  # m: cornices and bands are lower
_LONG = 4.0  # times its height that a band is wide
_MOST = 0.5  # share of the facade's width that cornices and bands run along
_TOP = 1.0  # m below the wall's top
_POROUS = 0.6  # share of the beams that a railing stops at most
_STEP = 0.4  # m above the ground: what begins lower stands on it
_WALK = 1.8  # m above the ground: people walk below balconies and awnings
_NARROW = 3.0  # times its width that a pilaster is high
_NEAR = 0.25  # m between a slab or sill and the opening that it belongs to


@dataclass(frozen=True)
class Look:
    """What kinds are told by: box m, projection m, share of beams that the front stops, no upright front."""

    box: Box
    projection: float
    hit: float
    inclined: bool

    @property
    def size(self) -> tuple[float, float]:
        """Width and height m."""
        return self.box[2] - self.box[0], self.box[3] - self.box[1]


def kind_of_protrusion(
    look: Look, facade: Facade, ground: float, openings: Sequence[Opening]
) -> ProtrusionKind:
    """ "balcony", "oriel", "bay" (an oriel from the ground on), "risalit" (one most of the facade wide, or
    too shallow for a room), "cornice", "band", "sill", "pilaster", "railing", "awning", "steps", "plinth";
    else ProtrusionKind.OTHER.
    """
    width, height = look.size
    if look.box[1] < ground + _STEP and height < _STOREY:
        return (
            ProtrusionKind.PLINTH
            if width > _MOST * _width(facade) and look.projection < _STAND
            else ProtrusionKind.STEPS
        )
    if height >= _STOREY:
        if height > _NARROW * width and width < _SLAB:
            return ProtrusionKind.PILASTER if look.projection < _SLAB / 2 else ProtrusionKind.OTHER
        stands, wide = look.box[1] <= ground + _STEP, width > _MOST * _width(facade)
        if look.projection < _STAND:  # no room: a part of the wall, or the surround of a window
            return ProtrusionKind.AVANT_CORPS if stands or wide else ProtrusionKind.OTHER
        return (
            ProtrusionKind.ORIEL if not stands else ProtrusionKind.AVANT_CORPS if wide else ProtrusionKind.BAY
        )
    if height <= _SLAB and width >= _LONG * height and (height < _RAIL or look.projection < _STAND):
        return _of_bands(look, facade, ground, openings)
    if look.inclined and look.projection >= _ROOF:
        return ProtrusionKind.AWNING
    if height >= _RAIL and width >= _FEET:
        if look.projection >= _STAND:
            return ProtrusionKind.BALCONY
        return ProtrusionKind.RAILING if look.hit < _POROUS else ProtrusionKind.OTHER
    return ProtrusionKind.OTHER


def _of_bands(look: Look, facade: Facade, ground: float, openings: Sequence[Opening]) -> ProtrusionKind:
    """The kind of something long and low."""
    x0, z0, x1, z1 = look.box
    if facade.extent[3] - z1 < _TOP:
        return ProtrusionKind.CORNICE
    if look.size[0] > _MOST * _width(facade):
        return ProtrusionKind.BAND
    feet = [o.ring[:, 1].min() for o in openings if o.ring[:, 0].min() < x1 and o.ring[:, 0].max() > x0]
    carries = any(z0 - _NEAR <= foot <= z1 + _NEAR for foot in feet)
    if look.projection >= _STAND and carries:
        return ProtrusionKind.STEPS if z0 < ground + _WALK else ProtrusionKind.BALCONY
    if look.projection >= _ROOF and z0 >= ground + _WALK:
        return ProtrusionKind.AWNING
    return ProtrusionKind.SILL if carries else ProtrusionKind.BAND


def _width(facade: Facade) -> float:
    return facade.extent[2] - facade.extent[0]
