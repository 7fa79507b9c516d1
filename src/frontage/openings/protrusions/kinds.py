"""The kind of a protrusion: by size, projection, place, and the share of the beams that pass it."""

from collections.abc import Sequence
from dataclasses import dataclass

from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY
from frontage.model.opening import Opening, ProtrusionKind
from frontage.openings.boxes import Box

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
_NARROW = 3.0  # times its width that a pilaster is high
_NEAR = 0.25  # m between a slab or sill and the opening that it belongs to


@dataclass(frozen=True)
class FrontFeatures:
    """What the kind of a protrusion is told by.

    box         m, its box
    projection  m that it stands out
    hit         share of the beams that its front stops
    inclined    whether it has no upright front
    """

    box: Box
    projection: float
    hit: float
    inclined: bool

    @property
    def size(self) -> tuple[float, float]:
        """Width and height m."""
        return self.box[2] - self.box[0], self.box[3] - self.box[1]


def kind_of_protrusion(
    front: FrontFeatures, facade: Facade, ground: float, openings: Sequence[Opening]
) -> ProtrusionKind:
    """Returns the kind of a protrusion.

    It is "balcony", "oriel", "bay" (an oriel from the ground on), "risalit" (an avant-corps: a bay over most
    of the facade, or one too shallow for a room), "cornice", "band", "sill", "pilaster", "railing", "awning",
    "steps", "plinth"; else "protrusion". `ground` is the height z m of the ground.
    """
    width, height = front.size
    if front.box[1] < ground + _STEP and height < MASONRY.person:
        is_plinth = width > _MOST * _width(facade) and front.projection < _STAND
        return ProtrusionKind.PLINTH if is_plinth else ProtrusionKind.STEPS
    if height >= MASONRY.person:
        if height > _NARROW * width and width < _SLAB:
            return ProtrusionKind.PILASTER if front.projection < _SLAB / 2 else ProtrusionKind.OTHER
        stands, wide = front.box[1] <= ground + _STEP, width > _MOST * _width(facade)
        if front.projection < _STAND:
            # too shallow for a room: a part of the wall, or the surround of a window
            return ProtrusionKind.AVANT_CORPS if stands or wide else ProtrusionKind.OTHER
        if not stands:
            return ProtrusionKind.ORIEL
        return ProtrusionKind.AVANT_CORPS if wide else ProtrusionKind.BAY
    if height <= _SLAB and width >= _LONG * height and (height < _RAIL or front.projection < _STAND):
        return _of_bands(front, facade, ground, openings)
    if front.inclined and front.projection >= _ROOF:
        return ProtrusionKind.AWNING
    if height >= _RAIL and width >= _FEET:
        if front.projection >= _STAND:
            return ProtrusionKind.BALCONY
        return ProtrusionKind.RAILING if front.hit < _POROUS else ProtrusionKind.OTHER
    return ProtrusionKind.OTHER


def _of_bands(
    front: FrontFeatures, facade: Facade, ground: float, openings: Sequence[Opening]
) -> ProtrusionKind:
    """Returns the kind of a front that is long and low."""
    x0, z0, x1, z1 = front.box
    if facade.extent[3] - z1 < _TOP:
        return ProtrusionKind.CORNICE
    if front.size[0] > _MOST * _width(facade):
        return ProtrusionKind.BAND
    feet = [o.ring[:, 1].min() for o in openings if o.ring[:, 0].min() < x1 and o.ring[:, 0].max() > x0]
    carries = any(z0 - _NEAR <= foot <= z1 + _NEAR for foot in feet)
    if front.projection >= _STAND and carries:
        return ProtrusionKind.STEPS if z0 < ground + MASONRY.door_height else ProtrusionKind.BALCONY
    if front.projection >= _ROOF and z0 >= ground + MASONRY.door_height:
        return ProtrusionKind.AWNING
    return ProtrusionKind.SILL if carries else ProtrusionKind.BAND


def _width(facade: Facade) -> float:
    """Returns the width m of the facade."""
    return facade.extent[2] - facade.extent[0]
