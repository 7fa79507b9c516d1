"""Photos and scan drawn on one upright wall: perspective vanishes, shift and size remain."""

from collections.abc import Sequence

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.model import Photo
from frontage.orientation.gradients import Channels, mean_channels, oriented_gradients
from frontage.orientation.reflectance.render import spread
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import ImageOf, geometry_tone, photo_tone
from frontage.orientation.walls import UprightWall

_THICK_M = 0.7  # what lies this far before or behind a wall is drawn on it
_STEEPEST = 0.25  # cosine between a ray and the wall's normal, below which a photo shows nothing of use


def scan_on_wall(surface: ScannedSurface, wall: UprightWall, pixel: float) -> Channels:
    """Returns the oriented gradients of the scan on a wall; `pixel` m, row 0 at the top of its extent."""
    at = wall.pose.inverse.apply(surface.xyz)
    x0, z0, x1, z1 = wall.extent
    near = np.flatnonzero(
        (np.abs(at[:, 1]) < _THICK_M) & (at[:, 0] > x0) & (at[:, 0] < x1) & (at[:, 2] > z0) & (at[:, 2] < z1)
    )
    shape = (max(8, round((z1 - z0) / pixel)), max(8, round((x1 - x0) / pixel)))
    position = np.column_stack([at[near, 0] - x0, z1 - at[near, 2]]) / pixel
    tone = np.zeros(len(near)) if surface.tone is None else surface.tone[near]
    join = max(1.0, 0.6 * float(np.median(surface.spacing[near])) / pixel) if len(near) else 1.0
    layers = spread(position, np.column_stack([tone, at[near, 1]]), shape, join)
    shape_of_wall = oriented_gradients(*geometry_tone(layers.mean[..., 1], layers.known))
    if surface.tone is None:
        return shape_of_wall
    return mean_channels(shape_of_wall, oriented_gradients(layers.mean[..., 0], layers.known))


def photos_on_wall(
    photos: Sequence[Photo], image_of: ImageOf, wall: UprightWall, pixel: float, unit: float = 1.0
) -> Channels:
    """Returns the mean oriented gradients of photos on a wall of their own frame; `pixel` in its units.

    `unit` is the number of block units in a metre. Each photo counts by how squarely it sees the wall.
    """
    x0, z0, x1, z1 = wall.extent
    h, w = max(8, round((z1 - z0) / pixel)), max(8, round((x1 - x0) / pixel))
    columns, rows = np.meshgrid(np.arange(w) + 0.5, np.arange(h) + 0.5)
    flat = np.column_stack([x0 + columns.ravel() * pixel, np.zeros(h * w), z1 - rows.ravel() * pixel])
    xyz = wall.pose.apply(flat)
    total, weight = np.zeros((3, h, w), np.float32), np.zeros((h, w), np.float32)
    for photo in photos:
        share, picture = _drawn(photo, image_of, xyz, wall, (h, w), pixel)
        if picture is not None:
            channels = oriented_gradients(picture, share > 0)
            total += channels.values * share
            weight += share * channels.known
    known = weight > 0
    return Channels(total / np.where(known, weight, 1.0), known)


def _drawn(
    photo: Photo, image_of: ImageOf, xyz: Float, wall: UprightWall, shape: tuple[int, int], pixel: float
) -> tuple[Array, Array | None]:
    """How well a photo sees every pixel (h, w), 0..1, and its log tones there; None if it sees nothing."""
    at = photo.project(xyz)
    ray = xyz - photo.pose.t
    distance = np.linalg.norm(ray, axis=1)
    cosine = (ray @ wall.inward) / np.maximum(distance, 1e-9)
    with np.errstate(invalid="ignore"):
        inside = ((at > 1) & (at < (photo.camera.width - 1, photo.camera.height - 1))).all(1)
    share = np.where(inside & (cosine > _STEEPEST), cosine, 0.0).reshape(shape).astype(np.float32)
    if (share > 0).sum() < 200:
        return share, None
    # The picture is reduced to the pixels of the wall, so that sampling it does not alias.
    grid = at.reshape(*shape, 2)
    step = np.nanmedian(np.linalg.norm(np.diff(grid, axis=1), axis=2)[share[:, 1:] > 0])
    factor = max(1.0, float(step))
    tone, scale = photo_tone(image_of(photo.id), factor)
    with np.errstate(over="ignore"):  # of places far outside of the picture, whose share is nothing
        where = (grid / scale - 0.5).astype(np.float32)
    drawn = cv2.remap(tone, where[..., 0], where[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return share, drawn
