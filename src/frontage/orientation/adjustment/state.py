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
    turns      (q, 3, 3) rotations of body_from_camera of the mounts, arms (q, 3) m their positions
    points     (n, 3) m
    """

    rotations: Float
    positions: Float
    cameras: tuple[Camera, ...]
    turns: Float
    arms: Float
    points: Float

    @staticmethod
    def of(network: Network) -> "State":
        """The approximate values of a network."""
        rotations = np.array([p.R for p in network.poses]).reshape(-1, 3, 3)
        positions = np.array([p.t for p in network.poses]).reshape(-1, 3)
        mounts = [m.value for m in network.photos.mounts]
        turns = np.array([m.R for m in mounts]).reshape(-1, 3, 3)
        arms = np.array([m.t for m in mounts]).reshape(-1, 3)
        return State(rotations, positions, network.cameras, turns, arms, network.points)

    def moved(
        self, bodies: Float, parameters: tuple[Float, ...], mounts: Float, rows: Array, points: Float
    ) -> "State":
        """Adds corrections: bodies (b, 6), parameters per camera, mounts (q, 6), points (r, 3) at `rows`."""
        moved = self.points.copy()
        moved[rows] += points
        return State(
            Rotation.from_rotvec(bodies[:, 3:]).as_matrix() @ self.rotations,
            self.positions + bodies[:, :3],
            tuple(replace(c, params=c.params + d) for c, d in zip(self.cameras, parameters, strict=True)),
            Rotation.from_rotvec(mounts[:, 3:]).as_matrix() @ self.turns,
            self.arms + mounts[:, :3],
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

    def mount(self, number: int, like: Rigid3) -> Rigid3:
        """How a camera sits on its body, with the frame names of `like`."""
        return Rigid3(like.to, like.frm, self.turns[number], self.arms[number])

    def levers(self, photos: Photos) -> Float:
        """Where the cameras sit on their bodies: (p, 3) m, in the axes of the local frame."""
        turned = np.einsum("pij,pj->pi", self.rotations[photos.body], self.arms[photos.mount])
        return np.asarray(turned, np.float64)

    def camera_axes(self, photos: Photos) -> Float:
        """The rotations (p, 3, 3) of local_from_camera."""
        return np.asarray(self.rotations[photos.body] @ self.turns[photos.mount], np.float64)
