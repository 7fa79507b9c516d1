"""What photos are oriented in, and photos with approximate poses in it."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.geometry.rigid import Rigid3, rotation_angle
from frontage.model import Estimate, Photo, Rig
from frontage.orientation.network import TiePoints
from frontage.orientation.nouns import CommonPoints
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import ImageOf

Tell = Callable[[str], None]

PRIOR_SIGMAS = 4.0
"""A pose that is farther than this from the approximate one contradicts it."""


def prior_of(photo: Photo) -> Estimate[Rigid3] | None:
    """Returns the approximate pose as an observation; None if its standard errors are not stated."""
    pose = photo.local_from_camera
    return None if pose is None or not (pose.sigma > 0).all() else pose


def agrees_with_prior(pose: Rigid3, given: Photo, common: Float | None = None) -> bool:
    """Returns whether a pose agrees with the approximate one. If that has no standard errors, it does.

    common  (3,) m, the error that all approximate positions share, for example that of the receiver
    """
    prior = prior_of(given)
    if prior is None:
        return True
    off = pose.t - prior.value.t - (0.0 if common is None else common)
    turn, sigma = rotation_angle(pose.R @ prior.value.R.T), PRIOR_SIGMAS * prior.sigma
    return bool((np.abs(off) <= sigma[:3]).all() and turn <= sigma[3:].max())


@dataclass(frozen=True, eq=False)
class Scene:
    """What photos are oriented in, and who is told of the progress.

    given          all photos, with what is known of their poses
    surface        of the scan; `image_of` returns the picture of a photo id
    camera_sigmas  per given photo, standard errors of its camera's parameters; empty: all are exact
    rigs           that took some of the photos
    common         what pairs of photos both show
    """

    given: Sequence[Photo]
    surface: ScannedSurface
    image_of: ImageOf
    camera_sigmas: Sequence[Float]
    seed: int
    tell: Tell
    rigs: Sequence[Rig] = ()
    common: Sequence[CommonPoints] = ()


@dataclass(frozen=True, eq=False)
class Placed:
    """Photos with approximate poses in the scan: their numbers among those given, and their tie points."""

    numbers: Int
    photos: tuple[Photo, ...]
    ties: TiePoints

    def only(self, keep: Int) -> "Placed":
        """The photos at `keep` (k,), with the tie points that they see."""
        photos = tuple(self.photos[k] for k in keep)
        return Placed(self.numbers[keep], photos, of_photos(self.ties, keep))


def contrary(placed: Placed, given: Sequence[Photo]) -> list[bool]:
    """Returns which of the placed photos contradict their approximate poses.

    `given` are all photos. The median error of three or more approximate positions is taken for an error that
    all of them share, and contradicts nothing.
    """
    pairs = [(p.pose, given[n]) for n, p in zip(placed.numbers, placed.photos, strict=True)]
    off = [pose.t - g.pose.t for pose, g in pairs if g.local_from_camera is not None]
    common = np.median(off, axis=0) if len(off) > 2 else None
    return [not agrees_with_prior(pose, g, common) for pose, g in pairs]


def of_photos(ties: TiePoints, keep: Int) -> TiePoints:
    """The tie points of some photos, which are numbered anew."""
    place = np.full(max(int(ties.photo.max(initial=-1)), int(keep.max(initial=-1))) + 1, -1)
    place[keep] = np.arange(len(keep))
    rows = place[ties.photo] >= 0
    kept = ties.take(rows)
    return replace(kept, photo=place[kept.photo])


def merged(placed: Sequence[Placed]) -> Placed:
    """All placed photos in their given order, with all tie points."""
    numbers = np.concatenate([np.empty(0, np.int64), *(p.numbers for p in placed)])
    photos = [photo for p in placed for photo in p.photos]
    order = np.argsort(numbers, kind="stable")
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    parts = list(_numbered(placed, place))
    return Placed(numbers[order], tuple(photos[k] for k in order), TiePoints.joined(parts))


def _numbered(placed: Sequence[Placed], place: Int) -> Iterator[TiePoints]:
    """The tie points of every part, numbered through; `place` is the new number of every photo."""
    first_photo = first_point = 0
    for part in placed:
        ties = part.ties
        yield replace(ties, photo=place[ties.photo + first_photo], point=ties.point + first_point)
        first_photo += len(part.photos)
        first_point += len(ties.xyz)
