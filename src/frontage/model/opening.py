"""An opening of a facade, and its window bars."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, freeze
from frontage.model.estimate import Estimate, Provenance

DOORS = frozenset({"door", "garage", "passage"})
"""Kinds of openings that one goes or drives through: a `Door` of city models, no window."""


@dataclass(frozen=True)
class Bar:
    """A mullion ("vertical", position x) or transom ("horizontal", position z): all in m."""

    axis: str
    position: float
    extent: tuple[float, float]
    width: float
    sigma: float


@dataclass(frozen=True, eq=False)
class Opening:
    """A window, door or other opening of a facade.

    id          "B07/F1/W3-2": third floor, second from the left as seen from the street; ground floor = 0
    kind        window, door, shopfront, passage, garage, basement, ...
    ring        (k, 2) m (x, z), counter-clockwise as seen from the street; ring_covariance (2k, 2k) m2
    depth       of the frame behind the wall, m, positive = recess; None when not measured
    evidence    log-likelihood ratio, nats
    on          id of the protrusion that it sits on, whose front its depth counts from; "" = the main wall
    """

    id: str
    kind: str
    ring: Float
    ring_covariance: Float
    depth: Estimate[float] | None
    shape: str
    provenance: Provenance
    evidence: float
    confidence: float
    floor: int
    bay: int
    bars: tuple[Bar, ...] = ()
    photos: tuple[str, ...] = ()
    on: str = ""

    def __post_init__(self) -> None:
        k = len(self.ring)
        freeze(self, ring=((k, 2), np.float64), ring_covariance=((2 * k, 2 * k), np.float64))


@dataclass(frozen=True, eq=False)
class Protrusion:
    """Something that stands out of the wall (or is set back as a whole): balcony, oriel, cornice, awning, ...

    ring     (k, 2) m (x, z), counter-clockwise as seen from the street; sigma m of its borders
    front    y of its front face, m: negative = in front of the wall
    """

    id: str
    kind: str
    ring: Float
    sigma: float
    front: Estimate[float]
    provenance: Provenance
    confidence: float

    def __post_init__(self) -> None:
        freeze(self, ring=((None, 2), np.float64))


@dataclass(frozen=True, eq=False)
class Elements:
    """What a facade holds: openings and protrusions; `notes` say what could not be judged, and where."""

    facade: str
    openings: tuple[Opening, ...]
    protrusions: tuple[Protrusion, ...] = ()
    notes: tuple[str, ...] = ()

    def wall_y(self, opening: Opening) -> float:
        """y (m) of the wall of an opening: the front of the protrusion that it is on, else the plane."""
        return next((float(p.front.value) for p in self.protrusions if p.id == opening.on), 0.0)
