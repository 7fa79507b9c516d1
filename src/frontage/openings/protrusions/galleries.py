"""Divides what thin parts join: galleries one above another by their posts, pilasters by sills and bands."""

from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model.masonry import MASONRY
from frontage.openings.boxes import Box
from frontage.openings.protrusions.beams import FacadeBeams
from frontage.openings.protrusions.boxes import extent, held_cells, within
from frontage.openings.protrusions.pieces import Piece
from frontage.openings.protrusions.resolution import Resolution

_MANY = 0.2  # share of the beams to a front that end on the wall behind it; fewer do behind an oriel
_FULL = 0.6  # share of the fullest row of a front from which a row counts as full: posts fill less
_RAILING_M = 1.3  # m from a slab to the top of its railing at most: building codes ask for 0.9 to 1.1


def with_galleries(
    pieces: list[Piece], before: Float, beams: FacadeBeams, resolution: Resolution
) -> list[Piece]:
    """Returns the pieces, with galleries divided into their storeys, which posts had joined.

    The front of such a piece is at least as high as a person, and the wall of the facade shows behind it. An
    oriel hides that wall. before (n, 3) m are the points that the rows of pieces index.
    """
    found: list[Piece] = []
    for piece in pieces:
        local = resolution.near(piece.box)
        is_high = piece.box[3] - piece.box[1] >= MASONRY.person
        is_open = is_high and shows_wall(beams, piece.y, piece.box, local)
        found += _storeys(piece, before, local) if is_open else [piece]
    return found


def with_pilasters(
    pieces: list[Piece], before: Float, beams: FacadeBeams, resolution: Resolution
) -> list[Piece]:
    """Returns the pieces, with relief as high as a person divided where more wall shows than front.

    Pilasters are joined by the sills and bands between them. An avant-corps hides the wall behind it.
    """
    found: list[Piece] = []
    for piece in pieces:
        is_relief = piece.y >= -MASONRY.relief and not piece.inclined
        is_high = piece.box[3] - piece.box[1] >= MASONRY.person
        found += _uprights(piece, before, beams, resolution) if is_relief and is_high else [piece]
    return found


def _uprights(piece: Piece, before: Float, beams: FacadeBeams, resolution: Resolution) -> list[Piece]:
    """Returns the parts of a piece, from left to right, between columns that show more wall than front.

    Columns that show neither, such as the flutes of a pilaster, do not divide it.
    """
    local = resolution.near(piece.box)
    where, depth = beams.at(piece.y, piece.box, 0.0)
    left, right = piece.box[0], piece.box[2]
    x = np.linspace(left, right, max(1, round((right - left) / local.cell)) + 1)  # alike from both ends
    front, wall = (np.histogram(where[np.abs(depth - y) <= local.half, 0], x)[0] for y in (piece.y, 0.0))
    if (wall <= front).all():
        return [piece]
    shown = np.flatnonzero(front > wall)
    parted = np.diff(np.cumsum(wall > front)[shown]) > 0
    runs = np.split(shown, np.flatnonzero(parted) + 1) if len(shown) else []
    parts = (_between(piece, before, float(x[run[0]]), float(x[run[-1] + 1]), local) for run in runs)
    return [part for part in parts if part is not None] or [piece]


def _between(piece: Piece, before: Float, left: float, right: float, resolution: Resolution) -> Piece | None:
    """Returns the part of a piece between two places x m; None if its front has no width or height there."""
    wide = (left, piece.box[1], right, piece.box[3])
    own, front = (rows[within(before[rows], wide, 0.0)] for rows in (piece.rows, piece.front_rows))
    if not len(front):
        return None
    x0, z0, x1, z1 = box = extent(before[front], resolution.cell, 0.0)
    if x0 == x1 or z0 == z1:
        return None
    return replace(piece, rows=own, front_rows=front, box=box, cheeks={})


def shows_wall(beams: FacadeBeams, y: float, box: Box, resolution: Resolution) -> bool:
    """Returns whether many beams to a front at y m, within a box, end on the wall behind it."""
    _, depth = beams.at(y, box, 0.0)
    reached = int((depth >= y - resolution.half).sum())
    return int((np.abs(depth) <= resolution.half).sum()) > _MANY * reached


def _storeys(piece: Piece, before: Float, resolution: Resolution) -> list[Piece]:
    """Returns the full rows of a piece as its parts; a slab and its railing are one part."""
    front = before[piece.front_rows]
    number = held_cells(front, resolution.cell)[1].sum(0)
    full = np.flatnonzero(number >= _FULL * number.max())
    ends = np.flatnonzero(np.diff(full) * resolution.cell > _RAILING_M)
    low = front[:, 2].min() + resolution.cell * full[np.append(0, ends + 1)]
    high = front[:, 2].min() + resolution.cell * (full[np.append(ends, len(full) - 1)] + 1)
    return [_part(piece, before, float(a), float(b), resolution) for a, b in zip(low, high, strict=True)]


def _part(piece: Piece, before: Float, low: float, high: float, resolution: Resolution) -> Piece:
    """Returns the part of a piece between two heights m, with what lies right below and above its front."""
    box = (piece.box[0], low, piece.box[2], high)
    own, front = (rows[within(before[rows], box, 0.0)] for rows in (piece.rows, piece.front_rows))
    behind = piece.rows[before[piece.rows, 1] > piece.y + resolution.half]
    soffit = behind[within(before[behind], box, resolution.cell)]
    return replace(piece, rows=np.union1d(own, soffit), front_rows=front, box=box, cheeks={})
