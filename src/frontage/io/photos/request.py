"""What a caller asks of a set of photos: the noun that every reader of the registry takes."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.io.poses import given_pose
from frontage.model import Camera, Photo, WorldRef


@dataclass(frozen=True, eq=False)
class PhotoRequest:
    """What a caller asks of a set of photos.

    files    the picture files, sorted
    cameras  file or folder with the cameras and poses; None when the pictures bring their own
    world    of the run
    offset   (3,) m, added to camera positions to take them to the world
    sigmas   six, m and rad, of approximate poses; None = exact
    posed    whether the poses of the file are used at all
    """

    files: tuple[Path, ...]
    cameras: str | None
    world: WorldRef
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    sigmas: tuple[float, ...] | None = None
    posed: bool = True

    @property
    def trusted(self) -> bool:
        """Whether poses are taken to be exact."""
        return self.posed and self.sigmas is None

    def photo(self, name: str, camera: Camera, file_from_camera: Rigid3) -> Photo:
        """A photo with its pose moved from the coordinates of the file to local ones."""
        if not self.posed:
            return Photo(name, camera)
        pose = Rigid3("local", "camera", file_from_camera.R, file_from_camera.t + self._shift)
        return Photo(name, camera, given_pose(pose, self.sigmas))

    @property
    def _shift(self) -> Float:
        shift: Float = np.asarray(self.offset) - self.world.origin
        return shift
