"""Cameras and photographs, which project points to pixels."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry import camera as maths
from frontage.geometry.arrays import Float, readonly
from frontage.geometry.rigid import Rigid3
from frontage.model.estimate import Estimate

_LARGEST_PX = 1e9  # no parameter of a camera is as large


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera: COLMAP model ("PINHOLE", "OPENCV", ...), size in px, parameters in COLMAP's order.

    Raises InputError (I310) for an unknown model, ValueError for a wrong number of parameters or ones
    that are not finite.
    """

    model: str
    width: int
    height: int
    params: Float

    def __post_init__(self) -> None:
        n = maths.parameter_count(self.model)
        object.__setattr__(
            self, "params", readonly(self.params, (n,), np.float64, f"{self.model} parameters")
        )
        if not (np.abs(self.params) < _LARGEST_PX).all():  # NaN is not, either
            raise ValueError(f"{self.model} parameters are not finite or beyond {_LARGEST_PX:g}")

    def project(self, xyz_camera: Float) -> Float:
        """Projects points (n, 3) m of the camera frame to pixels (n, 2); NaN where it cannot see."""
        return maths.project(self.model, self.params, xyz_camera)

    def ray(self, pixels: Float) -> Float:
        """Returns the unit directions (n, 3) of pixels (n, 2) in the camera frame."""
        return maths.unproject(self.model, self.params, pixels)


@dataclass(frozen=True, eq=False)
class Photo:
    """A photograph without its pixels: id (its name), camera, and pose and time (s) where known."""

    id: str
    camera: Camera
    local_from_camera: Estimate[Rigid3] | None = None
    time: float | None = None

    @property
    def pose(self) -> Rigid3:
        """The pose `local_from_camera`. Raises ValueError when the photo is not oriented."""
        if self.local_from_camera is None:
            raise ValueError(f"photo {self.id} is not oriented")
        return self.local_from_camera.value

    def project(self, xyz_local: Float) -> Float:
        """Projects local points (n, 3) m to pixels (n, 2), first centre at 0.5; NaN behind the camera."""
        return self.camera.project(self.pose.inverse.apply(xyz_local))

    def ray(self, pixels: Float) -> tuple[Float, Float]:
        """Returns the origin (3,) m and the unit directions (n, 3), local, of the rays of pixels (n, 2)."""
        return self.pose.t, self.pose.rotate(self.camera.ray(pixels))
