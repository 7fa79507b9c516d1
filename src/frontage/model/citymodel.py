"""A city model: buildings as shells of polygons with classes, in local metres."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from frontage.model.building import Surface
from frontage.model.estimate import Failed
from frontage.model.world import WorldRef


@dataclass(frozen=True, eq=False)
class Shell:
    """One geometry of a building: level of detail ("2.2", "3.3"), polygons in local m seen counter-clockwise
    from outside, and attributes of single polygons by their `source_id`. `closed` = a solid's outer shell."""

    lod: str
    surfaces: tuple[Surface, ...]
    about: Mapping[str, Mapping[str, str | float | int]] = field(default_factory=dict)
    closed: bool = True


@dataclass(frozen=True, eq=False)
class CityBuilding:
    """A building of a city model: id, address ("13 Station Road"), shells, attributes of the whole."""

    id: str
    shells: tuple[Shell, ...]
    address: str | None = None
    attributes: Mapping[str, str | float | int] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class CityModel:
    """Buildings in the local frame of `world`; `problems` says what could not be used, per building."""

    buildings: tuple[CityBuilding, ...]
    world: WorldRef
    problems: tuple[Failed, ...] = ()
