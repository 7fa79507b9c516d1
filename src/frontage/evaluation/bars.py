"""Scores window bars: the layout as a whole, and the positions of the single bars."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from frontage.evaluation.result import FoundOpening
from frontage.evaluation.truth import TrueFacade, TrueOpening
from frontage.geometry.arrays import Array, Float

_ACROSS_M = 0.05  # a bar farther away is a different bar
_ALONG_M = 0.15  # ends farther apart make a different layout, such as a transom that stops at the mullion


def bar_errors(
    facade: TrueFacade, truth: TrueOpening, found: FoundOpening
) -> tuple[Array | None, bool | None]:
    """Returns the signed position errors (m,) m of the matched bars and whether the layout is exactly right.

    Both are None where the result does not mention bars; the errors are None where it only counts them. A
    layout is right when every bar has a partner within 5 cm across and 15 cm at its ends and none is left
    over.
    """
    if found.bars is None:
        if found.counts is None:
            return None, None
        counts = tuple(sum(b.axis == axis for b in truth.bars) for axis in ("vertical", "horizontal"))
        return None, counts == found.counts
    errors, right = [np.empty(0)], True
    for axis, across in (("vertical", 0), ("horizontal", 1)):
        built = np.array([(b.position, *sorted(b.extent)) for b in truth.bars if b.axis == axis]).reshape(
            -1, 3
        )
        lines = [facade.frame.inverse.apply(b.line)[:, [0, 2]] for b in found.bars if b.axis == axis]
        seen = np.array([_position(line, across) for line in lines]).reshape(-1, 3)
        distance = np.abs(built[:, None, 0] - seen[None, :, 0])
        ends = np.abs(built[:, None, 1:] - seen[None, :, 1:]).max(2, initial=0.0)
        row, column = linear_sum_assignment(distance + ends)
        near = distance[row, column] <= _ACROSS_M
        right &= len(built) == len(seen) == int((near & (ends[row, column] <= _ALONG_M)).sum())
        errors.append((seen[column, 0] - built[row, 0])[near])
    return np.concatenate(errors), bool(right)


def _position(line: Float, across: int) -> tuple[float, float, float]:
    """Position and both ends, in m, of a centre line (2, 2) m (x, z)."""
    low, high = sorted(float(v) for v in line[:, 1 - across])
    return float(line[:, across].mean()), low, high
