"""Risalits and bays: a piece of front between two pieces that are alike is the middle of one house.

A projecting centre, its higher attic or an oriel give the same steps as a neighbour's house does; what tells
them apart is that the wall goes on behind: both flanks have the same eaves, plane, colour and floors.
"""

import numpy as np

from frontage.buildings.evidence import STEP, SURE, Look, Side, compare, difference, within
from frontage.buildings.profile import BIN
from frontage.geometry.arrays import Float

_NARROW = 5.0  # m: a middle no wider than this may also differ in colour (an oriel of wood, a stair tower)


def embedded(look: Look, cuts: list[int], fixed: list[bool]) -> int | None:
    """The first i whose cuts i and i + 1 bound the middle of one house, None = no such; `fixed` cuts stay."""
    spread = within(look, cuts)
    edge = [0, *cuts, len(look.profile)]
    for i in range(len(cuts) - 1):
        a, b, c = ((edge[i + k], edge[i + k + 1]) for k in range(3))
        if fixed[i] or fixed[i + 1] or not _alike(look, a, c, spread):
            continue
        narrow = (b[1] - b[0]) * BIN <= _NARROW
        if narrow or not (_other_surface(look, a, b, spread) or _other_surface(look, b, c, spread)):
            return i
    return None


def _alike(look: Look, a: Side, b: Side, spread: Float) -> bool:
    """Whether two pieces were measured and agree in all that can part houses."""
    if compare(look, a, b, spread)[0] or min(a[1] - a[0], b[1] - b[0]) * BIN < 2.0:
        return False
    tested = 0
    for k, kind in enumerate(look.kinds):
        if kind == "rough":  # a matter of sills and stairs
            continue
        sides = (look.signal[a[0] : a[1], k], look.signal[b[0] : b[1], k])
        if all(np.isfinite(x).sum() >= 4 for x in sides):
            tested += kind in ("eaves", "offset")
            if abs(np.nanmedian(sides[0]) - np.nanmedian(sides[1])) > STEP[kind]:
                return False
    return tested == 2


def _other_surface(look: Look, a: Side, b: Side, spread: Float) -> bool:
    """Whether two adjoining pieces surely differ in colour or intensity."""
    for k, kind in enumerate(look.kinds):
        if kind in ("colour", "bright"):
            step, t = difference(look, k, a, b, spread[k])
            if t > SURE and abs(step) > STEP[kind]:
                return True
    return False
