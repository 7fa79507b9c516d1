"""Finds the sky that the outline of a facade encloses: along verges, and between gables and dormers.

The outline is straight between its corners, and the wall may end below it. Above the topmost points of the
wall, photos tell wall from sky: its colours are many times as usual up there as on the facade. In a narrow
strip along the top it is also brighter than nearly all of the facade, because cornices are as unusual, and in
taller gaps, brighter than most of it.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool
from frontage.ortho.colours import Colours

STRIP, GAP = 1, 2
"""Kinds of cells above the wall: in a narrow strip along its top, and in a taller gap."""
_STRIP_M = 0.3  # between the outline and the top of the wall
_GAP_M = 3.0  # likewise; more is a storey that the scan missed
_BRIGHT = 0.95  # quantile of the codes of a facade; the sky is brighter than most walls
_FOREIGN = 10.0  # times as usual above the wall as on the facade
_FEWEST = 200  # pixels above the wall, of which colours are learned


def above_wall(surface: Bool, sampled: Bool, inside: Bool, size: float) -> Array:
    """Returns the kind (h, w) uint8 of cells above the topmost cell of the wall in their column; 0 = none.

    The top of the wall is that of its `surface` where a gap begins, and otherwise its topmost point, which is
    `sampled`. `inside` are the cells in the outline, `size` m wide. Single columns tell nothing.
    """
    found = np.zeros(inside.shape, np.uint8)
    pair = np.ones((1, 2), np.uint8)
    for kind, wall, most in ((GAP, surface, _GAP_M), (STRIP, sampled, _STRIP_M)):
        within = wall & inside
        top, end = np.argmax(inside, axis=0), np.argmax(within, axis=0)
        low = within.any(axis=0) & (end - top <= max(1, round(most / size)))
        above = (np.arange(len(inside))[:, None] < end) & low
        found[cv2.morphologyEx(above.astype(np.uint8), cv2.MORPH_OPEN, pair) > 0] = kind
    return found


@dataclass(frozen=True, eq=False)
class SkyColours:
    """What tells sky from wall: the codes that few and that most pixels of a facade reach, and the colours
    above the wall and on the facade, where enough is seen above it."""

    bright: float
    middle: float
    colours: tuple[Colours, Colours] | None

    @classmethod
    def of(cls, facade: Array, above: Array) -> "SkyColours":
        """Learns them from pixels (n, 3) uint8 of the facade and from those above it (m, 3)."""
        if not len(facade):
            return cls(np.inf, np.inf, None)
        middle, bright = np.quantile(facade.mean(axis=1), (0.5, _BRIGHT))
        codes = [pixels * np.float32(1.0 / 255.0) for pixels in (above, facade)]
        several = len(above) >= _FEWEST
        colours = (Colours.of(codes[0]), Colours.of(codes[1])) if several else None
        return cls(float(bright), float(middle), colours)

    def shown(self, pixels: Array, above: Array) -> Bool:
        """Returns which pixels (m, n, 4) uint8 show the sky; `above` (m, n) as `above_wall` tells it."""
        sky = np.zeros(above.shape, np.bool_)
        rows = np.flatnonzero(above.any(axis=1))
        if len(rows):
            top = slice(0, int(rows[-1]) + 1)
            sky[top] = self._shown(pixels[top], above[top])
        return sky

    def _shown(self, pixels: Array, above: Array) -> Bool:
        sky = np.zeros(above.shape, np.bool_)
        light = cv2.blur(cv2.cvtColor(pixels, cv2.COLOR_RGBA2GRAY), (5, 5))
        for kind, least in ((STRIP, self.bright), (GAP, self.middle)):
            at = (above == kind) & (light >= least)
            if self.colours is None:
                sky |= at & (kind == STRIP)
            elif at.any():
                there, facade = (c(pixels[at][:, :3] * np.float32(1.0 / 255.0)) for c in self.colours)
                sky[at] = there > _FOREIGN * facade
        return sky
