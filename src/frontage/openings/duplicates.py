"""Settles openings that several facades of a building show: each belongs to one wall only."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.geometry.ring import at_depth
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY, TOLERANCES
from frontage.model.opening import Elements, OpeningKind
from frontage.model.scan import Scan
from frontage.openings.wall.raster import WallRaster

_SAME = 0.5  # share of the smaller of two openings that the other must cover for them to be at one place
_NESTED = 0.9  # share of an outline that lies within a larger one for it to be a step within that wall
_HALL = 1.0  # m, least depth of what a passage leads to
_RIM = 0.25  # m, width of the rim around an opening that tells which wall it is in

Judged = tuple[Facade, Elements]


def without_duplicates(judged: Sequence[Judged], scan: Scan) -> list[Judged]:
    """Returns the facades with their elements, every opening on one facade of its building only.

    The outlines of parallel facades overlap where the wall steps: both follow its depth, and both find the
    openings of either part and what steps out or back between them. A plane through curtains shows what lies
    between them as well. An opening belongs to the wall whose plane surrounds it: of two at one place, the
    one whose rim shows less of its own plane is dropped.
    """
    judged = list(judged)
    pairs = [p for p in combinations(range(len(judged)), 2) if _beside(*(judged[k][0] for k in p))]
    for a, b in pairs:
        judged[b] = _without_doubled(judged[b], judged[a])
    for a, b in pairs:
        judged[a] = _outside(judged[a], judged[b][0], scan)
        judged[b] = _outside(judged[b], judged[a][0], scan)
    dropped: set[tuple[int, int]] = set()
    for a, b in pairs:
        own, others = _rings(judged[a], judged[a][0]), _rings(judged[b], judged[a][0])
        for i, k in zip(*_same(own, others), strict=True):
            passed = _leads_to(judged[a], i, judged[b], k) or _leads_to(judged[b], k, judged[a], i)
            if {(a, i), (b, k)} & dropped or passed:
                continue
            first, second = (_walled(*judged[f], o, scan) for f, o in ((a, i), (b, k)))
            dropped.add((b, k) if first >= second else (a, i))
    judged = [
        (f, replace(e, openings=tuple(o for k, o in enumerate(e.openings) if (n, k) not in dropped)))
        for n, (f, e) in enumerate(judged)
    ]
    for a, b in pairs:
        judged[a], judged[b] = _without_walls(judged[a], judged[b]), _without_walls(judged[b], judged[a])
    return judged


def _leads_to(front: Judged, i: int, back: Judged, k: int) -> bool:
    """Returns whether an opening of one facade is a passage to the wall of another one's, as in an arcade."""
    (facade, elements), (behind, others) = front, back
    passage, opening = elements.openings[i], others.openings[k]
    if passage.kind is not OpeningKind.PASSAGE:
        return False
    _, (y,) = _onto(facade, behind, [(opening.ring, others.wall_y(opening))])
    return y - elements.wall_y(passage) > _HALL


def _beside(a: Facade, b: Facade) -> bool:
    """Returns whether two facades of one building are parallel and their planes near each other.

    No house fits between such planes, so they face the same way, even where unknown sensors left their sides
    in doubt.
    """
    if a.building != b.building:
        return False
    offset = float(a.frame.inverse.apply(b.frame.t[None])[0, 1])
    return (
        bool(abs(a.frame.R[:, 1] @ b.frame.R[:, 1]) > TOLERANCES.parallel_cos)
        and abs(offset) < MASONRY.facade_reach
    )


def _outside(judged: Judged, inner: Facade, scan: Scan) -> Judged:
    """Drops the openings of a facade that lie within another one which is a step within its outline.

    An outline is one ring, so that of a wall with a colonnade in its middle goes on across it. Within such an
    inner outline the openings are those of the plane that shows more wall there: a plane through the curtains
    of a wall has less of it than the wall itself.
    """
    facade, elements = judged
    own = shapely.make_valid(shapely.Polygon(facade.outline))
    (ring,), _ = _onto(facade, inner, [(inner.outline, 0.0)])
    is_step = shapely.intersection(own, ring).area >= _NESTED * ring.area and ring.area < _NESTED * own.area
    if not is_step or not _shows_more_wall(inner, facade, scan):
        return judged
    rings = _rings(judged, facade)
    kept = [shapely.intersection(ring, r).area <= _SAME * r.area for r in rings]
    openings = tuple(o for o, keep in zip(elements.openings, kept, strict=True) if keep)
    return facade, replace(elements, openings=openings)


def _shows_more_wall(inner: Facade, outer: Facade, scan: Scan) -> bool:
    """Returns whether more of the area of `inner` has points on its own plane than on that of `outer`."""
    points = np.take(scan.xyz, inner.support, axis=0)
    q = inner.frame.inverse.apply(points)
    raster = WallRaster.over(inner, _cell(inner))
    own, other = (
        (raster.count(*q[np.abs(depth) <= _near(facade)][:, [0, 2]].T) > 0).sum()
        for facade, depth in ((inner, q[:, 1]), (outer, outer.frame.inverse.apply(points)[:, 1]))
    )
    return bool(own > other)


