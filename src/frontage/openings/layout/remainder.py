"""What a predicted opening leaves over of the opening that was found at its place: is it open, or wall?"""

from collections.abc import Iterator, Sequence

import numpy as np

from frontage.geometry.arrays import Bool
from frontage.openings.borders.outline import Outline
from frontage.openings.layout.inferred import cells_of
from frontage.openings.wall.evidence import Evidence

_DEEP = 6.0  # nats at most of what came back from behind a strip, for neighbouring beams err together
LEAST = 0.01  # share of anything that is known no better

Part = tuple[slice, slice]
"""Rows and columns of cells."""


def strips_of(beyond: Bool, own: Part, part: Part) -> Iterator[Bool]:
    """Yields the cells (h, w) left of, right of, below and above the `own` cells of a prediction.

    A shadow below an opening says nothing of the wall beside it, so that each strip tells by itself. All are
    masks of a `part` of the raster.
    """
    rows, columns = (np.arange(p.start, p.stop) for p in part)
    left, right = columns < own[1].start, columns >= own[1].stop
    below, above = (rows < own[0].start)[:, None], (rows >= own[0].stop)[:, None]
    between = ~left & ~right
    for strip in (left, right, below & between, above & between):
        if (beyond & strip).any():
            yield beyond & strip


class Wall:
    """What the wall beside all openings looks like where it was not seen."""

    def __init__(self, evidence: Evidence, outlines: Sequence[Outline]) -> None:
        self.evidence = evidence
        wall = evidence.inside.copy()
        for cells in (cells_of(o.place, evidence) for o in outlines):
            if cells is not None:
                wall[cells] = False
        due = np.where(wall, evidence.expected_free, 0.0)
        self._empty = float(np.clip(due[evidence.is_open].sum() / max(due.sum(), 1e-9), LEAST, 0.5))
        self._deep = max(float(evidence.deep[wall].sum() / max(due.sum(), 1e-9)), LEAST)

    def open_beyond(self, beyond: Bool, both: Bool, part: Part) -> float:
        """Returns the nats that a strip `beyond` a predicted opening is open.

        The strip belongs to the opening that was found there; `both` are the cells that the two openings
        share. They are masks (h, w) of a `part` of the raster. Where the lines of sight are not known, the
        strip may lie in a shadow. Shadows leave a share of this wall empty, and their cells err together;
        but nothing comes back from the depth of an opening there.
        """
        evidence = self.evidence
        nats = float(evidence.llr[part][beyond].sum())
        if evidence.rays:
            return nats
        free, deep = evidence.expected_free[part], evidence.deep[part]
        due, come = float(free[beyond].sum()), float(deep[beyond].sum())
        inside = float(deep[both].sum()) / max(float(free[both].sum()), 1e-9)
        rate = max(inside, self._deep)
        told = come * np.log(rate / self._deep) - (rate - self._deep) * due
        return min(nats, -float(np.log(self._empty))) + float(np.clip(told, -_DEEP, _DEEP))
