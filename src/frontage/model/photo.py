"""A camera and a photograph: how points become pixels."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry import camera as maths
from frontage.geometry.arrays import Float, readonly
from frontage.geometry.rigid import Rigid3
from frontage.model.estimate import Estimate


@dataclass(frozen=True, eq=False)
class Camera:
    """A COLMAP camera model ("PINHOLE", "OPENCV", ...), its size in px, parameters in COLMAP's order."""

    model: str
    width: int
    height: int
    params: Float

    def __post_init__(self) -> None:
        n = maths.parameter_count(self.model)
        object.__setattr__(
            self, "params", readonly(self.params, (n,), np.float64, f"{self.model} parameters")
        )

    def project(self, xyz_camera: Float) -> Float:
        """Points (n, 3) m in the camera frame to pixels (n, 2); NaN behind the camera or past its lens."""
        return maths.project(self.model, self.params, xyz_camera)

    def ray(self, pixels: Float) -> Float:
        """Pixels (n, 2) to unit directions (n, 3) in the camera frame."""
        return maths.unproject(self.model, self.params, pixels)


@dataclass(frozen=True, eq=False)
class Photo:
    """A photograph: id (its name), camera, pose when known, time in s when known. It holds no pixels."""

    id: str
    camera: Camera
    local_from_camera: Estimate[Rigid3] | None = None
    time: float | None = None

    @property
    def pose(self) -> Rigid3:
        """`local_from_camera`, or ValueError when the photo is not oriented."""
        if self.local_from_camera is None:
            raise ValueError(f"photo {self.id} is not oriented")
        return self.local_from_camera.value

    def project(self, xyz_local: Float) -> Float:
        """Local points (n, 3) m to pixels (n, 2), pixel centre at 0.5; NaN behind the camera."""
        return self.camera.project(self.pose.inverse.apply(xyz_local))

    def ray(self, pixels: Float) -> tuple[Float, Float]:
        """Pixels (n, 2) to the ray's origin (3,) m and unit directions (n, 3), local."""
        return self.pose.t, self.pose.rotate(self.camera.ray(pixels))
