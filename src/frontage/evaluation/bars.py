"""Scores window bars: the layout as a whole, and the positions of the single bars."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from frontage.evaluation.metric import Metric, mean, metric
from frontage.evaluation.result import FoundOpening
from frontage.evaluation.truth import TrueFacade, TrueOpening
from frontage.geometry.arrays import Array, Float
from frontage.model.glazing import AXES

_ACROSS_M = 0.05  # a bar farther away is a different bar
_ALONG_M = 0.15  # ends farther apart make a different layout, such as a transom that stops at the mullion
_IN_LINE_M = (0.02, 0.15)  # across, and between the ends (beside a post), of pieces that are one bar


def bar_errors(
    facade: TrueFacade, truth: TrueOpening, found: FoundOpening
) -> tuple[Array | None, bool | None]:
    """Returns the signed position errors (m,) m of the matched bars and whether the layout is exactly right.

    Both are None where the result does not mention bars; the errors are None where it only counts them. A
    layout is right when every bar has a partner within 5 cm across and 15 cm at its ends and none is left
    over. Pieces that continue each other count as one bar, in the truth and in the result: the glazing bars
    of two casements at one height may be told as one or as two. Whether a leaded window is right is not
    asked, since its small panes are no layout of bars.
    """
    if found.bars is None and found.counts is None:
        return None, None
    built = [joined([(b.position, *b.extent) for b in truth.bars if b.axis == axis]) for axis in AXES]
    if found.bars is None:
        return None, None if truth.glazing == "leaded" else tuple(map(len, built)) == found.counts
    errors, right = [np.empty(0)], True
    for axis, across, true in zip(AXES, (0, 1), built, strict=True):
        lines = [facade.frame.inverse.apply(b.line)[:, [0, 2]] for b in found.bars if b.axis == axis]
        seen = joined([_position(line, across) for line in lines])
        row, column, exact = match_bars(true, seen)
        right &= exact
        errors.append(seen[column, 0] - true[row, 0])
    return np.concatenate(errors), None if truth.glazing == "leaded" else bool(right)


def layout_figures(openings: Sequence[tuple[TrueOpening, bool | None]]) -> dict[str, Metric]:
    """Returns shares of glazed openings by whether their layout is right (True, False, None = not decided).

    "bars_exact" is the share of right ones among those decided, "bars_right" that among all, where an
    undecided layout is as good as a wrong one, and "bars_decided" the share decided. Leaded windows are not
    asked. A result that decides no layout at all says nothing about bars, and has no figures.
    """
    asked = [exact for truth, exact in openings if truth.glazed and truth.glazing != "leaded"]
    decided = [exact for exact in asked if exact is not None]
    every = asked if decided else []
    return {
        "bars_exact": metric(np.array(decided), mean),
        "bars_right": metric(np.array([exact is True for exact in every]), mean),
        "bars_decided": metric(np.array([exact is not None for exact in every]), mean),
    }


def match_bars(true: Float, seen: Float, across: float = _ACROSS_M) -> tuple[Array, Array, bool]:
    """Match bars of one direction: rows (n, 3) m of position and both ends, at most `across` m apart.

    Returns the rows of the matched ones in both, and whether all match, with their ends.
    """
    distance = np.abs(true[:, None, 0] - seen[None, :, 0])
    ends = np.abs(true[:, None, 1:] - seen[None, :, 1:]).max(2, initial=0.0)
    row, column = linear_sum_assignment(distance + ends)
    near = distance[row, column] <= across
    exact = len(true) == len(seen) == int((near & (ends[row, column] <= _ALONG_M)).sum())
    return row[near], column[near], exact


def joined(bars: Sequence[tuple[float, float, float]]) -> Float:
    """Join bars of one direction that continue each other: rows (n, 3) m of position, from, to, in order."""
    rows: list[list[float]] = []
    lengths: list[float] = []
    for position, a, b in sorted(((p, min(a, b), max(a, b)) for p, a, b in bars), key=lambda row: row[1]):
        for k, (at, _, end) in enumerate(rows):
            if abs(at - position) <= _IN_LINE_M[0] and abs(a - end) <= _IN_LINE_M[1]:
                whole = lengths[k] + (b - a)
                rows[k][0] += (position - at) * (b - a) / max(whole, 1e-9)
                rows[k][2], lengths[k] = b, whole
                break
        else:
            rows.append([position, a, b])
            lengths.append(b - a)
    return np.array(sorted(rows)).reshape(-1, 3)


def _position(line: Float, across: int) -> tuple[float, float, float]:
    """Position and both ends, in m, of a centre line (2, 2) m (x, z)."""
    low, high = sorted(float(v) for v in line[:, 1 - across])
    return float(line[:, across].mean()), low, high
