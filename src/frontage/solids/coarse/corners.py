"""Moves the ends of facades in plan to the corners that they share with their neighbours."""

from collections.abc import Sequence

import numpy as np

from frontage.geometry.arrays import Float
from frontage.solids.coarse.plan_facade import PlanFacade, cross2d

PARALLEL_SINE = 0.17  # 10 degrees: planes closer to parallel than this have no corner, but a step
REACH_M = 3.0  # largest change of a facade's length at a corner: what a car or a tree hides
OVERSHOOT_M = 0.75  # by which a facade is measured too long: cornices, downpipes and the neighbour's plaster
_REACH_SHARE = 0.45  # the same as a share of its length; a missing face of a polygon is further away
_FLUSH_M = 0.05  # facades whose planes are closer than this belong to one wall


def move_ends_to_corners(facades: Sequence[PlanFacade], depth: float) -> dict[int, int]:
    """Moves the ends of neighbouring facades to where they meet, the closest pairs first.

    Returns facade index -> index of the facade that follows it counter-clockwise. Facades that meet at an
    outer corner become `corner_neighbours`.
    """
    pairs = [(i, j) for i in range(len(facades)) for j in range(len(facades)) if i != j]
    met = [(m, i, j) for i, j in pairs if (m := _corner(facades[i], facades[j], depth)) is not None]
    follows: dict[int, int] = {}
    for (_, right, left), i, j in sorted(met, key=lambda m: (m[0][0], m[1], m[2])):
        if i in follows or j in follows.values():
            continue
        follows[i] = j
        facades[i].ends[1], facades[j].ends[0] = right, left
        if cross2d(facades[i].along, facades[j].along) > PARALLEL_SINE:
            facades[i].corner_neighbours.append(facades[j])
            facades[j].corner_neighbours.append(facades[i])
    return follows


def _corner(one: PlanFacade, other: PlanFacade, depth: float) -> tuple[float, Float, Float] | None:
    """Returns where the right end of one facade meets the left end of another; None if they do not meet.

    The first value is the distance (m) by which both ends move together; then the new place (2,) of each end.
    """
    a, b = one.ends[1], other.ends[0]
    reach = [min(REACH_M, _REACH_SHARE * f.length) for f in (one, other)]
    if abs(cross2d(one.along, other.along)) > PARALLEL_SINE:
        sides = np.array([one.inward @ a, other.inward @ b])
        corner = np.linalg.solve(np.array([one.inward, other.inward]), sides)
        grown = float((corner - a) @ one.along), float((b - corner) @ other.along)
        if any(not -OVERSHOOT_M < by <= most for by, most in zip(grown, reach, strict=True)):
            return None
        return abs(grown[0]) + abs(grown[1]), corner, corner
    gap, step = float((b - a) @ one.along), float((b - a) @ one.inward)
    if one.inward @ other.inward < 0 or abs(gap) > min(reach) or abs(step) > depth:
        return None
    if abs(step) < _FLUSH_M:
        return abs(gap), (a + b) / 2, (a + b) / 2
    return abs(gap) + abs(step), a + gap / 2 * one.along, b - gap / 2 * one.along
