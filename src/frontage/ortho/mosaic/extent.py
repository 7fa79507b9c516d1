"""Finds what of a car or a person goes on beyond the part that the scan saw.

A scan sees one side of a car, and the rest of it hides the wall as well. Where another photo is clear, the
photos tell (`consensus.py`, `pairs.py`). Where a photo is the only clear one, its colours do: what touches
the known part of such a thing and has colours that are its own, or unusual on this facade, belongs to it.
"""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool
from frontage.ortho.colours import Colours
from frontage.ortho.mosaic.consensus import Disagreement
from frontage.ortho.views import ViewPlan

_REACH_M = 1.5  # a car beyond what was seen of it
_SAMPLED = 2  # one of so many cells, along rows and columns, tells the colours of the facade
_FEWEST = 50  # cells that tell the colours of a thing
_OTHER = 0.5  # share of colours that the known part does not have, all alike
_ODDS = np.log(5.0)  # of the thing against the facade, averaged
_WINDOW = 3  # cells over which log odds are averaged


def goes_on(codes: Array, found: Disagreement, plan: ViewPlan, glass: Bool) -> Bool:
    """Returns the cells (k, h, w) in which photos show more of what has no gaps than the scan did.

    `codes` (k, h, w, 3) are the colours of the photos, in one light; `found` has those of the facade, and
    `glass` (h, w) tells openings from wall.
    """
    more = np.zeros_like(plan.behind)
    hides = plan.solid & plan.behind
    alone = plan.clear.sum(0) == 1
    known = plan.clear.any(0)
    if not (hides.any() and alone.any()):
        return more
    size = 2 * round(_REACH_M / plan.cells.gsd) + 1
    box = np.ones((size, size), np.uint8)
    away = known & (cv2.dilate(hides.any(0).astype(np.uint8), box) == 0)
    some = np.s_[::_SAMPLED, ::_SAMPLED]
    own = [Colours.of(found.wall[some][(away & (glass == kind))[some]]) for kind in (False, True)]
    for k, there in enumerate(hides):
        if there.sum() < _FEWEST:
            continue
        thing = Colours.of(codes[k][there])
        near = cv2.dilate(there.astype(np.uint8), box) > 0
        asked = near & plan.clear[k]
        odds = np.zeros(asked.shape, np.float32)
        for kind in (False, True):
            at = asked & (glass == kind)
            colours = codes[k][at]
            odds[at] = np.log((_OTHER + (1.0 - _OTHER) * thing(colours)) / own[kind](colours))
        likely = (cv2.blur(np.clip(odds, -5.0, 5.0), (_WINDOW, _WINDOW)) > _ODDS) & asked
        _, number = cv2.connectedComponents((likely | there).astype(np.uint8), connectivity=8)
        more[k] = likely & alone & np.isin(number, np.unique(number[there]))
    return more
