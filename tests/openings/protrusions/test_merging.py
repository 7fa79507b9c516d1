"""Which pieces above one another are one: what beams between them end on decides."""

from dataclasses import dataclass

import numpy as np
import pytest

from frontage.openings.protrusions.merging import bridge_gaps
from frontage.openings.protrusions.pieces import Piece
from frontage.openings.protrusions.resolution import Resolution

FRONT = -1.2  # m
LOWER, UPPER = (0.0, 2.0, 3.0, 3.2), (0.0, 5.0, 3.0, 6.2)
RESOLUTION = Resolution(0.02, 0.003, 0.02, np.array([[1.5, 4.0, 0.02]]))


@dataclass(frozen=True)
class Between:
    """Beams that end on the fronts of both pieces, and at depths (k,) m where they cross the gap."""

    depth: np.ndarray

    def at(self, y, box, margin):
        low, high = box[1] - margin, box[3] + margin
        in_gap = low > LOWER[3] and high < UPPER[1]
        depth = self.depth if in_gap else np.full(100, y)
        return np.zeros((len(depth), 2)), depth


@pytest.mark.parametrize(
    ("depth", "number"),
    [
        (np.linspace(-0.65, -0.1, 100), 2),  # undersides of the upper balcony
        (np.full(100, 0.2), 2),  # the wall's windows
        (np.full(100, FRONT + 0.15), 1),  # panes of an oriel
        (np.empty(0), 1),  # a tree hides the gap
    ],
)
def test_pieces_are_one_unless_beams_pass_between_them(depth, number):
    rows = np.arange(5)
    pieces = [Piece(rows, rows, box, FRONT) for box in (LOWER, UPPER)]
    assert len(bridge_gaps(pieces, Between(depth), RESOLUTION)) == number
