"""How much better a layout is than the next one that is different."""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from frontage.crossbars.chosen import Chosen
from frontage.crossbars.division import alike, joined
from frontage.crossbars.layout import best_layout
from frontage.geometry.arrays import Float

_WEAKEST = 3  # bars of a window without which a layout is searched for again: others cost more to leave out
_ASKED = 4  # windows of one type that tell the margin of the layout that they share
_NO_RIVAL = 100.0  # nats, where nothing at all speaks for any other layout


def margins(chosen: Sequence[Chosen]) -> Float:
    """Returns by how many nats the layout of each window (n,) is better than the next different one.

    Windows that share a layout decide it together: where one of them shows little, the mean of some counts.
    Where the scan alone shows them, their evidence adds up, and each must agree with that layout itself.
    """
    members = defaultdict(list)
    for k, one in enumerate(chosen):
        members[(one.kin, None) if one.kin is not None else (None, k)].append(k)
    found = np.zeros(len(chosen))
    for group in members.values():
        sure = chosen[group[0]].sure
        if sure is not None:
            found[group] = sure
            continue
        asked = group[:: -(-len(group) // _ASKED)]
        own = np.array([margin(chosen[k]) for k in asked])
        found[group] = own.mean()
        found[asked] = np.maximum(own, own.mean())
    scanned = np.array([not one.seen.sight.views for one in chosen], bool)
    return np.where(scanned, np.minimum(found, [one.beyond for one in chosen]), found)


def margin(chosen: Chosen) -> float:
    """Returns the nats by which a layout is better than the best different one, on the window's own evidence.

    Every other layout lacks one of its bars, or has them all and more. The best without each of the weakest
    bars is searched for again; the best with one more is known of every pane. A layout that was taken over
    from similar windows may have a negative margin.
    """
    layout, box, bars = chosen.layout, chosen.seen.box, chosen.bars
    alone = chosen.alone or layout
    weak = sorted(joined(layout.lines), key=lambda line: line.evidence)[:_WEAKEST]
    others = [best_layout(box, bars, chosen.least, without=(line.axis, line.position)).gain for line in weak]
    same = alike(layout.lines, alone.lines)
    rivals = alone.rivals if same else layout.rivals
    others += [layout.gain + max(rivals)] if rivals else []
    others += [] if same else [alone.gain]
    return layout.gain - max(others) if others else _NO_RIVAL
