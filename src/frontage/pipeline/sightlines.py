"""Which photos show an opening: in front of it, inside the frame, not hidden by what was scanned."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float
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
    samples = facade.frame.apply(_samples(ring, wall_y))
    outline = facade.frame.apply(np.column_stack([ring[:, 0], np.full(len(ring), wall_y), ring[:, 1]]))
    looks = [v for p in photos if p.local_from_camera and (v := _look(facade, outline, samples, p))]
    if cloud is not None and looks:
        before = _before(facade, cloud, samples, np.array([look.photo.pose.t for look in looks]))
        looks = [replace(look, shown=look.shown & ~_hidden(look.at, look.photo, *before)) for look in looks]
    views = [_view(facade, samples[0], look) for look in looks if look.shown.mean() >= _LEAST]
    return tuple(sorted(views, key=lambda v: (v.gsd, v.photo)))


@dataclass(frozen=True, eq=False)
class _Look:
    """A photo of an opening: px of its outline (k, 2) and of samples on it (n, 2); which it shows (n,)."""

    photo: Photo
    outline: Float
    at: Float
    shown: Bool


def _samples(ring: Float, wall_y: float) -> Float:
    """Points (n, 3) m of the facade's frame, spread over the opening, its middle first."""
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    share = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    x, z = np.meshgrid(x0 + share * (x1 - x0), z0 + share * (z1 - z0))
    inside = shapely.contains_xy(shapely.Polygon(ring), x, z)
    x, z = np.append((x0 + x1) / 2, x[inside]), np.append((z0 + z1) / 2, z[inside])
    return np.column_stack([x, np.full(len(x), wall_y), z])


def _before(facade: Facade, cloud: Float, samples: Float, eyes: Float) -> tuple[Float, Float]:
    """Points (m, 3) local before the wall, near the lines of sight, and the spacing (m,) m of their surface.

    What hides an opening stands before its wall, and of that everything on a line of sight does. Single
    points are noise, and at the edge of a surface too few share a cell to tell its spacing.
    """
    ends = np.concatenate([samples, eyes])
    cloud = cloud[((cloud > ends.min(0) - 1.0) & (cloud < ends.max(0) + 1.0)).all(1)]
    spacing, count = local_spacing(cloud)
    y, wall_y = ((xyz - facade.frame.t) @ facade.frame.R[:, 1] for xyz in (cloud, samples[0]))
    front = (y < wall_y - _BEFORE) & (count >= _FEW)
    widest = 2.0 * np.median(spacing) if len(spacing) else 0.0
    return cloud[front], np.minimum(spacing, widest)[front]


def _look(facade: Facade, outline: Float, samples: Float, photo: Photo) -> _Look | None:
    """How a photo shows an opening if nothing hides it; None when it does not show half of it."""
    if (photo.pose.t - samples[0]) @ facade.frame.R[:, 1] >= 0:
        return None  # behind the wall
    corners, at = photo.project(outline), photo.project(samples)
    size = np.array([photo.camera.width, photo.camera.height])
    with np.errstate(invalid="ignore"):
        inside = np.minimum(at, size - at).min(1) >= 0
    if not np.isfinite(corners).all() or not np.isfinite(at[0]).all() or inside.mean() < _LEAST:
        return None
    return _Look(photo, corners, at, inside)


def _view(facade: Facade, middle: Float, look: _Look) -> PhotoView:
    ray = middle - look.photo.pose.t
    cosine = float(ray @ facade.frame.R[:, 1] / np.linalg.norm(ray))
    return PhotoView(
        look.photo.id,
        tuple((round(float(u), 2), round(float(v), 2)) for u, v in look.outline),
        visible=round(float(look.shown.mean()), 3),
        angle=round(float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))), 1),
        gsd=_gsd(facade, middle, look.photo),
    )


def _gsd(facade: Facade, middle: Float, photo: Photo) -> float:
    """m on the wall per px, the mean of both directions."""
    step = 0.01
    right, up = facade.frame.R[:, 0], facade.frame.R[:, 2]
    at = photo.project(np.array([middle, middle + step * right, middle + step * up]))
    scale = float(np.linalg.norm(at[1:] - at[0], axis=1).mean())
    return round(step / scale, 6)


def _hidden(at: Float, photo: Photo, xyz: Float, spacing: Float) -> Bool:
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
