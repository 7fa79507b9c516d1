"""Levels 5 and 6: several solids together. Codes 501 to 503 in a CompositeSolid, 601 in a building."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from frontage.geometry.arrays import Float
from frontage.model import Finding
from frontage.validation.closed_surface import ClosedSurface, ValidSolid
from frontage.validation.geometry.distances import to_closest_triangle
from frontage.validation.pieces import (
    INSIDE,
    ON_NOISES,
    OPPOSITE,
    SAME,
    ClassifiedPieces,
    classify_pieces,
)
from frontage.validation.tolerances import Tolerances


@dataclass(frozen=True, eq=False)
class Relation:
    """How two solids lie to each other.

    overlap  m: how far they reach into each other
    where    (3,) m: where they do so most
    same     whether they are the same solid
    joined   whether they share a part of a face, overlap, or are as close as the tolerance
    """

    overlap: float
    where: Float
    same: bool
    joined: bool


def check_composite(solids: Sequence[ValidSolid], tolerances: Tolerances) -> list[Finding]:
    """Checks the solids of one CompositeSolid, each of them valid in itself."""
    limit = _limit(solids, tolerances)
    findings, links = [], []
    for i, j in _close_pairs(solids, limit):
        relation = _relate(solids[i], solids[j], limit)
        if relation.joined:
            links.append((i, j))
        where = f"{solids[i].name}&{solids[j].name}"
        at = solids[0].location(relation.where)
        if relation.same:
            findings.append(Finding(502, "two solids are the same", where, "", at))
        elif relation.overlap > limit:
            text = f"two solids overlap by {relation.overlap:.4g} m"
            findings.append(Finding(501, text, where, "", at))
    return findings or _unconnected(solids, links)


def check_parts(
    solids: Sequence[ValidSolid], groups: Sequence[object], tolerances: Tolerances
) -> list[Finding]:
    """Finds 601 for solids of one building whose interiors overlap; solids of one group are not compared."""
    findings = []
    for i, j, relation in overlaps(solids, groups, tolerances):
        at = solids[0].location(relation.where)
        text = f"solids of one building overlap by {relation.overlap:.4g} m"
        findings.append(Finding(601, text, f"{solids[i].name}&{solids[j].name}", "", at))
    return findings


def overlaps(
    solids: Sequence[ValidSolid], groups: Sequence[object], tolerances: Tolerances
) -> list[tuple[int, int, Relation]]:
    """Returns the pairs (i < j) of solids of different groups whose interiors overlap, and how they lie."""
    limit = _limit(solids, tolerances)
    found = []
    for i, j in _close_pairs(solids, 0.0):
        if groups[i] != groups[j]:
            relation = _relate(solids[i], solids[j], 0.0)
            if relation.same or relation.overlap > limit:
                found.append((i, j, relation))
    return found


def adjacent(one: ValidSolid, other: ValidSolid, tolerances: Tolerances) -> bool:
    """Decides whether two solids share a part of a face, overlap, or are as close as the tolerance."""
    limit = _limit([one, other], tolerances)
    return bool(_close_pairs([one, other], limit)) and _relate(one, other, limit).joined


def _limit(solids: Sequence[ValidSolid], tolerances: Tolerances) -> float:
    """Returns the overlap or gap (m) that is accepted."""
    noise = ON_NOISES * solids[0].mesh.noise if solids else 0.0
    return noise + max(tolerances.overlap, 0.0)


def _close_pairs(solids: Sequence[ValidSolid], reach: float) -> list[tuple[int, int]]:
    """Returns the pairs (i < j) of solids whose boxes, grown by `reach` (m), intersect."""
    if len(solids) < 2:
        return []
    low = np.array([s.surface.corners.min((0, 1)) for s in solids])
    high = np.array([s.surface.corners.max((0, 1)) for s in solids]) + reach + solids[0].mesh.noise
    tree = shapely.STRtree(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))
    i, j = tree.query(tree.geometries)
    meet = (i < j) & (low[i, 2] <= high[j, 2]) & (low[j, 2] <= high[i, 2])
    return sorted(zip(i[meet].tolist(), j[meet].tolist(), strict=True))


def _relate(one: ValidSolid, other: ValidSolid, reach: float) -> Relation:
    """Returns how two close solids lie to each other; a gap of up to `reach` (m) still joins them."""
    a, b = one.surface, other.surface
    sides = classify_pieces(a, b), classify_pieces(b, a)
    overlaps = [o for pieces in sides for o in _overlaps(pieces)]
    overlap, where = max(overlaps, key=lambda o: o[0], default=(0.0, a.corners.mean((0, 1))))
    same = all((pieces.state == SAME).all() for pieces in sides)
    joined = overlap > 0 or any(pieces.has(OPPOSITE) for pieces in sides)
    joined = joined or (reach > ON_NOISES * a.noise and _gap(a, b) <= reach)
    return Relation(overlap, where, same, joined)


def _overlaps(pieces: ClassifiedPieces) -> list[tuple[float, Float]]:
    """Returns how far pieces reach into the other solid (m), each with the place (3,) m where it is worst.

    That is the depth of pieces inside it, and the width of pieces on it that look the same way.
    """
    found = []
    for state, size in ((INSIDE, pieces.depth), (SAME, pieces.width)):
        own = np.nonzero(pieces.state == state)[0]
        if len(own):
            worst = own[np.argmax(size[own])]
            found.append((float(size[worst]), pieces.middle[worst]))
    return found


def _gap(one: ClosedSurface, other: ClosedSurface) -> float:
    """Returns the smallest distance (m) of a vertex of one surface to the other."""
    first, _ = to_closest_triangle(one.xyz[np.unique(one.ids)], other.corners)
    second, _ = to_closest_triangle(other.xyz[np.unique(other.ids)], one.corners)
    return float(min(first.min(), second.min()))


def _unconnected(solids: Sequence[ValidSolid], links: Sequence[tuple[int, int]]) -> list[Finding]:
    """503: a solid shares no face with the first one, not even through other solids."""
    ends = np.array(links, np.int64).reshape(-1, 2)
    graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(len(solids),) * 2)
    group = connected_components(graph, directed=False)[1]
    findings = []
    for k in map(int, np.nonzero(group != group[0])[0]):
        at = solids[k].location(solids[k].surface.corners.mean((0, 1)))
        findings.append(Finding(503, "the solid shares no face with the others", solids[k].name, "", at))
    return findings
