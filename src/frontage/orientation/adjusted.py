"""Photos after an adjustment: what was measured in them, and what of it supports their poses."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from frontage.geometry.arrays import Bool, Int
from frontage.orientation.adjustment import Adjustment, Network
from frontage.orientation.control import ControlPoints
from frontage.orientation.network import CONTROL, TIE_GROUPS
from frontage.orientation.placed import Placed

_SCATTERED = 0.1  # median residual per reach: 0.01 in the right place, never above 0.03; by chance 0.5


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

    @property
    def ties(self) -> Bool:
        """Which image observations (m,) are measurements of tie points that the adjustment used."""
        used: Bool = self.adjustment.used & np.isin(self.network.images.group, TIE_GROUPS)
        return used

    def ties_of(self, photo: int) -> Int:
        """The measurements (k,) of tie points in a photo that the adjustment used."""
        return np.flatnonzero(self.ties & (self.network.images.photo == photo))

    def used_control(self, photo: int) -> Bool:
        """Which control points (n,) of a photo the adjustment used."""
        images = self.network.images
        used: Bool = self.adjustment.used[(images.photo == photo) & (images.group == CONTROL)]
        return used

    def recognising(self, photo: int) -> int:
        """How many control points show that a photo is where it is thought to be.

        In a wrong place points are found as well, somewhere within the reach of the search.
        """
        control, off = self.control[photo], self.adjustment.residuals[self.rows(photo, CONTROL)]
        if not off.size or np.median(np.abs(off)) > _SCATTERED * control.radius:
            return 0
        return int((self.used_control(photo) & control.unique).sum())

    def fellows(self, photo: int) -> Int:
        """The photos on the body of a photo, itself among them."""
        body = self.network.photos.body
        return np.flatnonzero(body == body[photo])

    @property
    def blocks(self) -> Int:
        """The number (p,) of the block of every photo, in which tie points and rigs connect all with all."""
        photos, images, body = len(self.placed.photos), self.network.images, self.network.photos.body
        ties = self.ties
        # Photos, points and bodies are the nodes of one graph.
        first = np.concatenate([images.photo[ties], np.arange(photos)])
        second = np.concatenate([photos + images.point[ties], photos + len(self.network.points) + body])
        size = photos + len(self.network.points) + int(body.max()) + 1
        links = coo_array((np.ones(len(first)), (first, second)), shape=(size, size))
        return np.asarray(connected_components(links, directed=False)[1][:photos], np.int64)
