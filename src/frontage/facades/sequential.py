"""Search a building for wall planes one after another, each on the points that the others leave."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from frontage.facades.candidate import FacadeCandidate, sketch_candidate, some_inliers
from frontage.facades.cells import CellMap
from frontage.facades.cloud import BuildingCloud, columns
from frontage.facades.options import FacadeOptions
from frontage.facades.outline import BESIDE_M, contrast, parallel_share
from frontage.facades.plane.connected import RELIEF_M, PlaneCandidate, connected_plane
from frontage.facades.plane.search import search_plane, stack_rise
from frontage.facades.scene import FacadeScene
from frontage.geometry.arrays import Bool, Float
from frontage.model.masonry import TOLERANCES

_PATIENCE = 3  # rejected planes in a row before the search ends
_LEAST_SIZE_M = (1.0, 2.0)  # m, width and height of a facade: a pier, a low storey
_LEAST_CONTRAST = 2.0  # wall area over that of slabs beside it: a bush or a furnished room has 1
_LEAST_PARALLEL = 0.5  # share of the patches beside a plane at one depth each: a front in many planes
_PATCH = 3.0  # voxels, side of a patch: nine points of a wall
_LEAST_RISE = 3.0  # voxels on top of one another that may be a wall
_THINNED = 0.5  # share of the least area that must show: rasters of one point per voxel have empty cells
_END_M = 0.5  # m at the border of a facade in which the next one may stand


def search_candidates(scene: FacadeScene, rng: np.random.Generator) -> list[FacadeCandidate]:
    """Finds the plane with the most wall among the thinned points, takes its points away, and searches on.

    The search ends when no plane holds enough points for a facade, or after three rejected planes in a row.
    """
    thin = scene.cloud.thinned
    return search_among(thin, np.ones(len(thin), np.bool_), (), is_no_layer, scene, rng)


def search_among(
    thin: Float,
    own: Bool,
    known: Sequence[FacadeCandidate],
    is_new: Callable[[FacadeCandidate, Sequence[FacadeCandidate], FacadeScene], bool],
    scene: FacadeScene,
    rng: np.random.Generator,
    *,
    patience: int = _PATIENCE,
    only_new: bool = False,
) -> list[FacadeCandidate]:
    """Searches some of the thinned points (n, 3) m for walls, and returns those that are not known yet.

    own       (n,) the points that are searched; the others tell whether a wall stands out from them
    is_new    decides whether a wall that was found is a new one, given the facades that are known by then
    patience  rejected planes in a row before the search ends
    only_new  walls that are not new are rejected, and use up only the points on their planes
    """
    cloud, options = scene.cloud, scene.options
    rise = stack_rise(thin, cloud.cell)
    if options.levelled:  # ground and roofs do not rise
        rises = rise >= _LEAST_RISE
        thin, own, rise = thin[rises], own[rises], rise[rises]
    everything = thin
    thin, rise = thin[own], rise[own]
    accepted = list(known)
    rejected = 0
    while rejected < patience and len(accepted) < options.max_facades and len(thin) > 10:
        least = least_area(accepted, options)
        found = search_plane(thin, rise, cloud, options, rng)
        if found is None:
            break
        plane = connected_plane(*found, thin, cloud, levelled=options.levelled, rng=rng)
        if plane.available < least or not plane.own.any():
            break
        candidate = _large_candidate(plane, thin, least, scene, rng)
        is_wall = candidate is not None and stands_out(candidate, everything, cloud)
        used, new = plane.own, False
        if candidate is not None:
            new = is_wall and is_new(candidate, accepted, scene)
            if new or not only_new:
                used = used | _claimed(candidate, thin, is_wall, options)
            accepted += [candidate] if new else []
        rejected = 0 if new or (is_wall and not only_new) else rejected + 1
        thin, rise = thin[~used], rise[~used]
    return accepted[len(known) :]


def _large_candidate(
    plane: PlaneCandidate, thin: Float, least: float, scene: FacadeScene, rng: np.random.Generator
) -> FacadeCandidate | None:
    """Sketches a candidate on the plane; None when it has less than `least` m2 or is no wall."""
    if plane.area < _THINNED * least:
        return None
    candidate = sketch_candidate(
        plane.normal, plane.point, sigma=plane.sigma, votes=thin[plane.own], scene=scene, rng=rng
    )
    return candidate if candidate is not None and is_large(candidate.cells, least) else None


def least_area(known: Sequence[FacadeCandidate], options: FacadeOptions) -> float:
    """Returns the area, m2, that a wall needs beside known facades."""
    largest = max((facade.cells.area for facade in known), default=0.0)
    return max(options.min_area, options.min_share * largest)


def is_large(cells: CellMap, least: float, size: tuple[float, float] = _LEAST_SIZE_M) -> bool:
    """Decides whether a wall is large enough: `least` m2, and as wide and as high as `size` m.

    Without a `size`, it must be a pier wide and a storey high.

    How much of its outline shows wall does not matter: colonnades, entablatures and recessed walls of one
    front lie in many planes, none of which may fill a quarter of it.
    """
    width, height = cells.size
    return cells.area >= least and width >= size[0] and height >= size[1]


def stands_out(candidate: FacadeCandidate, thin: Float, cloud: BuildingCloud) -> bool:
    """Decides whether the plane stands out from what lies beside it, or all of that is parallel to it.

    thin (n, 3) m: all thinned points, also those of planes that were taken away. Without its neighbours, a
    slice of a bush would stand alone.
    """
    q = columns(thin - candidate.wall.point, candidate.wall.axes)
    q = q[np.abs(q[:, 1]) < BESIDE_M]
    clear = contrast(q[:, 0], q[:, 1], q[:, 2], candidate.cells, cloud.threshold) >= _LEAST_CONTRAST
    q = q[candidate.cells.within(q[:, 0], q[:, 2])]
    return clear or parallel_share(q, _PATCH * cloud.cell, cloud.threshold) >= _LEAST_PARALLEL


def _claimed(candidate: FacadeCandidate, thin: Float, is_wall: bool, options: FacadeOptions) -> Bool:
    """Returns which points (n, 3) a candidate uses up: its relief and, for a wall, its whole prism."""
    q = candidate.wall.coordinates(thin)
    used: Bool = (np.abs(q[:, 1]) < RELIEF_M) & candidate.cells.within(q[:, 0], q[:, 2])
    return used | in_prism(q, candidate, options, candidate.cells.shrunk(_END_M)) if is_wall else used


def in_prism(q: Float, facade: FacadeCandidate, options: FacadeOptions, where: Bool | None = None) -> Bool:
    """Returns which points (n, 3) m, facade coordinates, are balconies, recesses and bays of a facade.

    `where` (h, w) leaves out its ends where the next face, round the corner, may stand.
    """
    deep = (q[:, 1] > -options.depth_front) & (q[:, 1] < options.depth_back)
    return np.asarray(deep & facade.cells.within(q[:, 0], q[:, 2], where), np.bool_)


def is_no_layer(candidate: FacadeCandidate, facades: Sequence[FacadeCandidate], scene: FacadeScene) -> bool:
    """Decides whether the candidate is more than a parallel layer within the prisms of facades.

    Where a wall bends, the plane of the next part lies mostly in the prism of the part before, but it also
    holds enough wall for a facade beside it. Such a plane is no layer. What goes on above the prism does not
    count: the parapets of galleries and balconies hide the wall behind them, and that of the top storey most.
    """
    options = scene.options
    parallel = [f for f in facades if abs(candidate.wall.normal @ f.wall.normal) >= TOLERANCES.parallel_cos]
    some = some_inliers(candidate, scene.cloud)
    if not any(in_prism(f.wall.coordinates(some), f, options).mean() > 0.5 for f in parallel):
        return True
    own = scene.cloud.xyz[candidate.wall.inliers]
    inside = np.any([in_prism(f.wall.coordinates(own), _upwards(f), options) for f in parallel], axis=0)
    q = candidate.wall.coordinates(own[~inside])
    beyond = replace(candidate.cells, whole=candidate.cells.marked(q[:, 0], q[:, 2]))
    return is_large(replace(beyond, wall=beyond.whole & beyond.wall), least_area(facades, options))


def _upwards(facade: FacadeCandidate) -> FacadeCandidate:
    """Returns a facade of which the outline holds all cells above it."""
    cells = facade.cells
    return replace(facade, cells=replace(cells, whole=np.logical_or.accumulate(cells.whole, axis=0)))
