"""Find the sides of bays, oriels and wings: narrow walls between a front and a part of it that stands out.

The search for walls misses them: they are narrower than the walls that it looks for, and it counts everything
near the plane of a front as part of that front. In plan they are short lines that slant from the front.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import product

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from frontage.facades.bayfaces import faces_before, is_flat, is_seen_through
from frontage.facades.candidate import FacadeCandidate, refine_candidate, sketch_candidate, some_inliers
from frontage.facades.remaining import on_walls
from frontage.facades.scene import FacadeScene
from frontage.facades.sequential import in_prism, stands_out
from frontage.geometry.arrays import Bool, Float, Int
from frontage.geometry.plane import fit_upright_plane, plane_offsets
from frontage.model.masonry import MASONRY, TOLERANCES

_AROUND_CELLS = (3.5, 2.5)  # radii, in voxels, of the surroundings that tell the direction of a wall in plan
_LINE = 0.15  # variance across over variance along, at most, of the plan of a wall
_LEAST_AREA_M2 = MASONRY.pier * MASONRY.room_height  # of seen wall
_LEAST = (_LEAST_AREA_M2, (MASONRY.pier, MASONRY.door_height))  # area, width and height of a side
_LEAST_SEEN = 0.25  # share of that area that a line shows at least: near corners and panes none is straight
_FEWEST = 10  # points of a line, at least
_GAP = 3  # rows: a side may have fewer rows without wall in a row (an odd number)
_COLUMN = 0.1  # share of the wall in its fullest column that a column of a side shows at least
_ROUNDS = 5  # rounds of the fit of a line
_MOST = 0.5  # a wall of which a larger share lies on known walls is not new
_END = 0.1  # share of a wall's points at either end that do not tell how deep it reaches


def with_sides(
    facades: Sequence[FacadeCandidate], thinned: FacadeScene, scene: FacadeScene, rng: np.random.Generator
) -> list[FacadeCandidate]:
    """Returns the facades together with the sides of what stands out from them, the largest sides first.

    Sides are sketched on the thinned points and refined on all of them. No more are added than the options
    allow facades. Without sensor positions no sides are looked for, because too much of what stands before a
    front would be taken for a side.
    """
    found = list[FacadeCandidate]()
    fronts = [facade for facade in facades if facade.side.told_by == "rays"]
    faces = cache(partial(faces_before, scene=thinned))
    for front, votes in _slanting_lines(fronts, facades, thinned):
        side = _sketch(votes, thinned, rng)
        if side is None or not _is_side(side, front, [*facades, *found], thinned):
            continue
        side = refine_candidate(side, votes, scene, rng)
        if side is None:
            continue
        side = _cut_to_its_wall(side, front)
        if is_flat(side, scene, *_LEAST) and not is_seen_through(side, [*faces(front), *found], scene, rng):
            found.append(side)
    found.sort(key=lambda side: -side.cells.area)
    return [*facades, *found][: max(scene.options.max_facades, len(facades))]


def _slanting_lines(
    fronts: Sequence[FacadeCandidate], facades: Sequence[FacadeCandidate], scene: FacadeScene
) -> Iterator[tuple[FacadeCandidate, Float]]:
    """Yields each front with the points (n, 3) m local of every line in plan that slants from it.

    Points on the walls of facades belong to no line. The lines with the most points come first, so that left
    and right decide nothing.
    """
    xyz, cell = scene.cloud.thinned, scene.cloud.cell
    free = ~on_walls(xyz, facades)
    before = []
    for front in fronts:
        q = front.wall.coordinates(xyz)
        near = free & in_prism(q, front, scene.options) & (q[:, 1] < TOLERANCES.least_on_wall)
        before.append((front, np.flatnonzero(near), q[near, :2]))
    least = max(_LEAST_SEEN * _LEAST_AREA_M2 / cell**2, _FEWEST)
    for around, (front, own, xy) in product(_AROUND_CELLS, before):
        if len(own) * cell**2 < _LEAST_AREA_M2:
            continue
        line = _lines(xy, cell, around)
        held = np.bincount(line[line >= 0])
        for number in np.argsort(-held, kind="stable"):
            if held[number] >= least:
                yield front, xyz[own[line == number]]


def _lines(xy: Float, cell: float, around: float) -> Int:
    """Returns the number (n,) of the slanting line that each point (n, 2) m in plan belongs to, -1 for none.

    The first axis lies along the facade. Places of a line are neighbours, and turn by no more than walls that
    count as parallel.
    """
    place, count, at = _places(xy, 0.5 * cell)
    near = cKDTree(at).query_pairs(around * cell, output_type="ndarray")
    towards, straight = _directions(at, count, near)
    slants = straight & (np.abs(towards[:, 0]) < TOLERANCES.parallel_cos)
    close = np.linalg.norm(at[near[:, 0]] - at[near[:, 1]], axis=1) <= 2.0 * cell
    alike = np.abs((towards[near[:, 0]] * towards[near[:, 1]]).sum(1)) > TOLERANCES.parallel_cos
    joined = near[close & alike & slants[near].all(1)]
    graph = coo_array((np.ones(len(joined)), tuple(joined.T)), (len(at), len(at)))
    _, label = connected_components(graph, directed=False)
    numbers = np.full(len(at), -1)
    numbers[slants] = np.unique(label[slants], return_inverse=True)[1]
    return numbers[place]


def _places(xy: Float, cell: float) -> tuple[Int, Float, Float]:
    """Returns the place (n,) of each point (n, 2) m, and how many (k,) and where (k, 2) m they are."""
    key = np.floor(xy / cell).astype(np.int64)
    _, place, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    place = place.ravel()
    mean = np.column_stack([np.bincount(place, xy[:, k]) for k in range(2)]) / count[:, None]
    return place, count.astype(np.float64), mean


def _directions(at: Float, count: Float, near: Int) -> tuple[Float, Bool]:
    """Returns the unit direction (k, 2) of the plan around every place, and whether it is straight there.

    at (k, 2) m, places that `count` (k,) points lie on; near (m, 2), pairs of places.
    """
    size = len(at)
    a, b = np.concatenate([near, near[:, ::-1], np.column_stack([np.arange(size)] * 2)]).T
    weight, apart = count[b], at[b] - at[a]

    def mean(values: Float) -> Float:
        return np.bincount(a, weight * values, size) / np.bincount(a, weight, size)

    x, y = mean(apart[:, 0]), mean(apart[:, 1])
    xx, yy, xy = (mean(apart[:, i] * apart[:, k]) for i, k in ((0, 0), (1, 1), (0, 1)))
    spread = np.stack([xx - x * x, xy - x * y, xy - x * y, yy - y * y], axis=1).reshape(-1, 2, 2)
    variance, axes = np.linalg.eigh(spread)
    return axes[:, :, 1], variance[:, 0] < _LINE * variance[:, 1]


def _sketch(votes: Float, scene: FacadeScene, rng: np.random.Generator) -> FacadeCandidate | None:
    """Sketches the upright wall that most of the points (n, 3) m lie on. The others are panes and reveals."""
    own = votes
    for _ in range(_ROUNDS):
        normal, centre = fit_upright_plane(own)
        off = np.abs(plane_offsets(votes, normal, centre))
        own = votes[off <= max(scene.cloud.threshold, float(np.median(off)))]
    sigma = scene.cloud.threshold / 3.0
    return sketch_candidate(normal, centre, sigma=sigma, votes=votes, scene=scene, rng=rng)


def _cut_to_its_wall(side: FacadeCandidate, front: FacadeCandidate) -> FacadeCandidate:
    """Cuts the outline of a side to its own wall.

    The columns reach from the plane of the front to the last column that shows wall: beyond them stands the
    next wall round the corner. Of the rows that show wall, the highest run without gaps is kept, because the
    sides of balconies stand one above another. The wall of the front closes no gap between them.
    """
    cells, depth = side.cells, _depths(side, front)
    full = cells.wall.sum(0)
    before = (depth < 0.5 * cells.cell) & (depth > -MASONRY.facade_reach)
    outermost = depth[before & (full >= _COLUMN * full[before].max(initial=1))].min(initial=0.0)
    columns = before & (depth >= outermost)
    rows = np.asarray(cells.wall[:, columns & (depth < -cells.cell)].any(1), np.bool_)
    runs, number = ndimage.label(ndimage.binary_closing(rows, np.ones(_GAP, np.bool_)))
    highest = np.bincount(runs, minlength=number + 1)[1:].argmax() + 1 if number else 1
    own = (runs == highest)[:, None] & columns
    whole, wall, shut = (own & mask for mask in (cells.whole, cells.wall, cells.shut))
    return replace(side, cells=replace(cells, whole=whole, wall=wall, shut=shut))


def _depths(side: FacadeCandidate, front: FacadeCandidate) -> Float:
    """Returns how far (w,) m behind the plane of a front each column of a side lies."""
    x = side.cells.corner[0] + (np.arange(side.cells.whole.shape[1]) + 0.5) * side.cells.cell
    return front.wall.coordinates(side.wall.point + x[:, None] * side.wall.axes[:, 0])[:, 1]


def _is_side(
    side: FacadeCandidate, front: FacadeCandidate, known: Sequence[FacadeCandidate], scene: FacadeScene
) -> bool:
    """Decides whether a wall that is not known leads from a front to what stands out by more than relief."""
    if abs(side.wall.normal @ front.wall.normal) > TOLERANCES.parallel_cos:
        return False
    own = some_inliers(side, scene.cloud)
    depth = np.quantile(front.wall.coordinates(own)[:, 1], (_END, 1.0 - _END))
    if np.ptp(depth) < (1.0 - 2.0 * _END) * MASONRY.relief or on_walls(own, known).mean() > _MOST:
        return False
    return stands_out(side, scene.cloud.thinned, scene.cloud)
