"""Finds the strips of bowed fronts: narrow walls, as high as the front, that meet at flat corners.

A strip is no wider than an opening and lies within the prism of the front. The same is true of the side of a
bay and of relief, but what stands before a front is lower than the front, and relief is parallel to it.
"""

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from frontage.facades.bends import SHARPEST, crossing, full_columns, places
from frontage.facades.candidate import FacadeCandidate
from frontage.facades.cells import CellMap
from frontage.facades.plane.curvature import wall_sagitta
from frontage.facades.remaining import are_claimed, on_walls
from frontage.facades.scene import FacadeScene
from frontage.facades.sequential import search_among
from frontage.geometry.arrays import Bool, Float, Int
from frontage.model.masonry import MASONRY, TOLERANCES

_HIGH = 0.8  # share of the height of the front that a strip shows
_MOST = 0.5  # share of its wall that a strip shows in its full columns; chords of a bow have no such columns
_LESS = 0.5  # share of the wall of a strip that a facade may show in the same place, near their corner
_PLAN = 2.0  # voxels, side of the cells of a plan: a wall that slants from the axes still fills such cells
_FIRST = 3  # rejected planes in a row that end a search without strips: blank strips are found before chords
_PATIENCE = 8  # rejected planes in a row that end a later search: chords hold more wall than the last strips
_NEAR = 2.0  # cells between a corner and both walls at most; tangents of a round wall cross farther off


def search_strips(
    facades: Sequence[FacadeCandidate], scene: FacadeScene, rng: np.random.Generator
) -> list[FacadeCandidate]:
    """Finds the strips that lead from a facade to the next one, or to its own plane again.

    They are looked for in the prisms of the facades, among the points that are not on the walls of facades. A
    wall claims the strips beside it, and the strip with the most wall is found first, wherever it stands. So
    the search is repeated until it finds nothing more, and the corners are checked afterwards. A front is not
    searched if nothing off its plane is as high as the front.
    """
    if not facades:
        return []
    thin, left = scene.cloud.thinned, list[FacadeCandidate]()
    near = are_claimed(thin, facades, scene.options)
    near[near] = _beside_piers(thin[near], facades, scene.cloud.cell)
    while near.any():
        known = [*facades, *left]
        own = near & ~on_walls(thin, known)
        patience = _PATIENCE if left else _FIRST
        more = search_among(thin, own, known, _may_be_strip, scene, rng, patience=patience, only_new=True)
        if not more:
            break
        left += more
    found: list[FacadeCandidate] = []
    while new := [strip for strip in left if is_strip_beside(strip, [*facades, *found])]:
        found += new
        left = [strip for strip in left if strip not in new]
    return found


def is_strip_beside(candidate: FacadeCandidate, facades: Sequence[FacadeCandidate]) -> bool:
    """Decides whether a wall is a strip that meets one of the facades at a flat corner."""
    columns = full_columns(candidate.cells)
    if not _is_strip(candidate, columns):
        return False
    return any(_meets(candidate, columns, facade) for facade in facades)


def _beside_piers(xyz: Float, facades: Sequence[FacadeCandidate], cell: float) -> Bool:
    """Returns which points (n, 3) m local lie near things that are as high as a facade and on no wall.

    Such things are the piers and the blank walls of strips, and few others: downpipes and buttresses.
    """
    free = np.flatnonzero(~on_walls(xyz, facades))
    step = np.array([_PLAN, _PLAN, 1.0]) * cell
    held = np.unique(np.floor(xyz[free] / step).astype(np.int64), axis=0)
    place, count = np.unique(held[:, :2], axis=0, return_counts=True)
    least = _HIGH * min(_height(facade.cells) for facade in facades)
    piers = (place[count * cell >= least] + 0.5) * step[:2]
    if len(piers) * _PLAN * cell < MASONRY.pier:
        return np.zeros(len(xyz), np.bool_)
    return np.asarray(cKDTree(piers).query(xyz[:, :2])[0] < MASONRY.room_width, np.bool_)


def _may_be_strip(candidate: FacadeCandidate, facades: Sequence[FacadeCandidate], scene: FacadeScene) -> bool:
    """Returns whether a wall is a strip as high as one of the facades that face nearly the same way.

    None of these facades may show much wall in the same place, for a strip is no layer of a wall.
    """
    columns = full_columns(candidate.cells)
    if not _is_strip(candidate, columns):
        return False
    beside = [f for f in facades if candidate.wall.normal @ f.wall.normal > SHARPEST]
    is_high = any(_height(candidate.cells) >= _HIGH * _height(f.cells) for f in beside)
    return is_high and not any(_is_layer(candidate, columns, facade) for facade in beside)


def _is_layer(candidate: FacadeCandidate, columns: Int, facade: FacadeCandidate) -> bool:
    """Returns whether a facade shows more than half the wall that a candidate shows in its `columns` (k,)."""
    ends = np.zeros((2, 3))
    ends[:, 0] = places(candidate.cells, columns[[0, -1]])
    first, last = np.sort(facade.wall.coordinates(candidate.wall.point + ends @ candidate.wall.axes.T)[:, 0])
    x = places(facade.cells, np.arange(facade.cells.whole.shape[1]))
    wall = facade.cells.wall[:, (x >= first) & (x <= last)].sum() * facade.cells.cell**2
    own = candidate.cells.wall[:, columns].sum() * candidate.cells.cell**2
    return bool(wall > _LESS * own)


def _is_strip(candidate: FacadeCandidate, columns: Int) -> bool:
    """Returns whether a wall is a flat strip: its full `columns` (k,) hold most of it.

    They are as wide as a pier at least and as an opening at most. Chords of a bow have no such columns, and
    the tangents of a round wall are not flat.
    """
    cells = candidate.cells
    fits = MASONRY.pier <= len(columns) * cells.cell <= MASONRY.largest_opening
    if not fits or cells.wall[:, columns].sum() < _MOST * cells.wall.sum():
        return False
    x, y = candidate.slab.q[:, :2].T
    first, last = places(cells, columns[[0, -1]])
    own = (x > first) & (x < last)
    sagitta, sigma = wall_sagitta(x[own], y[own], candidate.wall.threshold, MASONRY.relief)
    return abs(sagitta) <= max(TOLERANCES.bent_sigmas * sigma, candidate.wall.sigma)


def _meets(own: FacadeCandidate, columns: Int, other: FacadeCandidate) -> bool:
    """Returns whether a wall with its full `columns` (k,) ends in a flat corner with another one."""
    corner = crossing(own, other)
    if corner is None:
        return False
    x, there = corner
    at_end = np.abs(places(own.cells, columns[[0, -1]]) - x).min() < _NEAR * own.cells.cell
    beside = np.abs(places(other.cells, full_columns(other.cells)) - there).min(initial=np.inf)
    is_high = _height(own.cells) >= _HIGH * _height(other.cells)
    return bool(at_end and beside < _NEAR * other.cells.cell and is_high)


def _height(cells: CellMap) -> float:
    """Returns the height m of the rows that show wall."""
    return float(cells.wall.any(1).sum()) * cells.cell
