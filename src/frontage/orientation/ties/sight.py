"""What matching needs of a photo: the rays and the unit descriptors of its key points."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.model import Camera
from frontage.orientation.nouns import KeyPoints
from frontage.orientation.ties.matches import unit


@dataclass(frozen=True, eq=False)
class Sight:
    """The key points of a photo in the frame of its camera.

    rays   (n, 3) unit vectors; (0, 0, 0), which fits no epipolar plane, where a pixel has none
    looks  (n, 128) float32, descriptors of length 1
    pixel  rad, the angle of a pixel in the middle of the picture
    """

    rays: Float
    looks: Array
    pixel: float


def sight_of(points: KeyPoints, camera: Camera) -> Sight:
    """Returns the rays and unit descriptors of key points."""
    rays = np.nan_to_num(camera.ray(points.pixels)) if len(points) else np.empty((0, 3))
    return Sight(rays, unit(points.descriptors), pixel_angle(camera))


def pixel_angle(camera: Camera) -> float:
    """Returns the angle (rad) of a pixel in the middle of the picture."""
    x, y = camera.width / 2, camera.height / 2
    two = camera.ray(np.array([[x, y], [x + 1.0, y]]))
    return float(np.linalg.norm(two[1] - two[0]))
