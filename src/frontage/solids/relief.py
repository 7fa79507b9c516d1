"""Reliefs: what is cut into a wall or stands in front of it, and the solid that results."""

from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Float, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model import Failed, Solid


@dataclass(frozen=True, eq=False)
class Relief:
    """A part of a facade that has a surface of its own: recessed, protruding or flush with its surroundings.

    ring       (k, 2) m (x, z) in the facade frame
    depth      m behind the surrounding surface, negative = protrusion; None = flush, only a face of its own
    semantics  CityGML class of its surface: "Window", "Door", or "WallSurface" for a protrusion or a niche
    inside     reliefs on its own surface, whose depth counts from that surface
    """

    id: str
    ring: Float
    depth: float | None
    semantics: str = "Window"
    inside: tuple["Relief", ...] = ()

    def __post_init__(self) -> None:
        freeze(self, ring=((None, 2), np.float64))


def names_of(relief: Relief) -> list[str]:
    """Returns the ids of a relief and of all reliefs on it."""
    return [relief.id, *(name for r in relief.inside for name in names_of(r))]


@dataclass(frozen=True, eq=False)
class FacadeReliefs:
    """A facade as the solid builder needs it: id, measured frame, outline (k, 2) m (x, z) and reliefs.

    Where two reliefs overlap, the earlier one is kept whole.
    """

    id: str
    local_from_facade: Rigid3
    outline: Float
    reliefs: tuple[Relief, ...]

    def __post_init__(self) -> None:
        freeze(self, outline=((None, 2), np.float64))


@dataclass(frozen=True, eq=False)
class Built:
    """A solid with its reliefs.

    solid     the fine solid; `host` itself where nothing could be cut
    host      the coarse solid, after re-seating if that was asked for; it is the LoD2 of the building
    offsets   relief id -> mean distance (m) from the measured plane to the wall that the relief was put in;
              positive = the wall lies further into the building
    failed    reliefs that are not in the solid, and why
    notes     what was changed while building
    """

    solid: Solid
    host: Solid
    offsets: dict[str, float] = field(default_factory=dict)
    failed: tuple[Failed, ...] = ()
    notes: tuple[str, ...] = ()
