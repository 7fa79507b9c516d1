"""Photos after an adjustment: what was measured in them, and what of it supports their poses."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Bool, Int
from frontage.orientation.adjustment import Adjustment, Network
from frontage.orientation.control import ControlPoints
from frontage.orientation.network import CONTROL
from frontage.orientation.placed import Placed

# Per reach of the search, residuals that agree with a place. In the right place they are 0.01 in the median
# where tones are compared, and 0.1 where shapes are; in a wrong one points are found all over the reach.
_AGREEING = 0.25
_CHANCE = _AGREEING**2  # the share of points in a wrong place that agree


@dataclass(frozen=True, eq=False)
class AdjustedPhotos:
    """The photos that are still in, with what was measured in them, and the last adjustment."""

    placed: Placed
    control: tuple[ControlPoints, ...]
    network: Network
    adjustment: Adjustment

    @property
    def improved(self) -> Placed:
        """The photos with adjusted poses and cameras, and the adjusted tie points."""
        found, ties = self.adjustment, self.placed.ties
        cameras = [found.cameras[k].value for k in found.photos.camera]
        photos = tuple(
            replace(photo, camera=cameras[k], local_from_camera=found.photo_pose(k))
            for k, photo in enumerate(self.placed.photos)
        )
        return Placed(self.placed.numbers, photos, replace(ties, xyz=found.points[: len(ties.xyz)]))

    def rows(self, photo: int, group: int) -> Int:
        """The image observations (k,) of a group in a photo that the adjustment used."""
        images = self.network.images
        return np.flatnonzero(self.adjustment.used & (images.photo == photo) & (images.group == group))

    def used_control(self, photo: int) -> Bool:
        """Which control points (n,) of a photo the adjustment used."""
        images = self.network.images
        used: Bool = self.adjustment.used[(images.photo == photo) & (images.group == CONTROL)]
        return used

    def recognising(self, photo: int) -> int:
        """How many control points show that a photo is where it is thought to be.

        In a wrong place points are found as well, somewhere within the reach of the search: most must agree,
        and as many as agree by chance are taken off.
        """
        control, off = self.control[photo], self.adjustment.residuals[self.rows(photo, CONTROL)]
        agree: Bool = np.asarray((np.abs(off) <= _AGREEING * control.radius).all(axis=1))
        if 2 * agree.sum() <= len(agree):
            return 0
        unique = control.unique[self.used_control(photo)]
        by_chance = _CHANCE / (1.0 - _CHANCE) * (unique & ~agree).sum()
        return max(0, int((unique & agree).sum() - by_chance))

    def fellows(self, photo: int) -> Int:
        """The photos on the body of a photo, itself among them."""
        body = self.network.photos.body
        return np.flatnonzero(body == body[photo])
