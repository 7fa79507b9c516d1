"""Layouts on wider cells where a wall is scanned more sparsely.

A row of houses that is scanned from one place has a hundred times fewer beams at its ends than in its middle.
Cells that suit the middle hold no beam there, and openings fall apart into noise. What the finest cells show
stands; wider cells, on which a beam comes back on average, add what finer ones do not show.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Bool, Float
from frontage.openings.boxes import Box
from frontage.openings.layout.posts import Post
from frontage.openings.layout.rasters import find_on_rasters, shared_areas
from frontage.openings.layout.selection import PRICE, worth_of
from frontage.openings.options import OpeningOptions
from frontage.openings.wall.evidence import COARSEST, Evidence
from frontage.openings.wall.raster import summed

_LEAST = 5.0  # m2 of wall that asks for wider cells: an opening and the wall around it
_HALF_STEP = np.sqrt(2.0)  # cells double from step to step; a place takes the step that is nearest


@dataclass(frozen=True, eq=False)
class Place:
    """A rectangle that may be an opening.

    box       m
    worth     nats
    evidence  the evidence on the cells that it was found on
    """

    box: Box
    worth: float
    evidence: Evidence

    @property
    def slack(self) -> float:
        """How far (m) its borders may be off: two cells, and a little so that no last digit decides."""
        return 2.01 * self.evidence.raster.cell

    @classmethod
    def of(cls, box: Box, evidence: Evidence) -> "Place":
        """Returns the place of a box with what its cells are worth, less the price of an opening."""
        worth = float(worth_of(evidence, evidence.raster.cells(box)).sum()) - PRICE
        return cls(box, worth, evidence)


def row_by_row(places: Iterable[Place]) -> list[Place]:
    """Returns the places in the order of their feet, and from left to right."""
    return sorted(places, key=lambda p: (p.box[1], p.box[0]))


def wider_cells(evidence: Evidence) -> list[float]:
    """Returns how many times wider the cells for the sparse parts of a wall are, step by step.

    There are none where the wall is scanned evenly, or where cells are as wide as the least pier already.
    """
    cell, due = evidence.raster.cell, evidence.expected_free[evidence.inside]
    wide = 1.0 / np.sqrt(due[due > 0.0])  # cells that hold one beam, in cells
    most = COARSEST / cell
    scales, scale = [], 2.0
    while scale < most * _HALF_STEP and (wide > scale / _HALF_STEP).sum() * cell**2 >= _LEAST:
        scales.append(min(scale, most))
        scale *= 2.0
    return scales


def spacing_at(boxes: Sequence[Box], evidence: Evidence, spacing: float) -> list[float]:
    """Returns the distances m between neighbouring beams on the wall around boxes.

    They are the `spacing` m of the facade or wider. Neighbours of scattered points are half as far away as
    cells are wide that hold one of them on average.
    """
    told = 0.5 * _cells_at(np.reshape(boxes, (-1, 4)), evidence)
    return [float(s) for s in np.clip(told, spacing, max(spacing, COARSEST))]


def find_at_densities(
    rasters: Sequence[Sequence[Evidence]], options: OpeningOptions, ground: float, posts: Sequence[Post] = ()
) -> list[Place]:
    """Returns the rectangles that may be openings, row by row.

    `rasters` are the evidence on the finest cells, and then on those for sparser parts of the wall, each on
    one raster or on several; `ground` is the height z m of the ground; `posts` part openings.
    """
    finest, places = rasters[0][0], list[Place]()
    for evidences in rasters:
        wider = evidences[0] is not finest
        found = find_on_rasters(evidences, options, ground, posts, _HALF_STEP**2 if wider else np.inf)
        boxes, others = (np.reshape(b, (-1, 4)) for b in ([b for b, _ in found], [p.box for p in places]))
        free: Bool = (shared_areas(boxes, others) == 0.0).all(1)
        if wider:
            free &= _cells_at(boxes, finest) > evidences[0].raster.cell / _HALF_STEP
        places += [Place(b, w, evidences[0]) for (b, w), ok in zip(found, free, strict=True) if ok]
    return row_by_row(places)


def _cells_at(boxes: Float, evidence: Evidence) -> Float:
    """Returns the sides (n,) m of cells that hold one beam each on a wall in the place of boxes (n, 4) m."""
    raster = evidence.raster
    low, high = raster.ends(boxes)
    low = np.minimum(low, np.array(raster.shape[::-1]) - 1)
    high = np.maximum(high, low + 1)
    total, (c0, r0), (c1, r1) = summed(evidence.expected_free), low.T, high.T
    beams = total[r1, c1] - total[r0, c1] - total[r1, c0] + total[r0, c0]
    area = (high - low).prod(1) * raster.cell**2
    return np.asarray(np.sqrt(area / np.maximum(beams, 1e-6 * area)))
