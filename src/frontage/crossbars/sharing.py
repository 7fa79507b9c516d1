"""Which layouts windows of one size share.

A layout is described once for all windows that have it. What it takes to describe the layouts, and to say
which window has which, decides how many there are: builders use few, such as that of the left and that of the
right one of coupled windows, or sashes with and without bars. A window that differs clearly keeps its own.

Where photos show some of them, windows of one size share one layout only: similar windows cast the same
shadows and show the same sides of their bars to every camera, so that several of them can look like another
layout.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.crossbars.candidates import COST
from frontage.crossbars.chosen import Chosen, fit
from frontage.crossbars.division import Layout, Line, alike, joined
from frontage.geometry.arrays import Float

_SAME_ENDS_M = 0.25  # by which the ends of one bar may differ in two windows
_SHARED = 1.0  # nats to say that a window is like the others
# Nats to say that it is not: one window in fifty, and a nat of evidence counts for a tenth of one (`judge`).
_OWN = 45.0
_OWN_SCANNED = 20.0  # the same of a scan, whose points have fewer errors in common than views


def with_shared_layouts(own: Sequence[Chosen], numbers: Sequence[int]) -> list[Chosen]:
    """Returns windows of one size with the layouts that they share.

    own      the windows with the layouts that each has on its own
    numbers  of the windows, by which those are named that share a layout
    """
    seen = any(one.seen.sight.views for one in own)
    fits = _Fits.of(own)
    models = fits.models(1 if seen else len(own))
    found = list(own)
    for n, one in enumerate(own):
        k = max(models, key=lambda m: float(fits.gains[m, n]))
        if fits.gains[k, n] >= fits.alone[n]:
            shared = _shared(one, own[k], fits.lines[k][n])
            found[n] = replace(shared, kin=numbers[k], beyond=fits.beyond(n, k, models))
    if seen:
        return found
    for k in models:
        members = [n for n, one in enumerate(found) if one.kin == numbers[k]]
        sure = fits.margin(k, members) if len(members) > 1 else None
        for n in members:
            found[n] = replace(found[n], members=len(members), sure=sure)
    return found


@dataclass(frozen=True, eq=False)
class _Fits:
    """The layouts of k windows of one size in all of them.

    lines  those of window m as they are in window n
    gains  (k, k) nats of window n by the layout of window m
    alone  (k,) nats of windows that keep their own layouts
    price  (k,) nats that it takes to describe a layout
    """

    lines: list[list[list[Line]]]
    gains: Float
    alone: Float
    price: Float

    @staticmethod
    def of(own: Sequence[Chosen]) -> "_Fits":
        """Returns the fits of windows with the layouts that each has on its own."""
        lines = [[fit(model, member) for member in own] for model in own]
        gains = np.array([[sum(line.evidence for line in one) for one in row] for row in lines]) - _SHARED
        differs = np.array([_OWN if one.seen.sight.views else _OWN_SCANNED for one in own])
        alone = np.array([one.layout.gain for one in own]) - differs
        price = COST * np.array([len(one.layout.lines) for one in own]) + differs
        return _Fits(lines, gains, alone, price)

    def models(self, most: int) -> list[int]:
        """Returns the windows, `most` at most, whose layouts are shared, the one that serves most first."""
        models: list[int] = []
        value = self.alone
        while len(models) < most:
            served = np.maximum(value, self.gains)
            more = served.sum(1) - value.sum() - self.price
            k = int(more.argmax())
            if models and more[k] <= 0.0:
                break
            models.append(k)
            value = served[k]
        return models

    def beyond(self, n: int, k: int, models: Sequence[int]) -> float:
        """Returns the nats by which layout k is better for window n than its own one and other models."""
        unlike = [m for m in models if not alike(self.lines[m][n], self.lines[k][n], _SAME_ENDS_M)]
        return float(self.gains[k, n] - max([self.alone[n], *self.gains[unlike, n]]))

    def margin(self, k: int, members: Sequence[int]) -> float:
        """Returns the nats by which layout k is better than the next one for all its members together.

        The next one lacks one of its bars, or is that of another window. One window shows its lower sash,
        another one its upper sash: their evidence adds up, because their points are independent.
        """
        total = np.array([[line.evidence for line in self.lines[k][n]] for n in members]).sum(0).tolist()
        whole = [replace(line, evidence=e) for line, e in zip(self.lines[k][k], total, strict=True)]
        weakest = min((bar.evidence for bar in joined(whole)), default=np.inf)
        unlike = [m for m, row in enumerate(self.lines) if not alike(row[k], self.lines[k][k], _SAME_ENDS_M)]
        others = np.maximum(self.gains[np.ix_(unlike, members)], self.alone[members]).sum(1)
        return min(weakest - COST, float(self.gains[k, members].sum() - others.max(initial=-np.inf)))


def _shared(own: Chosen, model: Chosen, lines: Sequence[Line]) -> Chosen:
    """Returns a window with the layout of its type, as far as its own evidence places the bars."""
    if own is model:
        return own
    gains = tuple(line.evidence - COST for line in lines)
    weak = tuple(line for line, gain in zip(lines, gains, strict=True) if gain < 0)
    kept = tuple(max(gain, other) for gain, other in zip(gains, model.layout.gains, strict=True))
    costs = sum(line.evidence for line in model.layout.lines) - model.layout.gain
    gain = sum(line.evidence for line in lines) - costs
    layout = Layout(tuple(lines), gain, kept, model.layout.rivals)
    return Chosen(own.seen, own.bars, layout, own.least, weak, own.meeting, own.layout)
