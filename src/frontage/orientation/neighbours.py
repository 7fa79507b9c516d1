"""Photos that share points with a placed photo, but are in no block with it.

Two photos with hardly any other between them are oriented relative to one another, but their scale is not
known, so that incremental mapping cannot join them to a block. The scan knows it: where the rays of the
placed photo meet the scan are the points that the other photo is resected from.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Photo, Provenance
from frontage.orientation.alone import best_place, elsewhere
from frontage.orientation.network import TiePoints
from frontage.orientation.placed import Placed, Scene, agrees_with_prior, merged
from frontage.orientation.resection import resect
from frontage.orientation.result import Unoriented
from frontage.orientation.ties.reasons import is_copy
from frontage.orientation.views import FEWEST, Seen, Views

_LEAST_SHARE = 0.3  # of the points of a resection that agree
_PLACED_M = 0.03  # how well a placed photo is known before the adjustment


def placed_by_neighbours(
    scene: Scene, placed: Sequence[Placed], unoriented: Sequence[Unoriented], views: Views | None = None
) -> tuple[list[Placed], list[Unoriented]]:
    """Resects photos without a place from what they share with placed ones, as long as there are any.

    views  of the placed photos, to which those that get a place are added; drawn here if None
    """
    parts, known = list(placed), Views(scene, placed) if views is None else views
    number_of = {photo.id: k for k, photo in enumerate(scene.given)}
    waiting = {number_of[one.photo] for one in unoriented if not is_copy(one.reason)}
    tried: dict[int, int] = {}
    while new := _resected(scene, known, waiting, tried):
        parts.append(new)
        known.add(new)
        waiting -= set(new.numbers.tolist())
    return parts, [one for one in unoriented if number_of[one.photo] in waiting or is_copy(one.reason)]


def placed_again(
    scene: Scene, placed: Placed, refused: Sequence[Unoriented], views: Views
) -> tuple[Placed, list[Unoriented]]:
    """Looks for refused photos once more, now that the poses of their neighbours are adjusted.

    views  of the placed photos, to which those that get a place are added

    Cameras of rigs are not looked for: the other cameras of their exposures have told where they are.
    """
    carried = {name for rig in scene.rigs for exposure in rig.exposures for name in exposure.photos}
    free = [one for one in refused if one.photo not in carried]
    parts, still = placed_by_neighbours(scene, [placed], free, views)
    return merged(parts), [one for one in refused if one.photo in carried or one in still]


def _resected(scene: Scene, known: Views, waiting: set[int], tried: dict[int, int]) -> Placed | None:
    """The first of the photos that can be resected, those with most points first.

    `tried` holds the number of neighbours with which a photo could not be resected: it waits for another one.
    """
    points = {number: seen for number in sorted(waiting) if (seen := known.points(number))}
    for number in sorted(points, key=lambda n: -sum(len(seen.pixels) for seen in points[n])):
        if tried.get(number) == len(points[number]):
            continue
        tried[number] = len(points[number])
        found = _placed(scene, scene.given[number], points[number])
        if found is not None:
            return Placed(np.array([number]), (found,), TiePoints.none())
    return None


def _placed(scene: Scene, photo: Photo, seen: Sequence[Seen]) -> Photo | None:
    """Returns the photo with its pose. Where its neighbours tell different places, control points decide.

    Neighbours that tell no place may have nothing but false matches, and have no say if others tell one.
    """
    told = [(pose, one) for one in seen if (pose := _pose(photo, one, scene.seed)) is not None]
    poses = [pose for pose, _ in told]
    if any(elsewhere(pose, poses[0]) for pose in poses):
        return best_place(photo, poses, scene.surface, scene.image_of, scene.seed)
    pose = _pose(photo, Seen.joined([one for _, one in told] or seen), scene.seed)
    if pose is None:
        return None
    return replace(photo, local_from_camera=Estimate(pose, np.zeros((6, 6)), 0.0, Provenance.MEASURED))


def _pose(photo: Photo, seen: Seen, seed: int) -> Rigid3 | None:
    """The pose that enough of the points agree with and that does not contradict the approximate one."""
    agree = _PLACED_M * float(photo.camera.params[0] / np.median(seen.away))
    found = resect(photo.camera, seen.pixels, seen.xyz, agree, seed=seed)
    enough = max(FEWEST, _LEAST_SHARE * len(seen.pixels))
    if found is None or found.inliers.sum() < enough or not agrees_with_prior(found.pose, photo):
        return None
    return found.pose
