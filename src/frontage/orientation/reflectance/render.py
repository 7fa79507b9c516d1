"""Draws a scanned surface as a camera would see it: tone, depth and visibility of every pixel.

Points are drawn into a depth buffer as discs of their spacing; those on the nearest surface are spread over
the pixels bilinearly and joined by a Gaussian (normalised convolution). The picture is coarser than the photo
by a factor that makes neighbouring points fall on neighbouring pixels. Every pixel has its 3-D point: the
ray through its centre, cut off at the mean depth of the points that it was drawn from.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.model import Photo
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.raster.zbuffer import splat_depth

_JOIN_PX = 1.0  # sigma of the Gaussian that joins points
_FEWEST = 0.05  # points per pixel after joining, below which a pixel is empty
_DEPTH_SLACK = 3.0  # spacings behind the nearest point that still belong to the same surface
_LEAST_SLACK_M = 0.05
_MARGIN_PX = 24.0  # discs of points outside may reach into the picture
_WIDER = 1.15  # than the picture: the pyramid outside of which nothing is drawn
_NEAREST_M = 0.5  # to the camera; points on the instrument or the photographer are not drawn
# Of the spacing, on the picture: scans that were merged hold detail below their spacing.
FINEST = 0.3


@dataclass(frozen=True, eq=False)
class Rendering:
    """A scan as a photo would see it.

    photo  the photo with the pose that it was drawn for
    scale  (2,) px of the photo per pixel of the picture, across and down
    tone   (h, w) float32 log reflectance, 0 where unknown or when the surface has none
    depth  (h, w) float32 m along the optical axis, 0 where empty
    known  (h, w) bool, where a surface was drawn
    """

    photo: Photo
    scale: Float
    tone: Array
    depth: Array
    known: Bool

    def photo_pixels(self, at: Float) -> Float:
        """Returns pixels (n, 2) of the photo for positions (n, 2) in the picture, first centre at 0.5."""
        return np.asarray(at, np.float64) * self.scale

    def points(self, at: Array) -> Float:
        """Returns the 3-D points (n, 3) m local behind pixel centres at columns and rows (n, 2) int."""
        column, row = np.asarray(at, np.int64).T
        origin, ray = self.photo.ray(self.photo_pixels(np.column_stack([column + 0.5, row + 0.5])))
        axis = self.photo.pose.R[:, 2]
        along = self.depth[row, column] / (ray @ axis)
        return np.asarray(origin + ray * along[:, None])

    def behind(self, pixels: Float) -> Float:
        """Returns the points (n, 3) m local behind pixels (n, 2) of the photo; NaN where nothing is known."""
        h, w = self.known.shape
        column, row = np.clip(np.floor(pixels / self.scale), 0, (w - 1, h - 1)).astype(np.int64).T
        origin, ray = self.photo.ray(pixels)
        drawn = self.known[row, column] & (self.depth[row, column] > 0)
        along = np.where(drawn, self.depth[row, column], np.nan) / (ray @ self.photo.pose.R[:, 2])
        return np.asarray(origin + ray * along[:, None])


def rendering_factor(photo: Photo, surface: ScannedSurface, share: float = 0.5) -> float:
    """Returns how many px of the photo a pixel of its rendering needs, at least 1.

    It follows from the px between neighbouring points of the scan, which are fewer at a `share` of them.
    Returns 1 when none is in view.
    """
    return max(1.0, FINEST * pixel_factor(photo, surface, None, share))


def pixel_factor(
    photo: Photo, surface: ScannedSurface, size: float | None, share: float = 0.5, sample: int = 20_000
) -> float:
    """Returns how many px of the photo `size` m on the surface are, or less at a `share` of what is in view.

    `size` None stands for the spacing of the points. Returns 0 when nothing is in view.
    """
    step = max(1, len(surface) // sample)
    in_camera, numbers = _in_view(photo, surface.xyz[::step])
    pixels = photo.camera.project(in_camera)
    with np.errstate(invalid="ignore"):
        seen = ((pixels >= 0) & (pixels < (photo.camera.width, photo.camera.height))).all(1)
    if not seen.any():
        return 0.0
    length = surface.spacing[::step][numbers[seen]] if size is None else size
    return float(np.quantile(length * _focal(photo) / in_camera[seen, 2], share))


def render(photo: Photo, surface: ScannedSurface, factor: float) -> Rendering:
    """Draws what `photo` would see of the surface, `factor` times coarser than the photo."""
    w, h = (max(8, round(side / factor)) for side in (photo.camera.width, photo.camera.height))
    scale = np.array([photo.camera.width / w, photo.camera.height / h])
    in_camera, ahead = _in_view(photo, surface.xyz)
    with np.errstate(invalid="ignore"):
        at = photo.camera.project(in_camera) / scale
        near = np.flatnonzero((at > -_MARGIN_PX).all(1) & (at < (w + _MARGIN_PX, h + _MARGIN_PX)).all(1))
    at, depth, ahead = at[near], in_camera[near, 2], ahead[near]
    spacing = surface.spacing[ahead]
    # Rounded up: between discs that are too small, what is behind would show.
    radius = np.ceil(spacing * _focal(photo) / scale.mean() / depth)
    nearest = splat_depth(at, depth, radius, (h, w))
    inside = ((at >= 0) & (at < (w, h))).all(1)
    column, row = np.where(inside[:, None], at, 0.0).astype(np.int64).T
    slack = np.maximum(_DEPTH_SLACK * spacing, _LEAST_SLACK_M)
    front = np.flatnonzero(inside & (depth <= nearest[row, column] + slack))
    tone = np.zeros(len(front)) if surface.tone is None else surface.tone[ahead[front]]
    layers = spread(at[front], np.column_stack([tone, depth[front]]), (h, w))
    return Rendering(photo, scale, layers.mean[..., 0], layers.mean[..., 1], layers.known)


def _in_view(photo: Photo, xyz: Float) -> tuple[Float, Int]:
    """The points that may lie in the picture, in the camera's frame (m, 3), and their numbers (m,).

    Whatever is outside a pyramid around the picture is left out before the lens is computed.
    """
    w, h = photo.camera.width, photo.camera.height
    border = np.array([[x, y] for x in (0.0, 0.5 * w, w) for y in (0.0, 0.5 * h, h)])
    rays = photo.camera.ray(border)
    reach = np.abs(rays[:, :2] / np.maximum(rays[:, 2:], 0.05)).max(0) * _WIDER
    if not np.isfinite(reach).all():
        reach = np.array([np.inf, np.inf])
    in_camera = photo.pose.inverse.apply(xyz)
    depth = in_camera[:, 2]
    inside = (depth > _NEAREST_M) & (np.abs(in_camera[:, 0]) < reach[0] * depth)
    inside &= np.abs(in_camera[:, 1]) < reach[1] * depth
    numbers = np.flatnonzero(inside)
    return in_camera[numbers], numbers


@dataclass(frozen=True, eq=False)
class Spread:
    """Mean values (h, w, k) float32 of points on a raster, 0 where unknown, and where they are known."""

    mean: Array
    known: Bool


def spread(at: Float, values: Float, shape: tuple[int, int], join: float = _JOIN_PX) -> Spread:
    """Spreads values (n, k) at positions (n, 2), first centre at 0.5, over a raster (h, w)."""
    h, w = shape
    corner = np.floor(at - 0.5).astype(np.int64)
    share = at - 0.5 - corner
    total = np.zeros((h * w, values.shape[1] + 1))
    columns = np.column_stack([np.ones(len(at)), values])
    for right in (0, 1):
        for down in (0, 1):
            c, r = corner[:, 0] + right, corner[:, 1] + down
            weight = np.abs(1 - right - share[:, 0]) * np.abs(1 - down - share[:, 1])
            good = (c >= 0) & (c < w) & (r >= 0) & (r < h)
            cell = (r * w + c)[good]
            for k in range(columns.shape[1]):
                total[:, k] += np.bincount(cell, (weight * columns[:, k])[good], h * w)
    joined = [cv2.GaussianBlur(t.reshape(h, w).astype(np.float32), (0, 0), join) for t in total.T]
    known = joined[0] > _FEWEST
    weight = np.where(known, joined[0], 1.0)
    mean = np.stack([np.where(known, layer / weight, 0.0) for layer in joined[1:]], axis=-1)
    return Spread(mean.astype(np.float32), known)


def _focal(photo: Photo) -> float:
    """The focal length in px, from how far a small angle beside the axis reaches."""
    ahead = photo.camera.project(np.array([[0.0, 0.0, 1.0], [1e-3, 0.0, 1.0]]))
    return float(np.linalg.norm(ahead[1] - ahead[0]) / 1e-3)
