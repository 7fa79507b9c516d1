"""How much better a layout is than the next one that is different."""

import numpy as np

from frontage.crossbars.division import joined
from frontage.crossbars.layout import best_layout
from frontage.crossbars.pooling import Chosen


def margin(chosen: Chosen, least: float) -> float:
    """Returns the nats by which a layout is better than the best different one, on the window's own evidence.

    Every other layout lacks one of its bars, or has them all and more. The best without each bar is searched
    for again; the best with one more is known of every pane. A layout that was taken over from similar
    windows may have a negative margin.

    least  m, least width and height of a pane
    """
    layout, box, bars = chosen.layout, chosen.seen.box, chosen.bars
    lacking = [
        best_layout(box, bars, least, without=(line.axis, line.position)).gain
        for line in joined(layout.lines)
    ]
    more = [layout.gain + max(layout.rivals)] if layout.rivals else []
    return layout.gain - max([*lacking, *more], default=-np.inf)
