"""What a building information model consists of: bodies that stand in the frame of a facade."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3

Value = str | float | int | None


@dataclass(frozen=True, eq=False)
class Body:
    """A prism that goes straight back from an outline.

    ring         (k, 2) m (x, z) in the facade frame, counter-clockwise as seen from the street
    front, back  y of its ends in the facade frame, m
    """

    ring: Float
    front: float
    back: float


@dataclass(frozen=True, eq=False)
class Void:
    """An opening or a recess in a part.

    kind     of its filling: "window", "door", "gate"; "" = nothing fills it
    filling  the body of the window or door
    recess   whether it has a bottom, instead of going through
    about    what is known of it; values that are None are left out
    """

    id: str
    body: Body
    kind: str = ""
    filling: Body | None = None
    recess: bool = False
    about: Mapping[str, Value] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Part:
    """A wall, or something on it.

    kind  "wall", or what a thing on the wall is, such as "balcony"
    """

    id: str
    kind: str
    frame: Rigid3
    body: Body
    voids: tuple[Void, ...] = ()
    about: Mapping[str, Value] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class BimBuilding:
    """A building with its parts."""

    id: str
    address: str | None
    parts: tuple[Part, ...]
