"""Level 5 and 6: solids among each other. Codes 501 to 503 in one CompositeSolid, 601 in one building."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from frontage.geometry.arrays import Float
from frontage.model import Finding
from frontage.solids.bodies import Shell
from frontage.solids.cells import INSIDE, OPPOSITE, SAME, Pieces, Skin, compare
from frontage.solids.distances import to_triangles
from frontage.solids.tolerances import Tolerances

_ON = 8  # in noise


@dataclass(frozen=True, eq=False)
class Body:
    """A valid solid: its shells, and how findings call it."""

    shells: tuple[Shell, ...]
    name: str

    @property
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
    for i, j in itertools.combinations(range(len(bodies)), 2):
        relation = _relate(bodies[i], bodies[j], max(limit, 0.0))
        if relation is None:
            continue
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
    for i, j in itertools.combinations(range(len(bodies)), 2):
        if groups[i] == groups[j]:
            continue
        relation = _relate(bodies[i], bodies[j], 0.0)
        if relation is not None and (relation.same or relation.overlap > limit):
            at = bodies[0].shells[0][0].place(relation.where)
            text = f"solids of one building overlap by {relation.overlap:.4g} m"
            findings.append(Finding(601, text, f"{bodies[i].name}&{bodies[j].name}", "", at))
    return findings


def _limit(bodies: Sequence[Body], tolerances: Tolerances) -> float:
    noise = _ON * bodies[0].shells[0][0].noise if bodies else 0.0
    return noise + max(tolerances.overlap, 0.0)


def _relate(one: Body, other: Body, reach: float) -> _Relation | None:
    """None when the boxes of the two, grown by `reach`, are apart."""
    a, b = one.skin, other.skin
    pa, pb = a.corners.reshape(-1, 3), b.corners.reshape(-1, 3)
    if (pa.min(0) > pb.max(0) + reach + a.noise).any() or (pb.min(0) > pa.max(0) + reach + a.noise).any():
        return None
    sides = compare(a, b), compare(b, a)
    measured = [m for pieces in sides for m in _overlaps(pieces)]
    overlap, where = max(measured, key=lambda m: m[0], default=(0.0, pa.mean(0)))
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
    first, _ = to_triangles(np.unique(one.corners.reshape(-1, 3), axis=0), other.corners)
    second, _ = to_triangles(np.unique(other.corners.reshape(-1, 3), axis=0), one.corners)
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
