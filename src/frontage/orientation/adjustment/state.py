"""The unknowns at one moment of the adjustment."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.model.photo import Camera
from frontage.orientation.adjustment.network import Network, Photos


@dataclass(frozen=True, eq=False)
class State:
    """All unknowns.

    rotations  (b, 3, 3) of local_from_body
    positions  (b, 3) m of the bodies
    cameras    with their current parameters
    points     (n, 3) m
    """

    rotations: Float
    positions: Float
    cameras: tuple[Camera, ...]
    points: Float

    @staticmethod
    def of(network: Network) -> "State":
        """The approximate values of a network."""
        rotations = np.array([p.R for p in network.poses]).reshape(-1, 3, 3)
        positions = np.array([p.t for p in network.poses]).reshape(-1, 3)
        return State(rotations, positions, network.cameras, network.points)

    def moved(self, bodies: Float, parameters: tuple[Float, ...], rows: Array, points: Float) -> "State":
        """Adds corrections: bodies (b, 6), parameters per camera, `points` (r, 3) m to the points `rows`."""
        moved = self.points.copy()
        moved[rows] += points
        return State(
            Rotation.from_rotvec(bodies[:, 3:]).as_matrix() @ self.rotations,
            self.positions + bodies[:, :3],
            tuple(replace(c, params=c.params + d) for c, d in zip(self.cameras, parameters, strict=True)),
            moved,
        )

    def with_points(self, rows: Array, points: Float) -> "State":
        """Replaces the coordinates (r, 3) of the points `rows`."""
        moved = self.points.copy()
        moved[rows] = points
        return replace(self, points=moved)

    def pose(self, body: int, like: Rigid3) -> Rigid3:
        """The pose of a body, with the frame names of `like`."""
        return Rigid3(like.to, like.frm, self.rotations[body], self.positions[body])

    def levers(self, photos: Photos) -> Float:
        """Where the cameras sit on their bodies: (p, 3) m, in the axes of the local frame."""
        offsets = np.array([r.t for r in photos.body_from_camera]).reshape(-1, 3)
        return np.asarray(np.einsum("pij,pj->pi", self.rotations[photos.body], offsets), np.float64)

    def camera_axes(self, photos: Photos) -> Float:
        """The rotations (p, 3, 3) of local_from_camera."""
        mounted = np.array([r.R for r in photos.body_from_camera]).reshape(-1, 3, 3)
        return np.asarray(self.rotations[photos.body] @ mounted, np.float64)
