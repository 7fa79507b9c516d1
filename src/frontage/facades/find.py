"""Find every main facade of a building (paper A, sections 2.1 and 2.2)."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.facades.arcades import with_open_arcades
from frontage.facades.bows import search_strips
from frontage.facades.build import as_seen, build_facade
from frontage.facades.candidate import FacadeCandidate, refine_candidate, sketch_candidate
from frontage.facades.cloud import prepare
from frontage.facades.corners import with_sides_of_corners
from frontage.facades.interiors import drop_interiors
from frontage.facades.layers import find_layers
from frontage.facades.options import FacadeOptions
from frontage.facades.parts import with_parts
from frontage.facades.pieces import without_overlaps
from frontage.facades.plane.connected import RELIEF_M
from frontage.facades.plane.paper import paper_plane
from frontage.facades.remaining import on_walls, search_remaining, without_doubles
from frontage.facades.scene import FacadeScene
from frontage.facades.sequential import is_large, least_area, search_candidates
from frontage.facades.sides import with_sides
from frontage.facades.standing import with_standing_parts
from frontage.geometry.arrays import Float
from frontage.model.building import Building
from frontage.model.canonical import canonical_axes, canonical_order, steady
from frontage.model.estimate import Failed
from frontage.model.facade import Facade
from frontage.model.scan import Scan

_FEWEST_POINTS = 100  # below, neither noise nor outline can be measured
_MOST_LAYERED = 100_000  # points that tell whether a larger wall lies before a plane
_LEVEL = 0.9  # |z| of a unit normal above which the paper's plane is a ground or a roof


def find_facades(
    scan: Scan, building: Building, options: FacadeOptions | None = None, seed: int = 0
) -> tuple[Facade | Failed, ...]:
    """Finds every main facade of `building`, the one with the most wall first ("B07/F1").

    scan  working cloud: the building and its surroundings, which only help to tell the street side
    seed  of the sampling; the same input and seed give the same facades

    The steps are those of paper A: the principal plane by RANSAC (section 2.1), one plane after another until
    no wall is left, then the local frame of each plane at the barycentre of its inliers (section 2.2).
    Interiors, walls that were seen through the openings of another facade, are dropped in between.

    Neither the order of the points nor the direction of north decides anything: all steps work in the
    canonical frame and order of the building's points.

    Never raises for the data: returns one `Failed` with code F101 (too few points) or F102 (no wall).
    """
    options = options or FacadeOptions()
    rng = np.random.default_rng(seed)
    if len(building.index) < _FEWEST_POINTS:
        return (_too_few_points(building, len(building.index)),)
    xyz = np.take(scan.xyz, building.index, axis=0)
    axes = canonical_axes(xyz)
    xyz = steady(xyz @ axes)
    order = canonical_order(xyz)
    cloud = prepare(np.take(xyz, order, axis=0), building.index[order], rng, scan.sigma_range)
    scene = FacadeScene(scan, axes, cloud, building.ground_z, options)
    if options.method == "paper":
        candidates = _paper_candidate(scene, rng)
    else:
        thinned = replace(scene, cloud=scene.cloud.bounded())
        candidates = search_candidates(thinned, rng)
        candidates = drop_interiors(with_sides_of_corners(candidates), thinned, rng)
        refined = _refined(candidates, (), thinned, scene, rng)
        refined = _with_remaining(candidates, refined, thinned, scene, rng)
        refined = drop_interiors(refined, scene, rng.spawn(1)[0])  # their extent is known better by now
        refined = with_sides(refined, thinned, scene, rng.spawn(1)[0])
        refined = with_standing_parts(refined, scene, rng.spawn(1)[0])
        candidates, arcades = with_open_arcades(refined, scene, rng)
        candidates = with_parts(without_overlaps(candidates, arcades), scene)
    if not candidates:
        return (_no_wall(building, options),)
    candidates.sort(key=lambda candidate: -candidate.cells.area)
    found = (build_facade(f"{building.id}/F{k}", c, scene, rng) for k, c in enumerate(candidates, 1))
    return tuple(as_seen(facade, axes) for facade in found)


def _too_few_points(building: Building, number: int) -> Failed:
    """Returns the failure F101."""
    return Failed(
        "F101",
        f"building {building.id} has {number} points; a facade needs {_FEWEST_POINTS}",
        "use a denser scan, or merge this building with its neighbour",
    )


def _no_wall(building: Building, options: FacadeOptions) -> Failed:
    """Returns the failure F102."""
    return Failed(
        "F102",
        f"building {building.id} has no upright plane of {options.min_area:g} m2 or more",
        "lower facades.min_area, or set facades.levelled = false if z is not the plumb line",
    )


def _refined(
    candidates: list[FacadeCandidate],
    known: Sequence[FacadeCandidate],
    thinned: FacadeScene,
    scene: FacadeScene,
    rng: np.random.Generator,
) -> list[FacadeCandidate]:
    """Refines the candidates found in the thinned cloud on all points; those still large enough remain.

    Points on the walls of known facades do not say which connected component of a plane is meant.
    """
    refined = []
    for candidate in candidates:
        votes = thinned.cloud.xyz[candidate.wall.inliers]
        votes = votes[~on_walls(votes, known)]
        found = _refined_on_wall(candidate, votes, scene, rng) if len(votes) else None
        if found is not None and is_large(found.cells, least_area(known, scene.options)):
            refined.append(found)
    return refined


def _with_remaining(
    sketches: list[FacadeCandidate],
    refined: list[FacadeCandidate],
    thinned: FacadeScene,
    scene: FacadeScene,
    rng: np.random.Generator,
) -> list[FacadeCandidate]:
    """Returns the refined walls together with those that remain beside them and on bends between them."""
    remaining = search_remaining(sketches, refined, thinned, rng)
    remaining += search_strips([*refined, *remaining], thinned, rng)
    remaining = drop_interiors(remaining, thinned, rng, refined)
    new = _refined(remaining, refined, thinned, scene, rng)
    return without_doubles([*refined, *new], scene) if new else refined


def _refined_on_wall(
    candidate: FacadeCandidate, votes: Float, scene: FacadeScene, rng: np.random.Generator
) -> FacadeCandidate | None:
    """Refines a candidate; if a larger wall lies just before its plane, that wall is refined instead.

    Bars and panes at several depths may hold more voxels than their wall, but not more area at one depth.
    votes (n, 3) m local say which connected component of the plane is meant.
    """
    found = refine_candidate(candidate, votes, scene, rng)
    if found is None:
        return None
    q, wall = found.slab.q[:: len(found.slab.q) // _MOST_LAYERED + 1], found.wall
    q = q[np.abs(q[:, 1]) < RELIEF_M]
    flat = found.cells.flat(q[:, 0], q[:, 2])
    inside = found.cells.whole.ravel()[flat]
    layers = find_layers(q[inside, 1], flat[inside], found.cells, wall.sigma, (-RELIEF_M, RELIEF_M))
    own = max((layer.area for layer in layers if layer.y == 0.0), default=0.0)
    ahead = [layer for layer in layers if layer.y < 0.0 and layer.area > own]
    if not ahead:
        return found
    y = max(ahead, key=lambda layer: layer.area).y
    wall = replace(wall, point=wall.point + y * wall.normal)
    return refine_candidate(replace(found, wall=wall), votes, scene, rng)


def _paper_candidate(scene: FacadeScene, rng: np.random.Generator) -> list[FacadeCandidate]:
    """Returns the paper's own main plane, with the frame, outline and covariance of the common path."""
    cloud, options = scene.cloud, scene.options
    found = paper_plane(cloud.xyz, options.paper_threshold, options.paper_iterations, rng)
    if found is None or abs(found[0][2]) > _LEVEL:
        return []
    normal, centre, inliers = found
    votes = cloud.xyz[inliers]
    sketch = sketch_candidate(
        normal, centre, sigma=options.paper_threshold / 3, votes=votes, scene=scene, rng=rng
    )
    candidate = None if sketch is None else refine_candidate(sketch, votes, scene, rng)
    if candidate is None:
        return []
    sign = 1.0 if normal @ candidate.wall.normal > 0 else -1.0
    wall = replace(
        candidate.wall,
        normal=sign * normal,
        point=centre,
        threshold=options.paper_threshold,
        inliers=np.flatnonzero(inliers),
    )
    shift = candidate.wall.axes.T @ (centre - candidate.wall.point)
    cells = candidate.cells.moved(float(shift[0]), float(shift[2]))
    return [FacadeCandidate(wall, cells, candidate.slab.moved(wall.axes, centre), candidate.side)]
