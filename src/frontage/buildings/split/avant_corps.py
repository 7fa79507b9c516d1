"""Find avant-corps: a piece of front between two pieces that are alike is the middle of one house.

A projecting centre, its higher attic or an oriel give the same steps as a neighbour's house does. They differ
in that the wall goes on behind: both flanks have the same eaves, plane, colour and floors.
"""

import numpy as np

from frontage.buildings.fronts.profile import BIN_M
from frontage.buildings.split.cues import STEP, SURE, compare_sides, difference, least_step
from frontage.buildings.split.evidence import BinRange, SplitEvidence, spread_within
from frontage.geometry.arrays import Float

_NARROW_M = 5.0  # m: a middle no wider than this may also differ in colour (an oriel of wood, a stair tower)
_LEAST_FLANK_M = 2.0  # m, width of a flank
_FEWEST_BINS = 4  # measured on each flank, for its channel to count


def find_avant_corps(
    evidence: SplitEvidence, cuts: list[int], fixed: list[bool], convincing: list[bool]
) -> int | None:
    """Returns the first i whose cuts i and i + 1 bound the middle of one house; None if there is none.

    `fixed` says of each cut whether it stays in any case, `convincing` whether it would part houses by
    itself: one of the two must.
    """
    spread = spread_within(evidence, cuts)
    edge = [0, *cuts, len(evidence.profile)]
    for i in range(len(cuts) - 1):
        left, middle, right = ((edge[i + k], edge[i + k + 1]) for k in range(3))
        can_be = (convincing[i] or convincing[i + 1]) and not (fixed[i] or fixed[i + 1])
        if not can_be or not _are_alike(evidence, left, right, spread):
            continue
        is_narrow = (middle[1] - middle[0]) * BIN_M <= _NARROW_M
        if is_narrow or not (
            _differ_in_surface(evidence, left, middle, spread)
            or _differ_in_surface(evidence, middle, right, spread)
        ):
            return i
    return None


def _are_alike(evidence: SplitEvidence, a: BinRange, b: BinRange, spread: Float) -> bool:
    """Decides whether two flanks were both measured and agree in everything that can part houses.

    Intensity changes with the distance, the incidence and the scanners that see a place, and flanks lie
    apart: where colour is known, it tells.
    """
    if compare_sides(evidence, a, b, spread)[0] or min(a[1] - a[0], b[1] - b[0]) * BIN_M < _LEAST_FLANK_M:
        return False
    tested, has_colour = 0, _has_colour(evidence)
    for k, kind in enumerate(evidence.kinds):
        if kind == "rough" or (kind == "bright" and has_colour):  # roughness is a matter of sills and stairs
            continue
        sides = (evidence.signal[a[0] : a[1], k], evidence.signal[b[0] : b[1], k])
        if all(np.isfinite(x).sum() >= _FEWEST_BINS for x in sides):
            tested += kind in ("eaves", "offset")
            if abs(np.nanmedian(sides[0]) - np.nanmedian(sides[1])) > STEP[kind]:
                return False
    return tested == 2


def _has_colour(evidence: SplitEvidence) -> bool:
    """Decides whether the colour of the front was measured."""
    return bool(np.isfinite(evidence.signal[:, evidence.kinds.index("colour")]).any())


def _differ_in_surface(evidence: SplitEvidence, a: BinRange, b: BinRange, spread: Float) -> bool:
    """Decides whether two adjoining pieces certainly differ in colour, or in intensity without colour."""
    has_colour = _has_colour(evidence)
    for k, kind in enumerate(evidence.kinds):
        if kind == ("colour" if has_colour else "bright"):
            step, t = difference(evidence, k, a, b, spread[k])
            if t > SURE and abs(step) > least_step(evidence, k, a, b):
                return True
    return False
