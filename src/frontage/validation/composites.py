"""Level 5 and 6: solids among each other. Codes 501 to 503 in one CompositeSolid, 601 in one building."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from frontage.geometry.arrays import Float
from frontage.model import Finding
from frontage.validation.bodies import Shell
from frontage.validation.cells import INSIDE, OPPOSITE, SAME, Pieces, Skin, compare
from frontage.validation.geometry.distances import to_triangles
from frontage.validation.tolerances import Tolerances

_ON = 8  # in noise


@dataclass(frozen=True, eq=False)
class Body:
    """A valid solid: its shells, and how findings call it."""

    shells: tuple[Shell, ...]
    name: str

    @cached_property
    def skin(self) -> Skin:
        """The triangles of all its shells."""
        mesh = self.shells[0][0]
        return Skin(mesh.xyz, np.concatenate([t.ids for _, t in self.shells]), mesh.noise)


@dataclass(frozen=True, eq=False)
class _Relation:
    """Two solids: how far they overlap (m) and where, whether they are the same, whether they share faces."""

    overlap: float
    where: Float
    same: bool
    joined: bool


def check_composite(bodies: Sequence[Body], tolerances: Tolerances) -> list[Finding]:
    """Findings on the solids of one CompositeSolid, each valid in itself."""
    limit = _limit(bodies, tolerances)
    findings, links = [], []
    for i, j in _close(bodies, limit):
        relation = _relate(bodies[i], bodies[j], limit)
        if relation.joined:
            links.append((i, j))
        where = f"{bodies[i].name}&{bodies[j].name}"
        at = bodies[0].shells[0][0].place(relation.where)
        if relation.same:
            findings.append(Finding(502, "two solids are the same", where, "", at))
        elif relation.overlap > limit:
            findings.append(Finding(501, f"two solids overlap by {relation.overlap:.4g} m", where, "", at))
    return findings or _unconnected(bodies, links)


def check_parts(bodies: Sequence[Body], groups: Sequence[object], tolerances: Tolerances) -> list[Finding]:
    """601 for solids of one building whose insides overlap; those of one group are not compared."""
    limit = _limit(bodies, tolerances)
    findings = []
    for i, j in _close(bodies, 0.0):
        if groups[i] == groups[j]:
            continue
        relation = _relate(bodies[i], bodies[j], 0.0)
        if relation.same or relation.overlap > limit:
            at = bodies[0].shells[0][0].place(relation.where)
            text = f"solids of one building overlap by {relation.overlap:.4g} m"
            findings.append(Finding(601, text, f"{bodies[i].name}&{bodies[j].name}", "", at))
    return findings


def adjacent(one: Body, other: Body, tolerances: Tolerances) -> bool:
    """Whether two solids share a piece of a face, overlap, or are no further apart than the tolerance."""
    limit = _limit([one, other], tolerances)
    return bool(_close([one, other], limit)) and _relate(one, other, limit).joined


def _limit(bodies: Sequence[Body], tolerances: Tolerances) -> float:
    noise = _ON * bodies[0].shells[0][0].noise if bodies else 0.0
    return noise + max(tolerances.overlap, 0.0)


def _close(bodies: Sequence[Body], reach: float) -> list[tuple[int, int]]:
    """Pairs (i < j) of solids whose boxes, grown by `reach`, meet."""
    if len(bodies) < 2:
        return []
    low = np.array([body.skin.corners.min((0, 1)) for body in bodies])
    high = np.array([body.skin.corners.max((0, 1)) for body in bodies]) + reach + bodies[0].skin.noise
    tree = shapely.STRtree(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))
    i, j = tree.query(tree.geometries)
    meet = (i < j) & (low[i, 2] <= high[j, 2]) & (low[j, 2] <= high[i, 2])
    return sorted(zip(i[meet].tolist(), j[meet].tolist(), strict=True))


def _relate(one: Body, other: Body, reach: float) -> _Relation:
    """Of two solids that are close; a gap of up to `reach` still joins them."""
    a, b = one.skin, other.skin
    sides = compare(a, b), compare(b, a)
    measured = [m for pieces in sides for m in _overlaps(pieces)]
    overlap, where = max(measured, key=lambda m: m[0], default=(0.0, a.corners.mean((0, 1))))
    same = all((pieces.state == SAME).all() for pieces in sides)
    joined = overlap > 0 or any(pieces.has(OPPOSITE) for pieces in sides)
    joined = joined or (reach > _ON * a.noise and _gap(a, b) <= reach)
    return _Relation(overlap, where, same, joined)


def _overlaps(pieces: Pieces) -> list[tuple[float, Float]]:
    """Depth of pieces inside the other solid, width of those on it that look the same way."""
    found = []
    for state, size in ((INSIDE, pieces.depth), (SAME, pieces.width)):
        own = np.nonzero(pieces.state == state)[0]
        if len(own):
            worst = own[np.argmax(size[own])]
            found.append((float(size[worst]), pieces.middle[worst]))
    return found


def _gap(one: Skin, other: Skin) -> float:
    """Smallest distance (m) of a vertex of one to the other."""
    first, _ = to_triangles(one.xyz[np.unique(one.ids)], other.corners)
    second, _ = to_triangles(other.xyz[np.unique(other.ids)], one.corners)
    return float(min(first.min(), second.min()))


def _unconnected(bodies: Sequence[Body], links: Sequence[tuple[int, int]]) -> list[Finding]:
    """503: solids that share no face, not even through others, with the first one."""
    ends = np.array(links, np.int64).reshape(-1, 2)
    graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(len(bodies),) * 2)
    group = connected_components(graph, directed=False)[1]
    findings = []
    for k in map(int, np.nonzero(group != group[0])[0]):
        mesh = bodies[k].shells[0][0]
        at = mesh.place(bodies[k].skin.corners.mean((0, 1)))
        findings.append(Finding(503, "the solid shares no face with the others", bodies[k].name, "", at))
    return findings
