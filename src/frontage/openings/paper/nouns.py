"""Turns the published method's cells into openings and protrusions, with standard errors."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.ring import rectangle
from frontage.model.estimate import Estimate, Provenance
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY
from frontage.model.opening import Elements, Opening, OpeningKind, Protrusion, ProtrusionKind
from frontage.openings.boxes import Box
from frontage.openings.options import OpeningOptions
from frontage.openings.paper.cells import FACADE_SHARE, WINDOW_SHARE
from frontage.openings.paper.shapes import outline

_CHORD = 0.005  # m, chord error of round heads
_DOOR = 1.9  # m, least height of a door
_ROUND = 0.9  # share of half the width: an arch that rises so far is a semicircle


@dataclass(frozen=True, eq=False)
class WindowCell:
    """A window cell.

    box       m
    rise      m, of its arch
    share     of available elements
    elements  their number
    distance  m, scan point distance
    depth     of its frame behind the wall, m
    """

    box: Box
    rise: float
    share: float
    elements: float
    distance: float
    depth: Estimate[float] | None = None

    @property
    def centre(self) -> tuple[float, float]:
        """The middle x and z of the box, m."""
        x0, z0, x1, z1 = self.box
        return (x0 + x1) / 2, (z0 + z1) / 2


@dataclass(frozen=True)
class ProtrusionCell:
    """A protrusion cell.

    box       m
    y         m, of its front
    sigma     m, standard error of that
    count     of the points there
    share     of available elements
    distance  m, scan point distance
    """

    box: Box
    y: float
    sigma: float
    count: int
    share: float
    distance: float


def to_elements(
    facade: Facade, holes: Sequence[WindowCell], fronts: Sequence[ProtrusionCell], options: OpeningOptions
) -> Elements:
    """Makes the model's nouns: openings row by row from the lowest, each from left to right; protrusions."""
    ground = float(facade.outline[:, 1].min()) if options.ground_z is None else options.ground_z
    openings: list[Opening] = []
    for row in _rows(holes):
        openings += [_opening(hole, ground) for hole in sorted(row, key=lambda h: h.centre[0])]
    ordered = sorted(fronts, key=lambda f: f.box)
    return Elements(
        facade.id,
        tuple(openings),
        tuple(_protrusion(f"{facade.id}/P{k}", f) for k, f in enumerate(ordered, 1)),
        _notes(facade, holes),
    )


def border_sigma(distance: float) -> float:
    """Returns the standard error m of a border: the wall ends anywhere between its last point and the next.

    The line runs through the last points, so its error is spread evenly over 0 to `distance` m, and its root
    mean square is distance / sqrt(3); the paper states none, and does not correct the mean.
    """
    return distance / float(np.sqrt(3.0))


def _opening(hole: WindowCell, ground: float) -> Opening:
    """Makes the opening of a window cell; one at the ground that is high enough is a door."""
    x0, z0, x1, z1 = hole.box
    ring = outline(hole.box, hole.rise, _CHORD)
    at = (ring - [x0, z0]) / [x1 - x0, z1 - z0]
    borders = np.zeros((2 * len(ring), 4))  # how the corners follow left, bottom, right, top
    borders[0::2, 0], borders[0::2, 2] = 1 - at[:, 0], at[:, 0]
    borders[1::2, 1], borders[1::2, 3] = 1 - at[:, 1], at[:, 1]
    door = z0 <= ground + MASONRY.threshold and z1 - z0 >= _DOOR
    return Opening(
        id="",
        kind=OpeningKind.DOOR if door else OpeningKind.WINDOW,
        ring=ring,
        ring_covariance=border_sigma(hole.distance) ** 2 * borders @ borders.T,
        depth=hole.depth,
        shape=_shape(hole),
        provenance=Provenance.MEASURED,
        evidence=_evidence(hole),
        confidence=1.0 - hole.share,
        floor=0,
        bay=0,
    )


def _shape(hole: WindowCell) -> str:
    """Returns "rectangle", "round" or "segmental"."""
    half = (hole.box[2] - hole.box[0]) / 2
    return "rectangle" if hole.rise <= 0 else "round" if hole.rise >= _ROUND * half else "segmental"


def _evidence(hole: WindowCell) -> float:
    """Returns the nats for a window (10 % of its elements available) against facade (70 %).

    Elements count as independent.
    """
    full = hole.share * np.log(WINDOW_SHARE / FACADE_SHARE)
    empty = (1 - hole.share) * np.log((1 - WINDOW_SHARE) / (1 - FACADE_SHARE))
    return float(hole.elements * (full + empty))


def _rows(holes: Sequence[WindowCell]) -> list[list[WindowCell]]:
    """Returns the openings by storey, the lowest first: each joins the row that its middle lies in."""
    rows: list[list[WindowCell]] = []
    for hole in sorted(holes, key=lambda h: (h.centre[1], h.centre[0])):
        home = next((r for r in rows if r[0].box[1] <= hole.centre[1] <= r[0].box[3]), None)
        if home is None:
            rows.append([hole])
        else:
            home.append(hole)
    return rows


def _protrusion(name: str, front: ProtrusionCell) -> Protrusion:
    """Makes the protrusion of a cell."""
    return Protrusion(
        id=name,
        kind=ProtrusionKind.OTHER,
        ring=rectangle(*front.box),
        sigma=border_sigma(front.distance),
        front=Estimate(front.y, np.array([[front.sigma**2]]), float(front.count - 1)),
        provenance=Provenance.MEASURED,
        confidence=front.share,
    )


def _notes(facade: Facade, holes: Sequence[WindowCell]) -> tuple[str, ...]:
    """Says what the method could not judge."""
    notes = ["method 'paper': gaps in the points that have other causes are taken for openings too"]
    if holes and all(h.depth is None for h in holes):
        notes.append(f"facade {facade.id}: too few points behind its openings to tell their depth")
    return tuple(notes)
