"""The published method's windows and protrusions as nouns, with the errors that the paper does not state."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.ring import rectangle
from frontage.model.estimate import Estimate, Provenance
from frontage.model.facade import Facade
from frontage.model.opening import Elements, Opening, OpeningKind, Protrusion, ProtrusionKind
from frontage.openings.options import OpeningOptions
from frontage.openings.paper.cells import FACADE_SHARE, WINDOW_SHARE, Box
from frontage.openings.paper.shapes import outline

_CHORD = 0.005  # m: chord error of round heads
_AT_GROUND = 0.35  # m above it, up to which a lower border is a threshold
_DOOR = 1.9  # m, least height of a door
_ROUND = 0.9  # of half the width: an arch that rises so far is a semicircle


@dataclass(frozen=True, eq=False)
class Hole:
    """A window cell: box m, rise of its arch m, share of available elements, their number, distance m."""

    box: Box
    rise: float
    share: float
    elements: float
    distance: float
    depth: Estimate[float] | None = None

    @property
    def centre(self) -> tuple[float, float]:
        """Of the box, x and z in m."""
        x0, z0, x1, z1 = self.box
        return (x0 + x1) / 2, (z0 + z1) / 2


@dataclass(frozen=True)
class Front:
    """A protrusion cell: box m, y of its front and its standard error m, points there, share, distance m."""

    box: Box
    y: float
    sigma: float
    count: int
    share: float
    distance: float


def to_elements(
    facade: Facade, holes: Sequence[Hole], fronts: Sequence[Front], options: OpeningOptions
) -> Elements:
    """The result with names by rows and bays, as seen from the street, ground floor 0, bays from 1."""
    ground = float(facade.outline[:, 1].min()) if options.ground_z is None else options.ground_z
    openings: list[Opening] = []
    for floor, row in enumerate(_rows(holes)):
        for bay, hole in enumerate(sorted(row, key=lambda h: h.centre[0]), 1):
            openings.append(_opening(facade.id, hole, floor, bay, ground))
    ordered = sorted(fronts, key=lambda f: f.box)
    return Elements(
        facade.id,
        tuple(openings),
        tuple(_protrusion(f"{facade.id}/P{k}", f) for k, f in enumerate(ordered, 1)),
        _notes(facade, holes),
    )


def border_sigma(distance: float) -> float:
    """Standard error m of a border: the wall ends anywhere between its last point and the next one.

    The line runs through the last points, so its error is spread evenly over 0 to `distance`, and its root
    mean square is distance / sqrt(3); the paper states none, and does not correct the mean.
    """
    return distance / float(np.sqrt(3.0))


def _opening(facade: str, hole: Hole, floor: int, bay: int, ground: float) -> Opening:
    x0, z0, x1, z1 = hole.box
    ring = outline(hole.box, hole.rise, _CHORD)
    at = (ring - [x0, z0]) / [x1 - x0, z1 - z0]
    borders = np.zeros((2 * len(ring), 4))  # how the corners follow left, bottom, right, top
    borders[0::2, 0], borders[0::2, 2] = 1 - at[:, 0], at[:, 0]
    borders[1::2, 1], borders[1::2, 3] = 1 - at[:, 1], at[:, 1]
    door = z0 <= ground + _AT_GROUND and z1 - z0 >= _DOOR
    return Opening(
        id=f"{facade}/{'D' if door else 'W'}{floor}-{bay}",
        kind=OpeningKind.DOOR if door else OpeningKind.WINDOW,
        ring=ring,
        ring_covariance=border_sigma(hole.distance) ** 2 * borders @ borders.T,
        depth=hole.depth,
        shape=_shape(hole),
        provenance=Provenance.MEASURED,
        evidence=_evidence(hole),
        confidence=1.0 - hole.share,
        floor=floor,
        bay=bay,
    )


def _shape(hole: Hole) -> str:
    half = (hole.box[2] - hole.box[0]) / 2
    return "rectangle" if hole.rise <= 0 else "round" if hole.rise >= _ROUND * half else "segmental"


def _evidence(hole: Hole) -> float:
    """Nats for a window (10 % of its elements available) against facade (70 %), elements independent."""
    full = hole.share * np.log(WINDOW_SHARE / FACADE_SHARE)
    empty = (1 - hole.share) * np.log((1 - WINDOW_SHARE) / (1 - FACADE_SHARE))
    return float(hole.elements * (full + empty))


def _rows(holes: Sequence[Hole]) -> list[list[Hole]]:
    """Openings by storey, the lowest first: each joins the row whose first opening holds its middle."""
    rows: list[list[Hole]] = []
    for hole in sorted(holes, key=lambda h: (h.centre[1], h.centre[0])):
        home = next((r for r in rows if r[0].box[1] <= hole.centre[1] <= r[0].box[3]), None)
        if home is None:
            rows.append([hole])
        else:
            home.append(hole)
    return rows


def _protrusion(name: str, front: Front) -> Protrusion:
    return Protrusion(
        id=name,
        kind=ProtrusionKind.OTHER,
        ring=rectangle(*front.box),
        sigma=border_sigma(front.distance),
        front=Estimate(front.y, np.array([[front.sigma**2]]), float(front.count - 1)),
        provenance=Provenance.MEASURED,
        confidence=front.share,
    )


def _notes(facade: Facade, holes: Sequence[Hole]) -> tuple[str, ...]:
    """What the method could not judge."""
    notes = ["method 'paper': gaps in the points that have other causes are taken for openings too"]
    if holes and all(h.depth is None for h in holes):
        notes.append(f"facade {facade.id}: too few points behind its openings to tell their depth")
    return tuple(notes)
