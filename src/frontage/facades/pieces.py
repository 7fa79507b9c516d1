"""Gives every area of a front to one of its planes: outlines end where the next wall begins."""

from collections.abc import Set
from dataclasses import replace
from itertools import combinations

import numpy as np
from scipy import ndimage

from frontage.facades.bends import LEAST_M2, ended_at_corners, share_a_corner, shared_cells
from frontage.facades.candidate import FacadeCandidate
from frontage.facades.cells import CellMap
from frontage.geometry.arrays import Bool, Float, distinct
from frontage.model.masonry import MASONRY, TOLERANCES

_AROUND_M = 0.8  # m, one sigma of the surroundings whose wall tells the owner of a place: half a window
_BESIDE = 0.16  # share of wall around a place one sigma away from a straight edge of it
_WRONG = 0.05  # share of the lesser wall that may lie on the wrong side of an upright seam
_SLACK = 0.5  # columns of wall by which such seams differ that are as good
_LEFT_M2 = MASONRY.pier * MASONRY.room_height  # of wall that a piece keeps: a narrow pier, a storey high
_WITHIN = 0.8  # share of a plinth that lies in the outline of its wall
_WHOLE = 0.95  # share of its remaining wall that a piece keeps in one part; less, and it is divided


def without_overlaps(
    candidates: list[FacadeCandidate], arcades: Set[tuple[int, int]] = frozenset()
) -> list[FacadeCandidate]:
    """Returns the walls with outlines that do not overlap where parallel walls stand side by side.

    The outline of a wall continues over the next one where the front steps, because both are upright and
    near its plane. An upright seam parts walls that meet at a bend. Elsewhere a place belongs to the plane
    that has more wall around it. What is far from both, such as the middle of a colonnade, goes as a whole
    to the plane with more wall along its border. A wall that another divides in two keeps its outline,
    because that other one is a step within it. The front and the wall of an arcade, given by their numbers,
    stand one behind the other, and the wall goes on behind the piers.
    """
    parts = [ended_at_corners(candidate, candidates) for candidate in candidates]
    pieces: list[FacadeCandidate | None] = [first for first, *_ in parts]
    pieces += [part for _, *rest in parts for part in rest]
    for i, k in combinations(range(len(pieces)), 2):
        a, b = pieces[i], pieces[k]
        if a and b and not {(i, k), (k, i)} & arcades and _are_beside(a, b) and not share_a_corner(a, b):
            pieces[i], pieces[k] = _divided(a, b)
    return [piece for piece in pieces if piece]


def _are_beside(a: FacadeCandidate, b: FacadeCandidate) -> bool:
    """Returns whether two walls face the same way and their planes are near each other."""
    offset = float((b.wall.point - a.wall.point) @ a.wall.normal)
    parallel = float(a.wall.normal @ b.wall.normal) > TOLERANCES.parallel_cos
    return parallel and abs(offset) < MASONRY.facade_reach


def _divided(a: FacadeCandidate, b: FacadeCandidate) -> tuple[FacadeCandidate, FacadeCandidate | None]:
    """Divides the area that two outlines share between them, where each stays in one part.

    The second one is a layer of the first one, and no wall of its own (None), if hardly any of it is left, or
    if it falls apart and hardly any of its wall lies beyond the outline of the first one, or if what is left
    of it is a plinth or a frieze of that wall.

    What the first one loses because it is no longer connected with it, as a portal in the middle of the
    second one, goes back to the second one.
    """
    shared, there = shared_cells(b, a)
    lost = _beyond_seam(b, shared, shared & a.cells.wall.ravel()[there])
    if lost is None:
        lost = shared & _is_first(_share(a.cells).ravel()[there], _share(b.cells), shared)
    second = _kept(b.cells, lost, shared)
    if second is None:
        return a, b if (b.cells.wall & ~shared).sum() >= _cells_of_least(b.cells) else None
    if second.area < _LEFT_M2 or _is_relief(second, shared, a, b):
        return a, None
    own = replace(b, cells=second)
    first = _kept(a.cells, shared_cells(a, own)[0])
    if first is None:
        return a, own
    a = replace(a, cells=first)
    rest = _kept(b.cells, shared_cells(b, a)[0])
    return a, own if rest is None else replace(b, cells=rest)


