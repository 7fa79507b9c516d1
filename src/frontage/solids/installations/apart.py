"""Keeps the solids of installations apart from the building and from each other, so that they are valid."""

from collections.abc import Sequence
from dataclasses import replace

from frontage.solids.installations.installation import Installation
from frontage.solids.relief import Built
from frontage.validation.validate import overlapping


def apart(things: Sequence[Installation], built: Sequence[Built]) -> tuple[list[Installation], list[str]]:
    """Returns installations of which no two solids overlap, and none overlaps the building, with notes.

    What was measured is kept: one that reaches into another solid is no solid any more, but surfaces.
    """
    if not things:
        return [], []
    first = len(built)
    opened: dict[int, str] = {}
    for i, j, depth in overlapping([*(b.solid for b in built), *(t.solid for t in things)]):
        if j >= first and i not in opened and j not in opened:
            other = things[i - first].id if i >= first else "the building"
            text = f"{things[j - first].id}: reaches {depth:.2g} m into {other}; it is kept as surfaces"
            opened[j] = text
    kept = [replace(t, closed=k + first not in opened) for k, t in enumerate(things)]
    return kept, list(opened.values())
