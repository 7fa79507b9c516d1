"""What the city model writers take: buildings as closed shells of polygons with classes."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from frontage.model import Surface


@dataclass(frozen=True, eq=False)
class Shell:
    """A closed outer shell: level of detail ("2.2", "3.3"), polygons in local m seen counter-clockwise from
    outside, and attributes of single polygons by their `source_id`."""

    lod: str
    surfaces: tuple[Surface, ...]
    about: Mapping[str, Mapping[str, str | float | int]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class CityBuilding:
    """A building of a city model: id, address ("13 Station Road"), shells, attributes of the whole."""

    id: str
    shells: tuple[Shell, ...]
    address: str | None = None
    attributes: Mapping[str, str | float | int] = field(default_factory=dict)


def split_address(address: str) -> tuple[str, str]:
    """Number ("" where there is none) and street of an address, the number first or last."""
    words = address.split()
    if len(words) > 1 and words[0][0].isdigit():
        return words[0], " ".join(words[1:])
    if len(words) > 1 and words[-1][0].isdigit():
        return words[-1], " ".join(words[:-1])
    return "", address
