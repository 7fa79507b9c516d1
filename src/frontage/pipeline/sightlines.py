"""Which photos show an opening: in front of it, inside the frame, not hidden by what was scanned."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Array, Bool, Float
from frontage.model import Facade, Photo
from frontage.raster.zbuffer import local_spacing, splat_depth

_SAMPLES = 24  # per side of the opening's box
_LEAST = 0.5  # share of an opening that a photo must show
_BEFORE = 0.2  # m before the wall: what stands nearer is the facade's own relief
_PIXELS = 160.0  # of the mask of what hides the opening, along its longer side
_FEW = 3  # points of a cell that make a surface
_SPLAT = 0.75  # spacings: discs of this radius leave no gap on a surface


@dataclass(frozen=True)
class PhotoView:
    """A photo that shows an opening.

    outline  px (column, row) in the photo, of the opening's outline on the wall
    visible  share of the opening inside the frame that nothing scanned hides, 0..1
    angle    degrees between the line of sight and the wall's normal
    gsd      m on the wall per photo px, at the opening's middle
    """

    photo: str
    outline: tuple[tuple[float, float], ...]
    visible: float
    angle: float
    gsd: float


def photo_views(
    facade: Facade, ring: Float, wall_y: float, photos: Sequence[Photo], cloud: Float | None
) -> tuple[PhotoView, ...]:
    """The oriented photos that show at least half of an opening, the one with the finest pixels first.

    ring (k, 2) m of the facade's frame, on the wall at wall_y m; cloud (n, 3) m local, what may hide it, or
    None = not known.
    """
    samples = _samples(ring, wall_y)
    # What hides the opening stands before the wall: of that, everything on a line of sight does.
    before = None if cloud is None else _before(facade, cloud, wall_y)
    views = [v for p in photos if p.local_from_camera and (v := _view(facade, ring, samples, p, before))]
    return tuple(sorted(views, key=lambda v: (v.gsd, v.photo)))


def _samples(ring: Float, wall_y: float) -> Float:
    """Points (n, 3) m spread over the opening, its middle first."""
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    share = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    x, z = np.meshgrid(x0 + share * (x1 - x0), z0 + share * (z1 - z0))
    inside = shapely.contains_xy(shapely.Polygon(ring), x, z)
    x, z = np.append((x0 + x1) / 2, x[inside]), np.append((z0 + z1) / 2, z[inside])
    return np.column_stack([x, np.full(len(x), wall_y), z])


def _before(facade: Facade, cloud: Float, wall_y: float) -> tuple[Float, Float]:
    """Points (m, 3) local that stand before the wall, and the spacing (m,) m of their surfaces.

    Single points are noise, and at the edge of a surface too few share a cell to tell its spacing.
    """
    spacing, count = local_spacing(cloud)
    y = (cloud - facade.frame.t) @ facade.frame.R[:, 1]
    front = (y < wall_y - _BEFORE) & (count >= _FEW)
    return cloud[front], np.minimum(spacing, 2.0 * np.median(spacing) if len(spacing) else 0.0)[front]


def _view(
    facade: Facade, ring: Float, samples: Float, photo: Photo, before: tuple[Float, Float] | None
) -> PhotoView | None:
    eye = facade.frame.inverse.apply(photo.pose.t[None])[0]
    if eye[1] >= samples[0, 1]:
        return None  # behind the wall
    outline = photo.project(_local(facade, ring, samples[0, 1]))
    at = photo.project(facade.frame.apply(samples))
    size = np.array([photo.camera.width, photo.camera.height])
    with np.errstate(invalid="ignore"):
        inside = np.minimum(at, size - at).min(1) >= 0
    if not np.isfinite(outline).all() or not np.isfinite(at[0]).all() or inside[1:].mean() < _LEAST:
        return None
    hidden = np.zeros(len(at), bool) if before is None else _hidden(at, photo, *before)
    visible = float((inside & ~hidden)[1:].mean())
    if visible < _LEAST:
        return None
    ray = samples[0] - eye
    angle = float(np.degrees(np.arccos(np.clip(ray[1] / np.linalg.norm(ray), -1.0, 1.0))))
    corners = tuple((round(float(u), 2), round(float(v), 2)) for u, v in outline)
    return PhotoView(photo.id, corners, round(visible, 3), round(angle, 1), _gsd(facade, samples[0], photo))


def _local(facade: Facade, ring: Float, y: float) -> Float:
    return facade.frame.apply(np.column_stack([ring[:, 0], np.full(len(ring), y), ring[:, 1]]))


def _gsd(facade: Facade, middle: Float, photo: Photo) -> float:
    """m on the wall per px, the mean of both directions."""
    step = 0.01
    offsets = np.array([[0.0, 0.0, 0.0], [step, 0.0, 0.0], [0.0, 0.0, step]])
    at = photo.project(facade.frame.apply(middle + offsets))
    scale = float(np.linalg.norm(at[1:] - at[0], axis=1).mean())
    return round(step / scale, 6)


def _hidden(at: Array, photo: Photo, xyz: Float, spacing: Float) -> Bool:
    """Which pixels (n, 2) are covered by points (m, 3) local, discs as wide as their surface's spacing."""
    low, high = np.nanmin(at, axis=0), np.nanmax(at, axis=0)
    scale = max(1.0, float((high - low).max()) / _PIXELS)
    camera = photo.pose.inverse.apply(xyz)
    ahead = camera[:, 2] > 0.1
    camera, spacing = camera[ahead], spacing[ahead]
    pixel = photo.camera.project(camera)
    distance = np.linalg.norm(camera, axis=1)
    focal = float(
        np.linalg.norm(np.diff(photo.camera.project(np.array([[0, 0, 1.0], [1e-4, 0, 1.0]])), axis=0))
    )
    radius = focal * 1e4 * _SPLAT * spacing / distance / scale
    shape = tuple(int(np.ceil(v / scale)) + 1 for v in (high - low)[::-1])
    buffer = splat_depth((pixel - low) / scale, distance, radius, (shape[0], shape[1]))
    cell = np.nan_to_num((at - low) / scale).astype(np.int64)
    hidden: Bool = np.isfinite(buffer[cell[:, 1], cell[:, 0]])
    return hidden
