"""What a facade holds: openings and protrusions; the kinds of both."""

from collections import Counter
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from frontage.geometry.arrays import Float, freeze
from frontage.model.estimate import Estimate, Provenance
from frontage.model.glazing import Bar, Glazing


@dataclass(frozen=True)
class OpeningSurface:
    """How city models and drawings show the surface that closes an opening.

    semantics  the class in CityJSON and CityGML 2.0
    citygml3   the class in CityGML 3.0
    colour     linear RGB, 0..1, where no picture shows the surface
    """

    semantics: str
    citygml3: str
    colour: tuple[float, float, float]


_WINDOW = OpeningSurface("Window", "WindowSurface", (0.10, 0.16, 0.22))
_DOOR = OpeningSurface("Door", "DoorSurface", (0.20, 0.12, 0.07))
OPENING_SURFACES = {s.semantics: s for s in (_WINDOW, _DOOR)}
"""The surfaces that close openings, by their semantic class."""


class OpeningKind(StrEnum):
    """What an opening is; a new kind also takes a row of `_OPENING_KINDS`."""

    WINDOW = "window"
    DOOR = "door"
    SHOPFRONT = "shopfront"
    PASSAGE = "passage"
    GARAGE = "garage"
    BASEMENT = "basement"  # a basement window; its floor is -1
    OTHER = "other"

    @property
    def letter(self) -> str:
        """The letter in identifiers: "W" in "B07/F1/W3-2"."""
        return _OPENING_KINDS[self][0]

    @property
    def surface(self) -> OpeningSurface:
        """The surface that closes the opening in city models and drawings."""
        return _OPENING_KINDS[self][1]

    @property
    def at_ground(self) -> bool:
        """Whether the opening starts at the ground, so that its foot tells where the ground is."""
        return _OPENING_KINDS[self][2]


_OPENING_KINDS = {
    OpeningKind.WINDOW: ("W", _WINDOW, False),
    OpeningKind.DOOR: ("D", _DOOR, True),
    OpeningKind.SHOPFRONT: ("S", _WINDOW, True),
    OpeningKind.PASSAGE: ("P", _DOOR, True),
    OpeningKind.GARAGE: ("G", _DOOR, True),
    OpeningKind.BASEMENT: ("B", _WINDOW, False),
    OpeningKind.OTHER: ("O", _WINDOW, False),
}  # letter, surface, at_ground

DOORS = frozenset(kind for kind in OpeningKind if kind.surface is _DOOR)
"""The kinds of opening that people or vehicles go through: a `Door` in city models, not a `Window`."""


class ProtrusionKind(StrEnum):
    """What a protrusion is; `_WALLS` and `_BODIES` say which kinds belong to the building's body."""

    ORIEL = "oriel"
    BAY = "bay"  # an oriel that starts at the ground
    AVANT_CORPS = "risalit"  # a part of the facade that projects over most of its height or width
    SETBACK = "setback"
    NICHE = "niche"
    LOGGIA = "loggia"
    PILASTER = "pilaster"
    PLINTH = "plinth"
    BALCONY = "balcony"
    CORNICE = "cornice"
    BAND = "band"
    SILL = "sill"
    RAILING = "railing"
    AWNING = "awning"
    STEPS = "steps"
    OTHER = "protrusion"

    @property
    def is_wall(self) -> bool:
        """Whether its front is a wall of its own, which can have openings."""
        return self in _WALLS

    @property
    def is_body(self) -> bool:
        """Whether it is a part of the building's body; every other kind is an installation on it."""
        return self in _BODIES


_WALLS = frozenset(
    {
        ProtrusionKind.ORIEL,
        ProtrusionKind.BAY,
        ProtrusionKind.AVANT_CORPS,
        ProtrusionKind.SETBACK,
        ProtrusionKind.NICHE,
    }
)
_BODIES = _WALLS | {ProtrusionKind.LOGGIA, ProtrusionKind.PILASTER, ProtrusionKind.PLINTH}


@dataclass(frozen=True, eq=False)
class Opening:
    """A window, door or other opening of a facade.

    id          "B07/F1/W3-2": third floor, second from the left as seen from the street; ground floor = 0
    kind        an `OpeningKind` or its text, such as "window"
    ring        (k, 2) m (x, z) in the facade frame, counter-clockwise as seen from the street
    ring_covariance  (2k, 2k) m2 of the ring's coordinates, in the order x0, z0, x1, z1, ...
    depth       of the frame behind the wall, m, positive = recess; None when not measured
    evidence    log-likelihood ratio of opening against wall, nats
    confidence  probability that the opening exists, 0..1
    floor, bay  storey (ground floor 0) and column over all floors (from the left, from 1)
    glazing     its frame and bars; None = not looked for
    photos      names of the photos that show it
    on          id of the protrusion that holds it, from whose front its depth counts; "" = the main wall

    Raises ValueError for an unknown kind and for arrays of other shapes.
    """

    id: str
    kind: OpeningKind
    ring: Float
    ring_covariance: Float
    depth: Estimate[float] | None
    shape: str
    provenance: Provenance
    evidence: float
    confidence: float
    floor: int
    bay: int
    glazing: Glazing | None = None
    photos: tuple[str, ...] = ()
    on: str = ""

    def __post_init__(self) -> None:
        k = len(self.ring)
        object.__setattr__(self, "kind", OpeningKind(self.kind))
        freeze(self, ring=((k, 2), np.float64), ring_covariance=((2 * k, 2 * k), np.float64))

    @property
    def number(self) -> int:
        """The number on its floor, from the left as seen from the street: the last number of its id."""
        return int(self.id.rsplit("-", 1)[1])

    @property
    def bars(self) -> tuple[Bar, ...]:
        """The window bars found; empty where none were found, and where they were not looked for."""
        return () if self.glazing is None else self.glazing.bars


@dataclass(frozen=True, eq=False)
class Protrusion:
    """Something that stands out of the wall, or is set back as a whole: a balcony, an oriel, a cornice, ...

    kind     a `ProtrusionKind` or its text, such as "balcony"
    ring     (k, 2) m (x, z) in the facade frame, counter-clockwise as seen from the street
    sigma    m, standard error of the ring's borders
    front    y of its front face, m: negative = in front of the wall

    Raises ValueError for an unknown kind and for a ring of another shape.
    """

    id: str
    kind: ProtrusionKind
    ring: Float
    sigma: float
    front: Estimate[float]
    provenance: Provenance
    confidence: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "kind", ProtrusionKind(self.kind))
        freeze(self, ring=((None, 2), np.float64))


@dataclass(frozen=True, eq=False)
class Elements:
    """The openings and protrusions of a facade; `notes` say what could not be judged, and where."""

    facade: str
    openings: tuple[Opening, ...]
    protrusions: tuple[Protrusion, ...] = ()
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Say how many openings of each kind there are."""
        kinds = Counter(str(o.kind) for o in self.openings) + Counter(str(p.kind) for p in self.protrusions)
        counts = ", ".join(f"{n} {kind}" for kind, n in kinds.items())
        return f"<Elements of {self.facade}: {counts or 'nothing found'}>"

    def wall_y(self, opening: Opening) -> float:
        """Returns y (m) of the wall that holds an opening: its protrusion's front, else the plane (0)."""
        return next((float(p.front.value) for p in self.protrusions if p.id == opening.on), 0.0)
