"""Balconies, oriels, cornices, railings, awnings, bands: what stands out of a facade's wall."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.ring import rectangle
from frontage.model.estimate import Estimate, Provenance
from frontage.model.facade import Facade
from frontage.model.opening import Opening, Protrusion, ProtrusionKind
from frontage.openings.protrusions.borders import AHEAD, Crossings, Outline, bend, outline_of
from frontage.openings.protrusions.boxes import Box
from frontage.openings.protrusions.checks import is_attached
from frontage.openings.protrusions.grain import Grain
from frontage.openings.protrusions.kinds import Look, kind_of_protrusion
from frontage.openings.protrusions.merging import bridged, merged
from frontage.openings.protrusions.pieces import Piece, find_pieces
from frontage.openings.protrusions.setbacks import find_setbacks

_LEAST = 0.08  # m before the wall from which points may belong to a protrusion
_OUT = 0.1  # m that a front stands out at least
_SIGMAS = 5.0  # of the wall's noise that it does
_SLOPE = 1.5  # m that the ground rises along a facade at most
_UNDER = 0.5  # m beside a protrusion where the lowest point tells the ground
_MOST = 300_000  # beams that tell shares
_KERB = (0.3, 0.6)  # m above the ground, m out: lower and further out there are only kerbs
_SMALL = 1.0  # m: smaller things are no railings
_SOLID = (0.5, 0.2)  # share of the beams that a small and a large front stops at least
# Kinds that slices of trees could be taken for.
_LEAFY = (ProtrusionKind.BALCONY, ProtrusionKind.RAILING, ProtrusionKind.AWNING, ProtrusionKind.OTHER)
_WIDE = 0.2  # m: pipes and posts are narrower
_FULL = 0.6  # of the beams that the fullest row of a front stopped
_COMMON = 0.3  # m within which the points of a front err together


def find_protrusions(
    facade: Facade, crossings: Crossings, openings: Sequence[Opening] = (), ground: float | None = None
) -> tuple[Protrusion, ...]:
    """Protrusions of a facade, from left to right, those at the same place from bottom to top.

    `crossings` are the facade's (`Crossings.of`); `openings` help to tell sills and slabs; `ground` z m of
    the ground (docs/openings.md).
    """
    q, least = crossings.q.T, 3.0 * facade.roughness
    few = crossings.thinned(_MOST)
    grain = Grain.of(q[np.abs(q[:, 1]) < least][:, [0, 2]], facade.spacing, facade.roughness)
    before = q[(q[:, 1] < -max(least, _LEAST)) & (q[:, 1] > -AHEAD)]
    found: list[Protrusion] = []
    pieces = bridged(merged(find_pieces(before, grain), grain), few, grain)
    for piece in merged(pieces, grain):
        if piece.y > -max(_OUT, _SIGMAS * facade.roughness):
            continue
        foot = _foot(few.q, piece.box, ground)
        kerb = piece.box[3] < foot + _KERB[0] and -piece.y > _KERB[1]
        if kerb or not is_attached(before[piece.rows], piece.box, piece.y, foot):
            continue
        outline = outline_of(crossings, few, before, piece, grain)
        wide, high = outline.box[2] - outline.box[0], outline.box[3] - outline.box[1]
        if wide < _WIDE or high < grain.near(piece.box).least[1] / 2:
            continue
        look = Look(outline.box, -piece.y, outline.hit, piece.inclined)
        kind = kind_of_protrusion(look, facade, foot, openings)
        if kind.is_wall and _shows_wall(few, outline.box, piece.y, grain):
            continue
        if (
            piece.inclined
            or piece.curved
            or kind not in _LEAFY
            or outline.hit >= _SOLID[max(wide, high) >= _SMALL]
        ):
            found.append(_protrusion(facade, before, piece, outline, kind, grain))
    for piece, outline in find_setbacks(facade, crossings, grain):
        found.append(_protrusion(facade, q, piece, outline, ProtrusionKind.SETBACK, grain))
    return numbered(facade.id, found)


def _shows_wall(crossings: Crossings, box: Box, y: float, grain: Grain) -> bool:
    """Whether more beams through a box before the wall end on the wall behind it than on its front at y m."""
    _, depth = crossings.at(y, box, 0.0)
    return int((np.abs(depth) <= grain.half).sum()) > int((np.abs(depth - y) <= grain.half).sum())


def numbered(facade: str, found: Sequence[Protrusion]) -> tuple[Protrusion, ...]:
    """Named "B07/F1/P1", ... from left to right (to a decimetre), then from bottom to top."""
    order = sorted(found, key=lambda p: (round(float(p.ring[:, 0].min()), 1), float(p.ring[:, 1].min())))
    return tuple(replace(p, id=f"{facade}/P{k}") for k, p in enumerate(order, 1))


def _foot(q: Float, box: Box, ground: float | None) -> float:
    """Height z m of the ground below a box: of the lowest points there, for streets slope; not far above
    `ground`.
    """
    low = q[2, (q[0] > box[0] - _UNDER) & (q[0] < box[2] + _UNDER) & (q[1] > -AHEAD)]
    lowest = float(np.quantile(low, 0.002)) if len(low) else box[1]
    return lowest if ground is None else min(max(lowest, ground), ground + _SLOPE)


def _front(facade: Facade, front: Float, piece: Piece, grain: Grain) -> Estimate[float]:
    """y m of the front of points (k, 3), errors of the wall's plane included.

    Of a railing the rails and the edge of the slab count: the fullest rows. Its bars stand further back.
    """
    front = front[np.abs(front[:, 1] - piece.y) <= 2.0 * grain.half]
    row = ((front[:, 2] - front[:, 2].min(initial=0.0)) / grain.cell).astype(np.int64)
    number = np.bincount(row) if len(row) else np.zeros(1)
    full = front[(number >= _FULL * number.max())[row], 1] if len(row) else front[:, 1]
    at = piece.y if piece.inclined or len(full) < 3 else float(full.mean())
    spread = float(full.std()) if len(full) > 2 else facade.roughness
    (x0, z0, x1, z1) = piece.box
    patches = min(max((x1 - x0) * (z1 - z0) / _COMMON**2, 1.0), max(len(full), 1))
    variance = max(spread, facade.roughness) ** 2 / patches + facade.sigma_plane**2
    return Estimate(at, np.array([[variance]]), float(max(len(full) - 1, 1)))


def _protrusion(
    facade: Facade, points: Float, piece: Piece, outline: Outline, kind: ProtrusionKind, grain: Grain
) -> Protrusion:
    """The noun of a piece of points (n, 3)."""
    front = _front(facade, points[piece.front_rows], piece, grain.near(piece.box))
    middle = np.array([(outline.box[0] + outline.box[2]) / 2])
    return Protrusion(
        "",
        kind,
        rectangle(*outline.box),
        float(np.sqrt(np.mean(np.square(outline.sigma)))),
        replace(front, value=front.value + float(bend(facade, middle)[0])),
        Provenance.MEASURED,
        outline.bracketed,
    )