def _near(facade: Facade) -> float:
    """Returns how far (m) from its plane points of a facade are on it."""
    return max(3.0 * facade.roughness, TOLERANCES.least_on_wall)


def _cell(facade: Facade) -> float:
    """Returns the side (m) of cells in which the wall of a facade leaves points."""
    return max(2.0 * facade.spacing, TOLERANCES.least_on_wall)


def _without_doubled(judged: Judged, other: Judged) -> Judged:
    """Drops the fronts of a facade that are also fronts of another facade with more wall, and their openings.

    A step back from the one facade is a step out from the other. Fronts are those of oriels and of set-back
    parts.
    """
    facade, elements = judged
    own = [p for p in elements.protrusions if p.kind.is_wall]
    there = [p for p in other[1].protrusions if p.kind.is_wall]
    (first, y), (second, level) = (
        _onto(other[0], f, [(p.ring, float(p.front.value)) for p in walls])
        for f, walls in ((facade, own), (other[0], there))
    )
    double = {
        own[i].id
        for i, k in zip(*_same(first, second), strict=True)
        if abs(y[i] - level[k]) < MASONRY.step_out
    }
    kept = tuple(p for p in elements.protrusions if p.id not in double)
    openings = tuple(o for o in elements.openings if o.on not in double)
    return facade, replace(elements, protrusions=kept, openings=openings)


def _without_walls(judged: Judged, other: Judged) -> Judged:
    """Drops the fronts of a facade that are the wall of another facade, unless openings belong to them.

    What stands out or back beside a facade may be a facade itself: the model has one wall there.
    """
    facade, elements = judged
    carriers = {o.on for o in elements.openings}
    walls = [p for p in elements.protrusions if p.kind.is_wall and p.id not in carriers]
    rings, y = _onto(other[0], facade, [(p.ring, float(p.front.value)) for p in walls])
    wall = shapely.make_valid(shapely.Polygon(other[0].outline))
    double = {
        p.id
        for p, ring, at in zip(walls, rings, y, strict=True)
        if abs(at) < MASONRY.step_out and shapely.intersection(wall, ring).area > _SAME * ring.area
    }
    kept = tuple(p for p in elements.protrusions if p.id not in double)
    return facade, replace(elements, protrusions=kept)


def _rings(judged: Judged, onto: Facade) -> list[shapely.Polygon]:
    """Returns the rings of the openings, projected onto a facade's plane."""
    facade, elements = judged
    return _onto(onto, facade, [(o.ring, elements.wall_y(o)) for o in elements.openings])[0]


def _onto(
    onto: Facade, facade: Facade, outlines: Sequence[tuple[Float, float]]
) -> tuple[list[shapely.Polygon], list[float]]:
    """Projects rings (k, 2) m at y m of a facade onto another plane; also returns their mean y m there."""
    rings, depths = [], []
    for ring, y in outlines:
        own = at_depth(ring, y)
        there = onto.frame.inverse.apply(facade.frame.apply(own))
        rings.append(shapely.make_valid(shapely.Polygon(there[:, [0, 2]])))
        depths.append(float(there[:, 1].mean()))
    return rings, depths


def _same(a: list[shapely.Polygon], b: list[shapely.Polygon]) -> tuple[list[int], list[int]]:
    """Returns which of the rings `a` and `b` are at one place, as two lists of numbers."""
    first, second = np.array(a, object)[:, None], np.array(b, object)[None, :]
    least = np.minimum(shapely.area(first), shapely.area(second))
    i, k = np.nonzero(shapely.area(shapely.intersection(first, second)) > _SAME * least)
    return i.tolist(), k.tolist()


def _walled(facade: Facade, elements: Elements, number: int, scan: Scan) -> float:
    """Returns the share of an opening's rim where points lie on the plane of its own wall."""
    opening = elements.openings[number]
    ring = shapely.make_valid(shapely.Polygon(opening.ring))
    x0, z0, x1, z1 = shapely.bounds(shapely.buffer(ring, _RIM))
    q = facade.frame.inverse.apply(scan.xyz[facade.support])
    depth = q[:, 1] - elements.wall_y(opening)
    on, cell = q[np.abs(depth) <= _near(facade)], _cell(facade)
    raster = WallRaster((x0, z0), cell, (int((z1 - z0) / cell) + 1, int((x1 - x0) / cell) + 1))
    rows, columns = np.indices(raster.shape) + 0.5
    rim = ~shapely.contains_xy(ring, x0 + columns * cell, z0 + rows * cell)
    return float((rim & (raster.count(on[:, 0], on[:, 2]) > 0)).sum() / max(rim.sum(), 1))
