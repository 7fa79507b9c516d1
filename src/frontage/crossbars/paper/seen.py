"""The 2-D edges of one photo, laid onto the plane of the window's frame (paper B, section 3.3.1)."""

from dataclasses import dataclass, field

import cv2
import numpy as np

from frontage.crossbars.paper.edges import Segments, straight_edges
from frontage.crossbars.paper.plane import FramePlane, centre, image_region, on_plane, pose_sigma, to_crop
from frontage.crossbars.window import Window, WindowView
from frontage.geometry.arrays import Array, Float

PROFILE = 4
"""Samples on each side of an edge that describe it."""

_STEEPEST = np.tan(np.radians(20.0))  # of an edge on the plane against its axis, whatever its depth
_ALONG = 12  # places along an edge at which its profile is sampled


@dataclass(frozen=True, eq=False)
class Sight:
    """A photo of a window with its straight edges.

    grey      (h, w) float32, the crop
    segments  its edges inside the window, px of the crop
    shift     (2,) m, how far the error of the pose moves all of them in x and z
    """

    view: WindowView
    window: Window
    grey: Array = field(repr=False)
    segments: Segments = field(repr=False)
    shift: Float

    @staticmethod
    def of(view: WindowView, window: Window, plane: FramePlane) -> "Sight":
        """Extracts the straight edges of the part of a photo that shows a window."""
        grey = cv2.cvtColor(view.pixels, cv2.COLOR_RGB2GRAY).astype(np.float32)
        segments = straight_edges(grey, image_region(view, window, plane))
        return Sight(view, window, grey, segments, pose_sigma(view, window, plane))


@dataclass(frozen=True, eq=False)
class SeenEdges:
    """Edges of one photo near one axis of the window, by where their lines of sight cross the frame's plane.

    across    (n,) m, at the middle of the edge: x of upright edges, z of level ones
    along     (n, 2) m, both ends on the other axis, ascending
    slope     (n,) change of `across` per m along
    ray       (n, 2) change of (across, along) per m behind the plane on the line of sight to the middle
    sigma     (n,) m, standard error of `across` by the edge alone
    shift     m, standard error common to all edges of the photo, by its pose
    profile   (n, 2 PROFILE + 1) grey values across the edge, at equal steps on the plane
    contrast  (n,) change of the grey value to the right or upwards
    """

    across: Float
    along: Float
    slope: Float
    ray: Float
    sigma: Float
    shift: float
    profile: Float
    contrast: Float

    def __len__(self) -> int:
        return len(self.across)


def seen_edges(sight: Sight, y: float, axis: int, step: float, least: float) -> SeenEdges:
    """Returns the upright (`axis` 0, across x) or level (1, across z) edges of a photo on the plane `y`.

    step   m between the samples of the profiles, common to the photos that are matched
    least  m, length of the shortest edge
    """
    ends, error = _laid(sight, y)
    reach = np.abs(ends[:, 1] - ends[:, 0])
    near = (reach[:, axis] <= _STEEPEST * reach[:, 1 - axis]) & (reach[:, 1 - axis] >= least)
    ends, error = ends[near], error[near, axis]
    order = np.argsort(ends[:, :, 1 - axis], axis=1)
    ends = np.take_along_axis(ends, order[:, :, None], axis=1)
    across, along = ends[:, :, axis], ends[:, :, 1 - axis]
    c = centre(sight.view, sight.window)
    ray = (ends.mean(1) - c[[0, 2]]) / (y - c[1])
    profile = _profiles(sight, ends, y, axis, step)
    return SeenEdges(
        across=across.mean(1),
        along=along,
        slope=(across[:, 1] - across[:, 0]) / (along[:, 1] - along[:, 0]),
        ray=ray[:, [axis, 1 - axis]],
        sigma=error,
        shift=float(sight.shift[axis]),
        profile=profile,
        contrast=profile[:, PROFILE + 1] - profile[:, PROFILE - 1],
    )


def _laid(sight: Sight, y: float) -> tuple[Float, Float]:
    """Returns the ends (n, 2, 2) m of segments on the plane, and the standard errors (n, 2) m in x and z."""
    ends = sight.segments.ends
    way = ends[:, 1] - ends[:, 0]
    normal = np.column_stack([-way[:, 1], way[:, 0]]) / np.linalg.norm(way, axis=1, keepdims=True)
    middle = ends.mean(1)
    px = np.stack([ends[:, 0], ends[:, 1], middle, middle + normal], 1).reshape(-1, 2)
    xz = on_plane(sight.view, sight.window, y, px).reshape(-1, 4, 2)
    return xz[:, :2], np.abs(xz[:, 3] - xz[:, 2]) * sight.segments.sigma[:, None]


def _profiles(sight: Sight, ends: Float, y: float, axis: int, step: float) -> Float:
    """Returns the grey values (n, 2 PROFILE + 1) across edges, each the median along the edge."""
    share = ((np.arange(_ALONG) + 0.5) / _ALONG)[:, None, None]
    offset = np.arange(-PROFILE, PROFILE + 1) * step
    points = np.repeat(ends[:, None, :1] + share * (ends[:, None, 1:] - ends[:, None, :1]), len(offset), 2)
    points[..., axis] += offset
    if len(ends) == 0:
        return np.empty((0, len(offset)))
    px = to_crop(sight.view, sight.window, y, points.reshape(-1, 2)) - 0.5
    px = px.reshape(len(ends), -1, 2).astype(np.float32)
    values = cv2.remap(sight.grey, px, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(np.median(values.reshape(points.shape[:3]), axis=1), np.float64)
