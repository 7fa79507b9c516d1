"""Photos with a place in the scan take the other photos of their rigs along."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Bool
from frontage.model import Photo
from frontage.orientation.network import TiePoints
from frontage.orientation.placed import Placed, Scene
from frontage.orientation.result import Unoriented
from frontage.orientation.rigs import apart, consistent_poses


def carried_by_rigs(
    scene: Scene, placed: Sequence[Placed], unoriented: Sequence[Unoriented]
) -> tuple[list[Placed], list[Unoriented]]:
    """Puts the photos of every exposure of a rig on one body, also those without a place of their own.

    Where places within an exposure contradict one another, that of the largest blocks is kept. A photo whose
    block puts it elsewhere loses its tie points, which lie at the wrong place.
    """
    known = {photo.id: (photo, float(len(p.photos))) for p in placed for photo in p.photos}
    number_of = {photo.id: k for k, photo in enumerate(scene.given)}
    found = consistent_poses(scene.rigs, known, {photo.id: photo for photo in scene.given})
    parts = [_moved(part, found) for part in placed]
    for name in sorted(found.keys() - known.keys(), key=number_of.__getitem__):
        parts.append(Placed(np.array([number_of[name]]), (found[name],), TiePoints.none()))
    return parts, [one for one in unoriented if one.photo not in found]


def _moved(part: Placed, found: dict[str, Photo]) -> Placed:
    """The photos at the poses that their rigs give them, without the tie points of other places."""
    photos = tuple(found.get(photo.id, photo) for photo in part.photos)
    pairs = zip(part.photos, photos, strict=True)
    stays: Bool = np.array([not apart(old.pose, new.pose) for old, new in pairs], bool)
    return replace(part, photos=photos, ties=part.ties.take(stays[part.ties.photo]))
