"""Niches: openings whose back, half a metre in or more, is wall or joinery with openings of its own."""

from collections.abc import Sequence

import numpy as np
import shapely

from frontage.geometry.arrays import Float, distinct
from frontage.model.estimate import Estimate, Provenance
from frontage.model.facade import Facade
from frontage.model.opening import Opening, Protrusion, ProtrusionKind
from frontage.openings.recursion import Fronts, is_hidden
from frontage.openings.wall.beams import Raster

_LEAST, _MOST = 0.5, 2.0  # m: reveals are less deep, passages and rooms deeper
_FRAME = 0.3  # m: frames are less deep; what stands in a niche may be told for one
_OFF, _RIM = 0.03, 0.1  # m off the borders, between which the back shows first: cheeks lie nearer
_BIN = 0.02  # m, of depth
_FIRST = 0.25  # share of that rim that the foremost surface holds: a frame 5 cm wide does
_ALONE = 0.7  # share of the back from which a single opening is the back itself: a door in a deep reveal


def find_niches(
    openings: Sequence[Opening], protrusions: Sequence[Protrusion], fronts: Fronts
) -> tuple[Protrusion, ...]:
    """The `openings` of the main wall that are niches, as fronts behind the wall (kind "niche", no id).

    Nothing stands along their borders until the back, which shows two openings or more, or one that leaves
    a wall around it. All others are openings with deep reveals.
    """
    before = shapely.union_all([shapely.Polygon(p.ring) for p in protrusions if p.kind.is_wall])
    niches = []
    for opening in openings:
        shallow = opening.depth is not None and opening.depth.value < _FRAME
        back = None if shallow or is_hidden(opening, before) else _back(fronts.q, opening, fronts.facade)
        if back is None:
            continue
        niche = _niche(opening, back)
        inner = fronts.openings(niche)
        area = sum(shapely.Polygon(o.ring).area for o in inner)
        if len(inner) > 1 or 0.0 < area < _ALONE * shapely.Polygon(opening.ring).area:
            niches.append(niche)
    return tuple(niches)


def _back(q: Float, opening: Opening, facade: Facade) -> Estimate[float] | None:
    """y m of the surface that points q (n, 3) show first behind an opening's borders, None where it is no
    niche's back.

    Counted in cells: scans are denser near by. Along the foot steps and goods may stand.
    """
    (x0, z0), (x1, z1) = opening.ring.min(0), opening.ring.max(0)
    x, y, z = q.T
    low, high = 3.0 * facade.roughness, _MOST
    near = np.flatnonzero((y > low) & (y < high) & (x > x0) & (x < x1) & (z > z0) & (z < z1))
    off = np.minimum(np.minimum(x[near] - x0, x1 - x[near]), z1 - z[near])
    near = near[(off > _OFF) & (off < _RIM)]
    side, bins = max(2.0 * facade.spacing, _OFF), int((high - low) / _BIN) + 1
    raster = Raster((float(x0), float(z0)), side, (int((z1 - z0) / side) + 1, int((x1 - x0) / side) + 1))
    level = ((y[near] - low) / _BIN).astype(np.int64)
    held = np.bincount(distinct(raster.flat(x[near], z[near]) * bins + level) % bins, minlength=bins)
    cells = (2.0 * (z1 - z0) + x1 - x0) * (_RIM - _OFF) / side**2
    first = np.flatnonzero(held[:-1] + held[1:] > _FIRST * cells)
    if len(first) == 0 or low + (first[0] + 1) * _BIN < _LEAST:
        return None
    own = y[near][(level >= first[0]) & (level <= first[0] + 1)]
    spread = max(float(own.std()), facade.roughness) / np.sqrt(_FIRST * cells)
    return Estimate(float(np.median(own)), np.array([[spread**2 + facade.sigma_plane**2]]), float(len(own)))


def _niche(opening: Opening, back: Estimate[float]) -> Protrusion:
    sigma = float(np.sqrt(np.mean(np.diag(opening.ring_covariance))))
    return Protrusion(
        "", ProtrusionKind.NICHE, opening.ring, sigma, back, Provenance.MEASURED, opening.confidence
    )
