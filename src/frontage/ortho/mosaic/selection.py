"""Chooses the photo of every cell by one labelling of the whole facade.

A cell costs the logarithm of the quality that the photo falls short of the best one there (pixel density,
frontality, distance from the border of the photo), its disagreement with the other photos, and something for
light or shadow that the photo does not resolve. The quality of a photo is the same in all cells of a window,
and reflections cost too, so that one photo with little reflection shows all of it. A seam costs its length
and more where the photos at its sides disagree and where the wall has contrast: inside openings, whose
reflections differ, and along edges.
"""

import numpy as np

from frontage.geometry.arrays import Array, Bool, Int
from frontage.ortho.mosaic.consensus import Disagreement
from frontage.ortho.mosaic.glass import GlassCost
from frontage.ortho.mosaic.pictures import picked
from frontage.ortho.mosaic.places import averaged
from frontage.ortho.views import ViewPlan
from frontage.solve.labelling import label_grid

_SEAM = 2.0  # per cell of length: a patch of two metres is worth 16 % of quality
_DISAGREEING = 0.3  # of the cost of a photo's disagreement, added to a seam beside it
_CONTRAST = 0.3  # per standard deviation of contrast
_MOST_CONTRAST = 6.0  # standard deviations
_UNEXPOSED = 3.0  # of a cell that is saturated or black
_HIDDEN = 200.0  # of a cell that the photo does not show: more than any detour around it


def choose_photos(
    plan: ViewPlan, disagreement: Disagreement, exposed: Bool, glass: GlassCost, place: Int
) -> Array:
    """Returns the photo (h, w) int16 of every cell, an index into `plan.photos`; -1 where none sees it.

    `place` (h, w) numbers the places that one photo has to show as a whole.
    """
    seen = plan.quality > 0
    best = np.maximum(plan.quality.max(0), np.float32(1e-30))
    blind = ~seen.any(0)
    cost = best / np.where(seen, plan.quality, best)
    cost = glass.of_whole_openings(np.log(cost, out=cost))
    against = averaged(disagreement.cost + ~exposed * np.float32(_UNEXPOSED), place, plan.clear)
    cost += against
    np.copyto(cost, np.float32(_HIDDEN), where=~seen)
    np.copyto(cost, np.float32(0.0), where=blind)
    border = np.float32(_DISAGREEING) * averaged(disagreement.cost, place, plan.clear)
    border += np.float32(0.5 * _CONTRAST) * np.minimum(disagreement.contrast, np.float32(_MOST_CONTRAST))
    label = label_grid(cost, _SEAM, border)
    hidden = ~picked(seen.view(np.uint8), label).view(np.bool_)
    label[hidden] = np.argmin(cost[:, hidden], axis=0)
    label[blind] = -1
    return np.asarray(label, np.int16)
