"""Balconies, oriels, cornices, railings, awnings, bands: what stands out of a facade's wall."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.ring import rectangle
from frontage.model.estimate import Estimate, Provenance
from frontage.model.facade import Facade
from frontage.model.opening import Opening, Protrusion
from frontage.model.scan import Scan
from frontage.openings.protrusion_borders import Crossings, Outline, outline_of
from frontage.openings.protrusion_boxes import Box
from frontage.openings.protrusion_checks import is_attached
from frontage.openings.protrusion_grain import Grain
from frontage.openings.protrusion_kinds import Look, kind_of_protrusion
from frontage.openings.protrusion_pieces import Piece, find_pieces

_LEAST = 0.08  # m before the wall from which points may belong to a protrusion
_OUT = 0.1  # m that a front stands out at least
_SIGMAS = 5.0  # of the wall's noise that it does
_BENT = 5.0  # sigmas of its sagitta from which a wall is bent
_LOW = 2.0  # times its height that a tier or a step is wide
_REACH = 1.5  # m before the wall that belongs to it
_SLOPE = 1.5  # m that the ground rises along a facade at most
_UNDER = 0.5  # m beside a protrusion where the lowest point tells the ground
_MOST = 300_000  # beams that tell shares
_WIDE = 0.2  # m: pipes and posts are narrower
_LEVEL = 0.6  # share of the longer one's side that parts of one piece have in common
_PASSING = 0.1  # share of the beams that show a gap between them to be one
_FULL = 0.6  # of the beams that the fullest row of a front stopped
_COMMON = 0.3  # m within which the points of a front err together


def find_protrusions(
    facade: Facade, scan: Scan, openings: Sequence[Opening] = (), ground: float | None = None
) -> tuple[Protrusion, ...]:
    """Protrusions of a facade, from left to right, those at the same place from bottom to top.

    `openings` help to tell sills and slabs; `ground` z m of the ground (docs/openings.md).
    """
    crossings = _unbent(facade, Crossings.of(facade, scan))
    q, least = crossings.q.T, 3.0 * facade.roughness
    few = crossings.thinned(_MOST)
    grain = Grain.of(q[np.abs(q[:, 1]) < least][:, [0, 2]], facade.spacing, facade.roughness)
    before = q[(q[:, 1] < -max(least, _LEAST)) & (q[:, 1] > -_REACH)]
    found: list[Protrusion] = []
    pieces = _merged(find_pieces(before, grain), grain)
    for piece in _bridged(pieces, few, grain):
        if piece.y > -max(_OUT, _SIGMAS * facade.roughness):
            continue
        foot = _foot(few.q, piece.box, ground)
        if not is_attached(before[piece.rows], piece.box, piece.y, foot):
            continue
        outline = outline_of(crossings, before, piece, grain)
        wide, high = outline.box[2] - outline.box[0], outline.box[3] - outline.box[1]
        if wide >= _WIDE and high >= grain.near(piece.box).least[1] / 2:
            found.append(_protrusion(facade, before, piece, outline, grain, foot, openings))
    return numbered(facade.id, found)


def numbered(facade: str, found: Sequence[Protrusion]) -> tuple[Protrusion, ...]:
    """Named "B07/F1/P1", ... from left to right (to a decimetre), then from bottom to top."""
    order = sorted(found, key=lambda p: (round(float(p.ring[:, 0].min()), 1), float(p.ring[:, 1].min())))
    return tuple(replace(p, id=f"{facade}/P{k}") for k, p in enumerate(order, 1))


def _foot(q: Float, box: Box, ground: float | None) -> float:
    """Height z m of the ground below a box: of the lowest points there, for streets slope; not far above
    `ground`.
    """
    low = q[2, (q[0] > box[0] - _UNDER) & (q[0] < box[2] + _UNDER) & (q[1] > -_REACH)]
    lowest = float(np.quantile(low, 0.002)) if len(low) else box[1]
    return lowest if ground is None else min(max(lowest, ground), ground + _SLOPE)


def _unbent(facade: Facade, crossings: Crossings) -> Crossings:
    """The beams with the parabola of a bent wall taken off."""
    sagitta, sigma = facade.curvature
    if abs(sagitta) < max(_BENT * sigma, 3.0 * facade.roughness):
        return crossings
    x0, _, x1, _ = facade.extent
    u = (crossings.q[0] - (x0 + x1) / 2) / max((x1 - x0) / 2, 1e-9)
    flat = crossings.q.copy()
    flat[1] += sagitta * u * u
    return replace(crossings, q=flat)


def _merged(pieces: list[Piece], grain: Grain) -> list[Piece]:
    """Pieces without those within others, and with the tiers of one moulding (or flight of steps) as one."""
    out: list[Piece] = []
    todo = sorted(pieces, key=lambda p: -_area(p.box))
    while todo:
        piece = todo.pop(0)
        host = next((k for k, p in enumerate(out) if _part_of(piece, p, grain)), None)
        if host is None:
            out.append(piece)
        else:
            todo.insert(0, _joined(piece, out.pop(host), grain))
    return out


def _joined(piece: Piece, host: Piece, grain: Grain) -> Piece:
    """A piece and its host as one: the larger front, of tiers the foremost."""
    a, b = piece.box, host.box
    ahead = piece if piece.y < host.y and _tier(a, b, grain) else host
    box = (min(a[0], b[0]), min(a[1], b[1]), max(a[2], b[2]), max(a[3], b[3]))
    rows = np.concatenate([host.rows, piece.rows])
    return replace(ahead, rows=rows, box=box, inclined=host.inclined and piece.inclined)


def _bridged(pieces: list[Piece], crossings: Crossings, grain: Grain) -> list[Piece]:
    """Pieces with those joined that go on behind what hides them: level, as far out, and no beam passes
    between them.
    """
    out: list[Piece] = []
    for piece in sorted(pieces, key=lambda p: p.box[0]):
        host = next((k for k, p in enumerate(out) if _goes_on(p, piece, crossings, grain)), None)
        if host is None:
            out.append(piece)
        else:
            larger = max(piece, out[host], key=lambda p: len(p.front_rows))
            joined = _joined(piece, out[host], grain)
            out[host] = replace(joined, y=larger.y, front_rows=larger.front_rows)
    return out


def _goes_on(one: Piece, other: Piece, crossings: Crossings, grain: Grain) -> bool:
    """Whether two pieces beside or above each other are one that something hides in the middle."""
    if abs(one.y - other.y) > 2.0 * grain.half:
        return False
    y = max(one.y, other.y)
    for axis in (0, 1):
        a, b = sorted((one.box, other.box), key=lambda box: box[axis])
        across = 1 - axis
        low, high = max(a[across], b[across]), min(a[across + 2], b[across + 2])
        level = high - low > _LEVEL * max(a[across + 2] - a[across], b[across + 2] - b[across])
        start, end = a[axis + 2] + grain.spacing, b[axis] - grain.spacing
        if not level or end <= start:
            continue
        gap = (start, low, end, high) if axis == 0 else (low, start, high, end)
        _, between = crossings.at(y, gap, 0.0)
        _, seen = crossings.at(y, a, 0.0)
        due = len(seen) * (end - start) / (a[axis + 2] - a[axis])
        if (between > -_LEAST).sum() < _PASSING * due:
            return True
    return False


def _part_of(piece: Piece, host: Piece, grain: Grain) -> bool:
    """Whether a piece is a moulding on the host's front, or a tier of the same moulding."""
    a, b = piece.box, host.box
    wide, high = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    inside = wide > 0 and high > 0 and wide * high > 0.8 * _area(a)
    return (inside and piece.y > host.y - 2.0 * _OUT) or _tier(a, b, grain)


