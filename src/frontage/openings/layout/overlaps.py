"""Openings of one facade do not overlap: those that do compete, as the rectangles of the layout did."""

from collections.abc import Sequence

import numpy as np
import shapely

from frontage.geometry.arrays import Array, Float, Int
from frontage.model.opening import Opening
from frontage.openings.borders.agreement import with_rough_borders
from frontage.openings.borders.outline import Outline
from frontage.openings.boxes import Box
from frontage.openings.layout.selection import PRICE, best_apart, worth_of
from frontage.openings.wall.evidence import Evidence

_LEAST = 1e-3  # nats that an opening is worth at least, so that one of several is left


def without_overlaps(
    outlines: Sequence[Outline], rough: Sequence[Box], evidence: Evidence
) -> list[Outline | None]:
    """Returns the outlines without overlap, None for those dropped; `rough` are their boxes in the layout.

    An outline that overlaps others stays as it was measured, or takes the layout's borders where it runs over
    a neighbour, or is dropped: whichever set is worth most, the evidence within less the price of each. So
    what the layout took for two openings becomes one where a single outline explains both.
    """
    first, second = _overlapping(_polygons([o.bare_ring for o in outlines]))
    over: dict[int, set[int]] = {}
    for a, b in [*zip(first, second, strict=True), *zip(second, first, strict=True)]:
        over.setdefault(int(a), set()).update(_beyond(outlines[a].place, rough[a], rough[b]))
    cell = evidence.raster.cell
    trials = [(k, o) for k, o in enumerate(outlines)]
    trials += [
        (k, with_rough_borders(outlines[k], rough[k], sides, cell)) for k, sides in sorted(over.items())
    ]
    rings = _polygons([o.bare_ring for _, o in trials])
    owner = np.array([k for k, _ in trials], np.int64)
    pairs = np.hstack([_overlapping(rings), np.argwhere(np.triu(owner[:, None] == owner, 1)).T])
    worth = np.zeros(len(trials))
    for k in np.unique(pairs):
        worth[k] = _worth(rings[k], evidence)
    found: list[Outline | None] = [None] * len(outlines)
    for k in best_apart(worth, pairs):
        found[owner[k]] = trials[k][1]
    return found


def best_without_overlaps(openings: Sequence[Opening]) -> list[Opening]:
    """Returns the openings of all walls of a facade without overlap as seen from the street.

    Of those that overlap, the set with the most evidence stays. Doors that reach down behind a balcony
    overlap others, and so do openings that a front hides in part.
    """
    worth = np.array([max(o.evidence, _LEAST) for o in openings])
    return [openings[k] for k in best_apart(worth, _overlapping(_polygons([o.ring for o in openings])))]


def _beyond(place: Box, own: Box, other: Box) -> list[int]:
    """Returns the sides of a place that lie beyond its own box of the layout, towards another box."""
    ahead = [k for k in (0, 1) if own[k + 2] <= other[k] and place[k + 2] > own[k + 2]]
    back = [k for k in (0, 1) if other[k + 2] <= own[k] and place[k] < own[k]]
    return [*back, *(k + 2 for k in ahead)]


def _worth(ring: shapely.Polygon, evidence: Evidence) -> float:
    """Returns the nats that a ring is worth as an opening."""
    raster = evidence.raster
    x0, z0, x1, z1 = ((v - raster.corner[k % 2]) / raster.cell for k, v in enumerate(ring.bounds))
    rows, columns = slice(max(int(z0), 0), int(z1) + 2), slice(max(int(x0), 0), int(x1) + 2)
    worth = worth_of(evidence, (rows, columns))
    z, x = np.indices(worth.shape) + np.array([rows.start, columns.start])[:, None, None] + 0.5
    inside = shapely.contains_xy(ring, raster.corner[0] + x * raster.cell, raster.corner[1] + z * raster.cell)
    return float(worth[inside].sum()) - PRICE


def _polygons(rings: Sequence[Float]) -> Array:
    """Makes valid polygons (n,) of rings."""
    return np.array([shapely.make_valid(shapely.Polygon(r)) for r in rings], object)


def _overlapping(polygons: Array) -> Int:
    """Returns the pairs (2, k) of polygons (n,) whose interiors meet, the lower number first."""
    first, second = shapely.STRtree(polygons).query(polygons, predicate="intersects")
    first, second = np.stack([first, second])[:, first < second]
    meet = shapely.relate_pattern(polygons[first], polygons[second], "T********")
    return np.stack([first, second])[:, meet].astype(np.int64)
