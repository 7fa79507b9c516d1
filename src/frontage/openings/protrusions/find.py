"""Finds what stands out of the wall of a facade: balconies, oriels, cornices, railings, awnings, bands."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.ring import rectangle
from frontage.model.estimate import Estimate, Provenance
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY, TOLERANCES
from frontage.model.opening import Opening, Protrusion, ProtrusionKind
from frontage.openings.boxes import Box
from frontage.openings.protrusions.beams import FacadeBeams, bend
from frontage.openings.protrusions.checks import is_attached
from frontage.openings.protrusions.galleries import shows_wall, with_galleries, with_pilasters
from frontage.openings.protrusions.kinds import FrontFeatures, kind_of_protrusion
from frontage.openings.protrusions.measure import MeasuredBox, measure_box
from frontage.openings.protrusions.merging import bridge_gaps, merge_pieces
from frontage.openings.protrusions.pieces import Piece, find_pieces, fit_slanted_line
from frontage.openings.protrusions.resolution import Resolution
from frontage.openings.protrusions.setbacks import find_setbacks
from frontage.openings.wall.evidence import BARS

_LEAST_M = 0.08  # before the wall, from which points may belong to a protrusion
_SLOPE_M = 1.5  # rise of the ground along a facade at most
_UNDER_M = 0.5  # beside a protrusion, where the lowest point tells the ground
_MOST_BEAMS = 300_000  # enough to tell shares
_KERB_HEIGHT_M, _KERB_OUT_M = 0.3, 0.6  # what is lower and further out is a kerb
_SMALL_M = 1.0  # railings are longer
_SOLID, _SOLID_LARGE = 0.5, 0.2  # share of the beams that a small and a large front stop at least
# Kinds that slices of trees could be taken for.
_LEAFY = (ProtrusionKind.BALCONY, ProtrusionKind.RAILING, ProtrusionKind.AWNING, ProtrusionKind.OTHER)
_NARROW_M = 0.2  # pipes and posts are narrower
_FULL = 0.6  # share of the beams of the fullest row of a front from which a row counts as full
_BESIDE_M, _FEWEST = 0.3, 30  # beside a front, where a slanting wall would go on; points that tell it
_COMMON_M = 0.3  # distance within which the points of a front err together


def find_protrusions(
    facade: Facade, beams: FacadeBeams, openings: Sequence[Opening] = (), ground: float | None = None
) -> tuple[Protrusion, ...]:
    """Finds the protrusions of a facade and its parts that are set back (paper B, section 3.2.3).

    They have no ids yet and are sorted from left to right, those at the same place from bottom to top.
    `beams` are the facade's (`FacadeBeams.of`); `openings` help to tell sills and slabs; `ground` is the
    height z m of the ground in the facade frame, None where it is unknown.
    """
    wall = _Wall.of(facade, beams)
    found: list[Protrusion] = []
    for piece in _pieces(wall):
        if not wall.stands_out(piece):
            continue
        foot = _foot(wall.few.q, piece.box, ground)
        if _is_kerb(piece, foot) or not _is_attached(wall, piece, foot):
            continue
        measured = measure_box(beams, wall.few, wall.before, piece, wall.resolution)
        if _is_small(measured.box, wall.resolution.near(piece.box)):
            continue
        features = FrontFeatures(measured.box, -piece.y, measured.hit, piece.inclined)
        kind = kind_of_protrusion(features, facade, foot, openings)
        if not wall.denies(piece, measured, kind) and _is_solid(piece, measured, kind):
            found.append(_protrusion(wall, wall.before, piece, measured, kind))
    for piece, measured in find_setbacks(facade, beams, wall.resolution):
        found.append(_protrusion(wall, beams.q.T, piece, measured, ProtrusionKind.SETBACK))
    return tuple(sorted(found, key=_from_left))


@dataclass(frozen=True, eq=False)
class _Wall:
    """A facade with what was measured before it.

    before      (n, 3) m, the points that may belong to protrusions
    few         a part of the facade's beams, enough to tell shares
    resolution  of the scan on the wall
    """

    facade: Facade
    before: Float
    few: FacadeBeams
    resolution: Resolution

    @classmethod
    def of(cls, facade: Facade, beams: FacadeBeams) -> "_Wall":
        """Selects the points before the wall and measures the resolution on it."""
        q, noise = beams.q.T, 3.0 * facade.roughness
        on_wall = q[np.abs(q[:, 1]) < noise][:, [0, 2]]
        resolution = Resolution.of(on_wall, facade.spacing, facade.roughness)
        before = q[(q[:, 1] < -max(noise, _LEAST_M)) & (q[:, 1] > -MASONRY.facade_reach)]
        return cls(facade, before, beams.thinned(_MOST_BEAMS), resolution)

    def stands_out(self, piece: Piece) -> bool:
        """Returns whether the front of a piece stands out more than relief and noise of the wall do."""
        least = max(MASONRY.step_out, TOLERANCES.front_sigmas * self.facade.roughness)
        return piece.y <= -least

    def denies(self, piece: Piece, measured: MeasuredBox, kind: ProtrusionKind) -> bool:
        """Returns whether the wall shows behind a front, or goes on beside it or a pilaster."""
        if kind.is_wall and shows_wall(self.few, piece.y, measured.box, self.resolution):
            return True
        return (kind.is_wall or kind is ProtrusionKind.PILASTER) and self.goes_on_beside(piece, measured)

    def goes_on_beside(self, piece: Piece, measured: MeasuredBox) -> bool:
        """Returns whether the surface of a front goes on to its left or right without a step.

        A wall that slants from the plane of the facade seems to stand out slice by slice.
        """
        front = self.before[piece.front_rows]
        if len(front) < _FEWEST:
            return False
        at, slope, _ = fit_slanted_line(front[:, 0], front[:, 1])
        (x0, z0, x1, z1), (x, y, z) = measured.box, self.few.q
        level = (z > z0) & (z < z1)
        for a, b in ((x0 - _BESIDE_M, x0), (x1, x1 + _BESIDE_M)):
            beside = level & (x > a) & (x < b)
            off = np.abs(y[beside] - at - slope * x[beside])
            if len(off) >= _FEWEST and float((off <= self.resolution.half).mean()) > 0.5:
                return True
        return False


def _pieces(wall: _Wall) -> list[Piece]:
    """Returns the pieces before the wall, with mouldings, tiers and parts of the same front joined.

    Galleries one above another are parted, and so are pilasters side by side.
    """
    whole = merge_pieces(find_pieces(wall.before, wall.resolution), wall.resolution)
    joined = merge_pieces(bridge_gaps(whole, wall.few, wall.resolution), wall.resolution)
    parted = with_pilasters(joined, wall.before, wall.few, wall.resolution)
    return with_galleries(parted, wall.before, wall.few, wall.resolution)


def _is_kerb(piece: Piece, foot: float) -> bool:
    """Returns whether a piece is as low and as far out as only kerbs are; `foot` z m of the ground."""
    return piece.box[3] < foot + _KERB_HEIGHT_M and -piece.y > _KERB_OUT_M


def _is_attached(wall: _Wall, piece: Piece, foot: float) -> bool:
    """Returns whether a piece belongs to the wall and does not just stand in front of it."""
    return is_attached(wall.before[piece.rows], piece.box, piece.y, foot)


def _is_small(box: Box, resolution: Resolution) -> bool:
    """Returns whether a box is narrow as pipes and posts are, or lower than rows of beams can tell."""
    return box[2] - box[0] < _NARROW_M or box[3] - box[1] < resolution.least[1] / 2


def _is_solid(piece: Piece, measured: MeasuredBox, kind: ProtrusionKind) -> bool:
    """Returns whether a piece stops enough beams, where a slice of a tree could be taken for its kind.

    A wall stops as many as its frames and bars do even where all of it is glass; two banners stop fewer.
    """
    if kind.is_wall:
        return measured.hit >= BARS
    x0, z0, x1, z1 = measured.box
    least = _SOLID_LARGE if max(x1 - x0, z1 - z0) >= _SMALL_M else _SOLID
    return piece.inclined or piece.curved or kind not in _LEAFY or measured.hit >= least


def number_protrusions(facade: str, found: Sequence[Protrusion]) -> tuple[Protrusion, ...]:
    """Names the protrusions "B07/F1/P1", ... from left to right (to a decimetre), then upwards."""
    return tuple(replace(p, id=f"{facade}/P{k}") for k, p in enumerate(sorted(found, key=_from_left), 1))


def _from_left(protrusion: Protrusion) -> tuple[float, float]:
    """Sorts by the left border, to a decimetre, and then by the lower border."""
    return round(float(protrusion.ring[:, 0].min()), 1), float(protrusion.ring[:, 1].min())


def _foot(q: Float, box: Box, ground: float | None) -> float:
    """Returns the height z m of the ground below a box, which is that of the lowest points there.

    Streets slope, but not so much that it would be far above `ground`. q (3, n) m in the facade frame.
    """
    low = q[2, (q[0] > box[0] - _UNDER_M) & (q[0] < box[2] + _UNDER_M) & (q[1] > -MASONRY.facade_reach)]
    lowest = float(np.quantile(low, 0.002)) if len(low) else box[1]
    return lowest if ground is None else min(max(lowest, ground), ground + _SLOPE_M)


def _front(facade: Facade, front: Float, piece: Piece, resolution: Resolution) -> Estimate[float]:
    """Estimates the depth y m of the front of points (k, 3) m, with the error of the wall's plane.

    Only the fullest rows count: of a railing the rails and the edge of the slab, for its bars stand further
    back.
    """
    front = front[np.abs(front[:, 1] - piece.y) <= 2.0 * resolution.half]
    row = ((front[:, 2] - front[:, 2].min(initial=0.0)) / resolution.cell).astype(np.int64)
    number = np.bincount(row) if len(row) else np.zeros(1)
    full = front[(number >= _FULL * number.max())[row], 1] if len(row) else front[:, 1]
    at = piece.y if piece.inclined or len(full) < 3 else float(full.mean())
    spread = float(full.std()) if len(full) > 2 else facade.roughness
    (x0, z0, x1, z1) = piece.box
    patches = min(max((x1 - x0) * (z1 - z0) / _COMMON_M**2, 1.0), max(len(full), 1))
    variance = max(spread, facade.roughness) ** 2 / patches + facade.sigma_plane**2
    return Estimate(at, np.array([[variance]]), float(max(len(full) - 1, 1)))


def _protrusion(
    wall: _Wall, points: Float, piece: Piece, measured: MeasuredBox, kind: ProtrusionKind
) -> Protrusion:
    """Makes the noun of a piece of points (n, 3) m."""
    facade = wall.facade
    front = _front(facade, points[piece.front_rows], piece, wall.resolution.near(piece.box))
    middle = np.array([(measured.box[0] + measured.box[2]) / 2])
    return Protrusion(
        id="",
        kind=kind,
        ring=rectangle(*measured.box),
        sigma=float(np.sqrt(np.mean(np.square(measured.sigma)))),
        front=replace(front, value=front.value + float(bend(facade, middle)[0])),
        provenance=Provenance.MEASURED,
        confidence=measured.bracketed,
    )