def _tier(a: Box, b: Box, grain: Grain) -> bool:
    """Whether two long boxes with the same ends lie on top of each other."""
    ends = max(abs(a[0] - b[0]), abs(a[2] - b[2])) < 2.0 * grain.gap
    apart = max(a[1], b[1]) - min(a[3], b[3])
    low = all(c[2] - c[0] > _LOW * (c[3] - c[1]) for c in (a, b))
    return ends and apart < grain.gap and low


def _area(box: Box) -> float:
    return (box[2] - box[0]) * (box[3] - box[1])


def _front(facade: Facade, front: Float, piece: Piece, grain: Grain) -> Estimate[float]:
    """y m of the front of points (k, 3), errors of the wall's plane included.

    Of a railing the rails and the edge of the slab count: the fullest rows. Its bars stand further back.
    """
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
    facade: Facade,
    before: Float,
    piece: Piece,
    outline: Outline,
    grain: Grain,
    ground: float,
    openings: Sequence[Opening],
) -> Protrusion:
    """The noun of a piece."""
    front = _front(facade, before[piece.front_rows], piece, grain.near(piece.box))
    look = Look(outline.box, -front.value, outline.hit, piece.inclined)
    return Protrusion(
        "",
        kind_of_protrusion(look, facade, ground, openings),
        rectangle(*outline.box),
        float(np.sqrt(np.mean(np.square(outline.sigma)))),
        front,
        Provenance.MEASURED,
        outline.bracketed,
    )
