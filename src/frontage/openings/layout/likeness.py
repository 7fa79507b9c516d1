"""Compares a place with the openings and with the wall of a facade by the beams that come back from it.

Openings of one form return beams in one way: frames, mullions, blinds and panes are alike, whatever they are.
The facade itself therefore shows what share of the expected beams its openings return in each ninth of their
area, and what share its wall returns beside them. A place is compared with both.
"""

from collections.abc import Sequence

import numpy as np

from frontage.geometry.arrays import Float
from frontage.openings.boxes import Box
from frontage.openings.wall.evidence import Evidence
from frontage.openings.wall.raster import summed

_PARTS = 3  # parts of an opening along each axis
_FEW = 5.0  # expected beams of a part that tell what its kind returns
_SPREAD = 0.1  # one sigma, at least, of the shares that alike parts return
_STRAY = 0.05  # share of the parts that look like neither: what stands before them, or joinery of its own


class Likeness:
    """Compares places with the openings and with the wall of one facade."""

    def __init__(self, evidence: Evidence, openings: Sequence[Box]) -> None:
        self._evidence = evidence
        self._totals = [summed(m) for m in (evidence.solid, evidence.expected)]
        taken = np.zeros(evidence.llr.shape)
        for box in openings:
            taken[evidence.raster.cells(box)] = 1.0
        self._taken = summed(taken)
        self._known: dict[Box, tuple[Float, Float]] = {}
        self._wall = self._shares_of_wall(openings)

    def nats(self, place: Box, fellows: Sequence[Box]) -> Float:
        """Returns the nats (3, 3) for one more of the `fellows` against wall, in each part of a place."""
        came, due = self._parts(place)
        share, sigma = came / np.maximum(due, 1e-9), np.sqrt(np.maximum(came, 1.0)) / np.maximum(due, 1e-9)
        shown = [self._parts_of(f) for f in fellows]
        known = np.array([d >= _FEW for _, d in shown])
        shares = np.array([c / np.maximum(d, 1e-9) for c, d in shown])
        count = np.maximum(known.sum(0), 1)
        mean = np.where(known, shares, 0.0).sum(0) / count
        spread = np.sqrt(np.where(known, (shares - mean) ** 2, 0.0).sum(0) / count + _SPREAD**2)
        like = _density(share, mean, np.hypot(spread, sigma))
        wall = _density(share, self._wall[0], np.hypot(self._wall[1], sigma))
        told = np.log((1.0 - _STRAY) * like + _STRAY) - np.log((1.0 - _STRAY) * wall + _STRAY)
        return np.where(known.any(0) & (due > 0.0), told, 0.0)

    def _parts_of(self, box: Box) -> tuple[Float, Float]:
        """Returns the same as `_parts`, without counting the beams of a box again."""
        if box not in self._known:
            self._known[box] = self._parts(box)
        return self._known[box]

    def _parts(self, box: Box) -> tuple[Float, Float]:
        """Returns the beams (3, 3) that ended on the wall in each part of a box, and those expected."""
        came, due = (self._sums(total, box) for total in self._totals)
        return came, due

    def _sums(self, total: Float, box: Box) -> Float:
        """Returns the sums (3, 3) over the parts of a box of a map whose running totals are given."""
        cells = self._evidence.raster.cells(box)
        rows, columns = (np.round(np.linspace(s.start, s.stop, _PARTS + 1)).astype(int) for s in cells)
        return np.asarray(np.diff(np.diff(total[np.ix_(rows, columns)], axis=0), axis=1), np.float64)

    def _shares_of_wall(self, openings: Sequence[Box]) -> tuple[float, float]:
        """Returns mean and one sigma of the shares that the wall beside openings returns, part by part."""
        shares = []
        for x0, z0, x1, z1 in openings:
            for beside in ((2 * x0 - x1, z0, x0, z1), (x1, z0, 2 * x1 - x0, z1)):
                came, due = self._parts(beside)
                free = (self._sums(self._taken, beside) == 0) & (due >= _FEW)
                shares += (came[free] / due[free]).tolist()
        told = np.array(shares) if shares else np.ones(1)
        return float(told.mean()), float(np.hypot(told.std(), _SPREAD))


def _density(value: Float, mean: Float | float, sigma: Float) -> Float:
    """Returns the density (...) of a normal distribution; scipy's own takes longer than all else here."""
    return np.asarray(np.exp(-(((value - mean) / sigma) ** 2) / 2.0) / np.sqrt(2.0 * np.pi) / sigma)
