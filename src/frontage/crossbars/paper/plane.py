"""The plane of a window's frame, and what a photo can show of it."""

from dataclasses import dataclass

import cv2
import numpy as np
import shapely
from shapely.affinity import scale
from shapely.geometry import Polygon

from frontage.crossbars.window import Window, WindowView
from frontage.geometry.arrays import Array, Bool, Float
from frontage.geometry.rigid import skew
from frontage.geometry.ring import at_depth, box_sigmas
from frontage.model.glazing import FRAME_THICKNESS_M

_USUAL_DEPTH_M = (0.15, 0.10)  # of a frame behind the wall, and its scatter from house to house
_DENSE_M = 0.1  # between the points of an outline, so that lens distortion bends it


@dataclass(frozen=True)
class FramePlane:
    """Where the front of a frame is expected: y in m in the facade frame, and its standard error.

    sigma  contains the error of the scan's depth, and that edges lie anywhere in the thickness of the frame
    """

    y: float
    sigma: float


def frame_plane(window: Window) -> FramePlane:
    """Returns the plane of a window's frame by the scan; the usual one where the scan has none."""
    depth = window.opening.depth
    value, sigma = _USUAL_DEPTH_M if depth is None else (float(depth.value), float(depth.sigma[0]))
    return FramePlane(window.wall_y + value, float(np.hypot(sigma, FRAME_THICKNESS_M / np.sqrt(12))))


def border_sigma(window: Window) -> float:
    """Returns the mean standard error m of the outline's four sides."""
    sigmas = box_sigmas(window.ring, window.opening.ring_covariance)
    return float(np.nanmean(sigmas))


def centre(view: WindowView, window: Window) -> Float:
    """Returns the photo's projection centre (3,) m in the facade frame."""
    return np.asarray(window.frame.inverse.apply(view.photo.pose.t[None])[0])


def on_plane(view: WindowView, window: Window, y: float, px: Float) -> Float:
    """Returns the points (n, 2) m (x, z) of the plane `y` that pixels (n, 2) of a crop show."""
    at = np.asarray(px, np.float64) / view.scale + np.array(view.corner, np.float64)
    start, rays = view.photo.ray(at)
    c = window.frame.inverse.apply(start[None])[0]
    d = rays @ window.frame.R
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.where(d[:, 1] > 1e-6, (y - c[1]) / d[:, 1], np.nan)
    return np.asarray(c[[0, 2]] + reach[:, None] * d[:, [0, 2]])


def to_crop(view: WindowView, window: Window, y: float, xz: Float) -> Float:
    """Returns the pixels (n, 2) of a crop that show the points (n, 2) m (x, z) of the plane `y`."""
    return view.project(window.frame, at_depth(xz, y))


def image_region(view: WindowView, window: Window, plane: FramePlane) -> Bool:
    """Returns the part (h, w) of a crop that shows the frame's plane through the hole in the wall.

    "The boundaries of the windows are projected into both images": the outline on the plane of the frame,
    less what the wall hides of it, withdrawn by the outline's standard error and two pixels. In photos from
    below, the border of a sill would otherwise look like a transom.
    """
    mask = np.zeros(view.pixels.shape[:2], np.uint8)
    c = centre(view, window)
    outline = Polygon(window.ring).buffer(0)
    grown = (plane.y - c[1]) / max(window.wall_y - c[1], 1e-3)
    seen = outline.intersection(scale(outline, grown, grown, origin=(c[0], c[2])))
    seen = seen.buffer(-(border_sigma(window) + 2 * view.gsd / max(view.cosine, 0.1)))
    for part in shapely.get_parts(seen):
        if isinstance(part, Polygon) and not part.is_empty:
            ring = np.asarray(shapely.segmentize(part, _DENSE_M).exterior.coords)
            px = to_crop(view, window, plane.y, ring)
            if np.isfinite(px).all():
                cv2.fillPoly(mask, [np.round((px - 0.5) * 16).astype(np.int32)], 1, shift=4)
    return np.asarray(mask, np.bool_)


def pose_sigma(view: WindowView, window: Window, plane: FramePlane) -> Float:
    """Returns how far (x, z) m the error of a photo's pose moves what it shows on the frame's plane (2,)."""
    pose = view.photo.local_from_camera
    if pose is None:
        raise ValueError(f"photo {view.photo.id} is not oriented")
    middle = window.ring.mean(0)
    way = window.frame.apply(np.array([[middle[0], plane.y, middle[1]]]))[0] - pose.value.t
    moved = window.frame.R.T @ np.hstack([np.eye(3), -skew(way)])  # of the point, in the facade frame
    x, y, z = window.frame.R.T @ way
    slide: Array = np.array([[1.0, -x / y, 0.0], [0.0, -z / y, 1.0]]) @ moved  # back onto the plane
    return np.sqrt(np.clip(np.diag(slide @ pose.covariance @ slide.T), 0, None))
