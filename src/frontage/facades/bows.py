"""Strips of bowed fronts: narrow walls, as high as the front, that go on from one another round flat corners.

A strip is no wider than an opening and lies within the prism of the front, so that its size and its place
tell it neither from the side of a bay nor from relief. Its corners and its height do: what stands before a
front is lower, and its relief is parallel to it.
"""

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from frontage.facades.bends import crossing, full_columns, places
from frontage.facades.candidate import FacadeCandidate
from frontage.facades.cells import CellMap
from frontage.facades.plane.curvature import wall_sagitta
from frontage.facades.remaining import are_claimed, on_walls
from frontage.facades.scene import FacadeScene
from frontage.facades.sequential import search_among
from frontage.geometry.arrays import Bool, Float, Int
from frontage.model.masonry import MASONRY, TOLERANCES

_SHARPEST = np.cos(np.radians(40.0))  # between a strip and the front that it belongs to
_HIGH = 0.8  # share of the height of the front that a strip shows
_MOST = 0.5  # share of its wall that a strip shows in its run of full columns; chords of a bow have none
_LESS = 0.5  # share of the wall of a strip that a facade may show in its place: what is near the corners
_PLAN = 2.0  # voxels, side of the cells of a plan: walls that slant fill them from foot to top
_FIRST = 3  # rejected planes in a row before a front has no strips: blank ones hold more wall than chords
_PATIENCE = 8  # rejected planes in a row before there are no more: chords hold more wall than the last strips
_NEAR = 2.0  # cells from a corner, within which both walls reach; tangents of a round wall cross before it


def search_strips(
    facades: Sequence[FacadeCandidate], scene: FacadeScene, rng: np.random.Generator
) -> list[FacadeCandidate]:
    """Finds the strips that lead from a facade to the next one, or to its own plane again.

    They are looked for in the prisms of the facades, off their walls. A wall claims the strips beside it, and
    the strip with the most wall is found first, wherever it stands. So the search is repeated until it finds
    nothing more, and only then the corners are asked. Fronts are not searched where nothing stands off their
    planes that is as high as they are.
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
    while new := [strip for strip in left if goes_on(strip, [*facades, *found])]:
        found += new
        left = [strip for strip in left if not any(strip is other for other in new)]
    return found


def goes_on(candidate: FacadeCandidate, facades: Sequence[FacadeCandidate]) -> bool:
    """Decides whether a wall is a strip that goes on from one of the facades round a flat corner."""
    columns = full_columns(candidate.cells)
    if not _is_strip(candidate, columns):
        return False
    return any(_meets(candidate, columns, facade) for facade in facades)


def _beside_piers(xyz: Float, facades: Sequence[FacadeCandidate], cell: float) -> Bool:
    """Returns which points (n, 3) m local lie near something off all walls that is as high as a facade.

    That are piers and blank wall of strips, and little else: downpipes, and buttresses.
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

    Where it stands, none of these facades has as much wall itself: a strip is no layer of a wall.
    """
    columns = full_columns(candidate.cells)
    if not _is_strip(candidate, columns):
        return False
    beside = [f for f in facades if candidate.wall.normal @ f.wall.normal > _SHARPEST]
    is_high = any(_height(candidate.cells) >= _HIGH * _height(f.cells) for f in beside)
    return is_high and not any(_is_layer(candidate, columns, facade) for facade in beside)


def _is_layer(candidate: FacadeCandidate, columns: Int, facade: FacadeCandidate) -> bool:
    """Returns whether a facade shows half as much wall in the full `columns` (k,) of another wall as that."""
    ends = np.zeros((2, 3))
    ends[:, 0] = places(candidate.cells, columns[[0, -1]])
    first, last = np.sort(facade.wall.coordinates(candidate.wall.point + ends @ candidate.wall.axes.T)[:, 0])
    x = places(facade.cells, np.arange(facade.cells.wall.shape[1]))
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
    x = crossing(own, other)
    if x is None:
        return False
    there = other.wall.coordinates((own.wall.point + x * own.wall.axes[:, 0])[None])[0, 0]
    at_end = np.abs(places(own.cells, columns[[0, -1]]) - x).min() < _NEAR * own.cells.cell
    beside = np.abs(places(other.cells, full_columns(other.cells)) - there).min(initial=np.inf)
    is_high = _height(own.cells) >= _HIGH * _height(other.cells)
    return bool(at_end and beside < _NEAR * other.cells.cell and is_high)


def _height(cells: CellMap) -> float:
    """Returns the height m of the rows that show wall."""
    return float(cells.wall.any(1).sum()) * cells.cell
