"""A city model: buildings as shells of polygons with semantic classes, in local metres."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.building import Surface
from frontage.model.estimate import Failed
from frontage.model.world import WorldRef

FRAME = "window frame"
"""The attribute `kind` of a window's frame with its bars, which is an object of its own in city models."""


@dataclass(frozen=True, eq=False)
class Texture:
    """A texture on a polygon, by reference.

    image  path or URL of the picture, as the file names it
    rings  texture coordinates (k, 2) of every ring, the outer one first; 0..1, to the right and up
    """

    image: str
    rings: tuple[Float, ...]


@dataclass(frozen=True, eq=False)
class Shell:
    """One geometry of a building.

    lod           level of detail, such as "2.2" or "3.3"
    surfaces      polygons, counter-clockwise as seen from outside
    about         attributes of single polygons, by their `source_id`
    closed        whether it is the outer shell of a solid
    part          id of the building part or installation that it belongs to; "" = the building itself
    installation  whether it is an installation (balcony, chimney, stairs) and not a part of the body
    frame_of      id of the opening whose frame and bars these are; "" = they are something else
    textures      by `source_id`
    attributes    of the part or installation; empty for the building itself
    """

    lod: str
    surfaces: tuple[Surface, ...]
    about: Mapping[str, Mapping[str, str | float | int]] = field(default_factory=dict)
    closed: bool = True
    part: str = ""
    installation: bool = False
    textures: Mapping[str, Texture] = field(default_factory=dict)
    attributes: Mapping[str, str | float | int] = field(default_factory=dict)
    frame_of: str = ""

    def __post_init__(self) -> None:
        if self.frame_of and not self.installation:
            raise ValueError("the frame of a window is an installation, not a part of the body")


@dataclass(frozen=True, eq=False)
class CityBuilding:
    """A building of a city model: id, shells, address ("13 Station Road"), attributes of the whole."""

    id: str
    shells: tuple[Shell, ...]
    address: str | None = None
    attributes: Mapping[str, str | float | int] = field(default_factory=dict)

    def level(self, finest: str = "9") -> tuple[Shell, ...]:
        """Returns the shells of the finest level of detail that is not above `finest`, parts included.

        "2" includes 2.0 to 2.9. Where every level is finer, the coarsest one is returned.
        """
        levels = sorted({_number(s.lod) for s in self.shells})
        fitting = [v for v in levels if v < np.floor(_number(finest)) + 1.0]
        chosen = fitting[-1] if fitting else levels[0] if levels else 0.0
        return tuple(s for s in self.shells if _number(s.lod) == chosen)


@dataclass(frozen=True, eq=False)
class CityModel:
    """Buildings in the local frame of `world`.

    problems  what could not be used, by building
    notes     what had to be assumed or changed, such as a transformation or the order of the axes
    """

    buildings: tuple[CityBuilding, ...]
    world: WorldRef
    problems: tuple[Failed, ...] = ()
    notes: tuple[str, ...] = ()

    def bounds(self) -> Float:
        """Returns the lowest and highest corner (2, 3) m local. Raises ValueError without any polygon."""
        rings = [s.ring for b in self.buildings for shell in b.shells for s in shell.surfaces]
        if not rings:
            raise ValueError("the city model has no polygons")
        points = np.concatenate(rings)
        return np.stack([points.min(0), points.max(0)])


def _number(lod: str) -> float:
    """Returns a level of detail as a number; 0 where the file does not state one."""
    try:
        return float(lod)
    except ValueError:
        return 0.0
