"""What photos are oriented in, and photos with approximate poses in it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.model import Photo, Rig
from frontage.orientation.network import TiePoints
from frontage.orientation.nouns import CommonPoints
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import ImageOf

Tell = Callable[[str], None]

PRIOR_SIGMAS = 4.0
"""A position that is farther than this from the approximate one contradicts it."""


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


def of_photos(ties: TiePoints, keep: Int) -> TiePoints:
    """The tie points of some photos, which are numbered anew."""
    place = np.full(max(int(ties.photo.max(initial=-1)), int(keep.max(initial=-1))) + 1, -1)
    place[keep] = np.arange(len(keep))
    rows = place[ties.photo] >= 0
    return TiePoints(ties.xyz, place[ties.photo[rows]], ties.point[rows], ties.pixels[rows])
