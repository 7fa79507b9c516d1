"""Rigs: cameras that are fixed to one another, such as the twelve of paper A's vehicle."""

from dataclasses import dataclass

from frontage.geometry.rigid import Rigid3
from frontage.model.estimate import Estimate


@dataclass(frozen=True, eq=False)
class MountedCamera:
    """A camera of a rig, and how it sits on the body of the rig.

    name              as its file calls it
    body_from_camera  with its covariance (6, 6), m and rad: zero where it is exact. None = unknown
    """

    name: str
    body_from_camera: Estimate[Rigid3] | None = None


@dataclass(frozen=True)
class Exposure:
    """The photos that the cameras of a rig took at one moment, from one pose of its body.

    name     as its file calls it
    photos   their ids
    cameras  for each of them the number of its camera in the rig
    """

    name: str
    photos: tuple[str, ...]
    cameras: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Rig:
    """Cameras with fixed relative poses, and the moments at which they took photos.

    Raises ValueError for a camera that does not exist or that took two photos at one moment, and for a photo
    that was taken twice.
    """

    name: str
    cameras: tuple[MountedCamera, ...]
    exposures: tuple[Exposure, ...]

    def __post_init__(self) -> None:
        seen: set[str] = set()
        for exposure in self.exposures:
            numbers = exposure.cameras
            if len(numbers) != len(exposure.photos) or not all(0 <= k < len(self.cameras) for k in numbers):
                raise ValueError(f"rig {self.name}: exposure {exposure.name} names no camera of it")
            if len(set(numbers)) < len(numbers):
                twice = next(self.cameras[k].name for k in numbers if numbers.count(k) > 1)
                raise ValueError(f"rig {self.name}: camera {twice} took two photos of {exposure.name}")
            again = seen.intersection(exposure.photos)
            if again or len(set(exposure.photos)) < len(numbers):
                name = min(again) if again else exposure.photos[0]
                raise ValueError(f"rig {self.name}: photo {name} was taken twice")
            seen.update(exposure.photos)