def _is_relief(left: CellMap, shared: Bool, a: FacadeCandidate, b: FacadeCandidate) -> bool:
    """Returns whether what is left of the second wall is relief of the first one, as a plinth is.

    It lies near its plane and in its outline, of which `shared` (h, w) are cells, and is lower than a storey.
    """
    heights = left.cell * left.whole.sum(0)[left.whole.any(0)]
    near = abs(float((b.wall.point - a.wall.point) @ a.wall.normal)) < MASONRY.relief
    inside = (left.whole & shared).sum() > _WITHIN * left.whole.sum()
    return bool(near and inside and np.median(heights) < MASONRY.room_height)


def _share(cells: CellMap) -> Float:
    """Returns the share (h, w) of wall around every cell."""
    wide = _AROUND_M / cells.cell
    return np.asarray(ndimage.gaussian_filter(cells.wall.astype(np.float64), wide, mode="constant"))


def _beyond_seam(own: FacadeCandidate, shared: Bool, other: Bool) -> Bool | None:
    """Returns the shared cells (h, w) beyond an upright seam; None where no seam parts two walls.

    On each side of a seam hardly any wall lies on the plane of the other side. Where a front bends, a part of
    it lies on neither plane: there the seam runs through a pier, so that it cuts no opening.

    shared  (h, w) cells of both outlines; `other` (h, w) those of them with wall on the other's plane
    """
    columns = np.flatnonzero(shared.any(0))
    if not len(columns):
        return None
    part = slice(columns[0], columns[-1] + 1)
    ours, theirs = (np.cumsum(np.r_[0, m[:, part].sum(0)]) for m in (own.cells.wall & shared, other))
    # wall that lies on the wrong side of a seam before each column, with the other wall to its left or right
    wrong = np.stack([ours + theirs[-1] - theirs, theirs + ours[-1] - ours])
    side = int(wrong.min(1).argmin())
    least = wrong[side].min()
    if least > _WRONG * min(ours[-1], theirs[-1]):
        return None
    can_be = np.flatnonzero(wrong[side] - least <= _SLACK * shared.any(1).sum())
    seam = columns[0] + can_be[_upright_share(own)[columns[0] + can_be].argmax()]
    is_left = np.arange(shared.shape[1]) < seam
    return np.asarray(shared & (is_left if side == 0 else ~is_left), np.bool_)


def _upright_share(own: FacadeCandidate) -> Float:
    """Returns how much of the height (w,) of every column and its surroundings is wall at one depth."""
    cells, q = own.cells, own.slab.q
    flat = cells.flat(q[:, 0], q[:, 2])
    near = np.flatnonzero((np.abs(q[:, 1]) < MASONRY.facade_reach) & cells.whole.ravel()[flat])
    layer = np.floor((q[near, 1] + MASONRY.facade_reach) / MASONRY.panel).astype(np.int64)
    number, width = layer.max(initial=0) + 1, cells.whole.shape[1]
    shown = distinct(flat[near] * number + layer)
    held = np.bincount(shown // number % width * number + shown % number, minlength=width * number)
    share = held.reshape(width, number).max(1) / np.maximum(cells.whole.sum(0), 1)
    return np.asarray(ndimage.gaussian_filter1d(share, MASONRY.half_brick / cells.cell))


def _is_first(first: Float, second: Float, shared: Bool) -> Bool:
    """Returns which cells (h, w) belong to the first of two walls, from the shares of wall around them."""
    labels, number = ndimage.label(shared & (np.maximum(first, second) < _BESIDE))
    along = (np.bincount(labels.ravel(), share.ravel(), number + 1) for share in (first, second))
    border = np.greater_equal(*along)[labels]
    return np.where(labels > 0, border, first >= second)


def _cells_of_least(cells: CellMap) -> float:
    """Returns how many cells the least facade has."""
    return LEAST_M2 / cells.cell**2


def _kept(cells: CellMap, lost: Bool, shared: Bool | None = None) -> CellMap | None:
    """Returns the map without the cells (h, w) that are lost; None where that would divide it.

    Parts within the `shared` cells (h, w) that are too small for a facade divide nothing, such as panes in
    the windows of the other wall.
    """
    left = cells.whole & ~lost
    labels, number = ndimage.label(left)
    wall = np.bincount(labels[cells.wall & left], minlength=number + 1)
    wall[0] = 0
    if shared is not None:
        beside = np.bincount(labels[left & ~shared], minlength=number + 1)
        wall[(beside == 0) & (wall < _cells_of_least(cells))] = 0
    if number == 0 or wall.max() < _WHOLE * max(wall.sum(), 1):
        return None
    whole = ndimage.binary_fill_holes(labels == int(np.argmax(wall)))
    return cells.with_outline(whole)
