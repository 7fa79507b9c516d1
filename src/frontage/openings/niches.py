"""Niches: openings whose back, half a metre in or more, is a wall or joinery with openings of its own.

A part that seems to be a wall set back, but has no openings of its own, may be the leaf of an opening.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely

from frontage.geometry.arrays import distinct
from frontage.model.estimate import Estimate, Provenance
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY
from frontage.model.opening import Opening, Protrusion, ProtrusionKind
from frontage.openings.borders.depth import FRAME
from frontage.openings.borders.spandrels import ROW, spandrel_top
from frontage.openings.fronts import FrontSearch, is_hidden
from frontage.openings.wall.raster import WallRaster

_LEAST = 0.5  # m, depth of a niche at least: reveals are less deep, but for those above a spandrel
_STRIP = 0.3  # m, width of the strips of wall at both sides that tell how dense points are
_FRAME = 0.3  # m: frames lie less deep
_OFF, _RIM = 0.03, 0.1  # m off the borders, between which the back is looked for first: the cheeks lie nearer
_BIN = 0.02  # m, bin of depths
_BEHIND = 3.0  # m behind a niche within which the beams through a lattice end
_FIRST = 0.25  # share of that strip that the foremost surface must fill: a frame 5 cm wide does
_LEAF = 0.9  # share of the area that an opening and the leaf that fills it cover together
_SAME = 0.05  # m by which the width and height of niches of one form differ
_ALONE = 0.7  # share of the back from which a single opening is the back itself: a door in a deep reveal


def find_niches(
    openings: Sequence[Opening], protrusions: Sequence[Protrusion], fronts: FrontSearch
) -> tuple[Protrusion, ...]:
    """Returns those of the `openings` of the main wall that are niches, as fronts behind the wall.

    They are of the kind "niche" and have no id yet. Nothing stands along the borders of a niche until its
    back. This shows two openings or more, or one that leaves a wall around it, or the back of a niche of the
    same form does. All others are openings with deep reveals, or with a lattice in place of a wall.
    """
    before = shapely.union_all([shapely.Polygon(p.ring) for p in protrusions if p.kind.is_wall])
    niches, rest = [], []
    for opening in openings:
        if is_hidden(opening, before) or _has_frame(opening, fronts.facade):
            continue
        back = _back(opening, fronts)
        is_deep = back is not None and (back.value >= _LEAST or _has_spandrel(opening, fronts))
        niche = _niche(opening, back) if back is not None and is_deep else None
        if niche is not None and _has_openings(niche, fronts):
            niches.append(niche)
        else:
            rest.append(opening)
    return (*niches, *_like_niches(rest, niches))


def _has_frame(opening: Opening, facade: Facade) -> bool:
    """Returns whether a frame runs along the borders of an opening, or a surface no deeper than one.

    A frame holds as many points as a surface there; edges of parapets and what stands in a niche hold few.
    """
    if opening.depth is None or opening.depth.value >= _FRAME:
        return False
    width, height = np.ptp(opening.ring, axis=0)
    full = (width + 2.0 * height) * (FRAME[1] - FRAME[0]) / facade.spacing**2
    return bool(opening.depth.dof > _FIRST * full)


def _has_openings(niche: Protrusion, fronts: FrontSearch) -> bool:
    """Returns whether the back of a niche is wall with two openings, or with one and wall around it."""
    inner = fronts.openings(niche)
    area = sum(shapely.Polygon(o.ring).area for o in inner)
    several = len(inner) > 1 or 0.0 < area < _ALONE * shapely.Polygon(niche.ring).area
    return several and _is_wall(niche, inner, fronts)


def _like_niches(openings: Sequence[Opening], niches: Sequence[Protrusion]) -> list[Protrusion]:
    """Returns those of the `openings` as niches that have the form of one; their backs are as deep.

    From the street, the parapets of upper loggias hide the windows at their backs.
    """
    found = []
    for opening in openings:
        size = np.ptp(opening.ring, axis=0)
        like = [n for n in niches if np.abs(np.ptp(n.ring, axis=0) - size).max() < _SAME]
        if like:
            front = sorted(like, key=lambda n: float(n.front.value))[len(like) // 2].front
            found.append(replace(_niche(opening, front), provenance=Provenance.POOLED))
    return found


def without_leaves(
    protrusions: Sequence[Protrusion], openings: Sequence[Opening], fronts: FrontSearch
) -> tuple[Protrusion, ...]:
    """Returns the protrusions without the leaves of gates and the blinds of large windows.

    These are full of points, and may be larger than the least part of a wall that is set back. Such a part
    has openings with wall around them, or is no opening of the main wall. Gaps at the sides of a curtain have
    no wall beside them.
    """
    rings = [shapely.Polygon(o.ring) for o in openings]

    def is_leaf(part: Protrusion) -> bool:
        """Returns whether a part fills one of the openings and has none of its own."""
        if part.kind is not ProtrusionKind.SETBACK:
            return False
        own = shapely.Polygon(part.ring)
        fills = any(own.intersection(ring).area > _LEAF * own.union(ring).area for ring in rings)
        return fills and not any(_has_wall_around(o, part) for o in fronts.openings(part))

    return tuple(part for part in protrusions if not is_leaf(part))


def _has_wall_around(opening: Opening, part: Protrusion) -> bool:
    """Returns whether a pier fits beside an opening, on both sides, and above it within its part."""
    low, high = opening.ring.min(0), opening.ring.max(0)
    beside = min(low[0] - part.ring[:, 0].min(), part.ring[:, 0].max() - high[0])
    return bool(min(beside, part.ring[:, 1].max() - high[1]) >= MASONRY.half_brick)


def _back(opening: Opening, fronts: FrontSearch) -> Estimate[float] | None:
    """Finds the surface that shows first behind the borders of an opening.

    Returns its depth y m, None where it is not the back of a niche. Areas are counted in cells, for scans are
    denser near by. The strip along the foot does not count: steps and goods may stand there.
    """
    (x0, z0), (x1, z1) = opening.ring.min(0), opening.ring.max(0)
    facade, (x, y, z) = fronts.facade, fronts.q[fronts.rows_within((x0, z0, x1, z1))].T
    low, high = 3.0 * facade.roughness, MASONRY.facade_reach
    near = np.flatnonzero((y > low) & (y < high))
    off = np.minimum(np.minimum(x[near] - x0, x1 - x[near]), z1 - z[near])
    near = near[(off > _OFF) & (off < _RIM)]
    side, bins = max(2.0 * facade.spacing, _OFF), int((high - low) / _BIN) + 1
    raster = WallRaster((float(x0), float(z0)), side, (int((z1 - z0) / side) + 1, int((x1 - x0) / side) + 1))
    level = ((y[near] - low) / _BIN).astype(np.int64)
    held = np.bincount(distinct(raster.flat(x[near], z[near]) * bins + level) % bins, minlength=bins)
    cells = (2.0 * (z1 - z0) + x1 - x0) * (_RIM - _OFF) / side**2
    first = np.flatnonzero(held[:-1] + held[1:] > _FIRST * cells)
    if len(first) == 0 or low + (first[0] + 1) * _BIN < _FRAME:
        return None
    own = y[near][(level >= first[0]) & (level <= first[0] + 1)]
    spread = max(float(own.std()), facade.roughness) / np.sqrt(_FIRST * cells)
    return Estimate(float(np.median(own)), np.array([[spread**2 + facade.sigma_plane**2]]), float(len(own)))


def _has_spandrel(opening: Opening, fronts: FrontSearch) -> bool:
    """Returns whether a wall fills the foot of an opening behind the face of its wall, below a window."""
    (x0, z0), (x1, z1) = opening.ring.min(0), opening.ring.max(0)
    x, y, z = fronts.q[fronts.rows_within((x0 - _STRIP, z0, x1 + _STRIP, z1))].T
    off = 3.0 * fronts.facade.roughness
    on_wall = np.abs(y) < off
    inside = (x > x0 + _RIM) & (x < x1 - _RIM) & (y > MASONRY.panel) & (y < MASONRY.facade_reach)
    per_row = on_wall.sum() / (2.0 * _STRIP * (z1 - z0)) * (x1 - x0 - 2.0 * _RIM) * ROW
    return spandrel_top(z[inside] - z0, y[inside], float(z1 - z0), off, float(per_row)) is not None


def _is_wall(niche: Protrusion, openings: Sequence[Opening], fronts: FrontSearch) -> bool:
    """Returns whether the back of a niche is wall or joinery around its `openings`.

    Most of the points that show there at all must lie on it. Through a lattice, they lie behind.
    """
    (x0, z0), (x1, z1) = niche.ring.min(0) + _RIM, niche.ring.max(0) - _RIM
    x, y, z = fronts.q[fronts.rows_within((x0, z0, x1, z1))].T
    back, slack = float(niche.front.value), max(3.0 * fronts.facade.roughness, _BIN)
    near = np.flatnonzero((y >= back - slack) & (y < back + _BEHIND))
    through = shapely.union_all([shapely.Polygon(o.ring).buffer(_OFF) for o in openings])
    around = ~shapely.contains_xy(through, x[near], z[near])
    on = y[near] <= back + slack
    return int((on & around).sum()) > int((~on & around).sum())


def _niche(opening: Opening, back: Estimate[float]) -> Protrusion:
    """Makes the protrusion of kind "niche" of an opening and its back."""
    sigma = float(np.sqrt(np.mean(np.diag(opening.ring_covariance))))
    return Protrusion(
        "", ProtrusionKind.NICHE, opening.ring, sigma, back, Provenance.MEASURED, opening.confidence
    )
