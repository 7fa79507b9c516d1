"""Decides which photos show an opening: from in front, inside the frame, not hidden by scanned surfaces."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from frontage.geometry.arrays import Bool, Float
from frontage.geometry.ring import at_depth
from frontage.model import Elements, Facade, Photo
from frontage.raster.zbuffer import local_spacing, splat_depth

_SAMPLES = 24  # per side of the opening's box
_LEAST = 0.5  # share of an opening that a photo must show
_MARGIN = 1.0  # m around the lines of sight: discs there may reach into them
_OWN_RELIEF_M = 0.2  # in front of the wall: what is nearer is relief of the facade
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


Outline = tuple[Float, float]
"""Of an opening: ring (k, 2) m of the facade's frame, and y m of the wall that it lies on."""


@dataclass(frozen=True, eq=False)
class ScannedSurfaces:
    """What may hide an opening: xyz (n, 3) m local, spacing (n,) m of the points on their surface."""

    xyz: Float
    spacing: Float


def scanned_surfaces(cloud: Float) -> ScannedSurfaces:
    """Return the surfaces of a cloud (n, 3) m local.

    Isolated points are noise; at the edge of a surface a cell holds too few points to estimate their spacing.
    """
    spacing, count = local_spacing(cloud)
    widest = 2.0 * np.median(spacing) if len(spacing) else 0.0
    many = count >= _FEW
    return ScannedSurfaces(cloud[many], np.minimum(spacing, widest)[many])


def photo_views(
    facade: Facade, outlines: Sequence[Outline], photos: Sequence[Photo], scanned: ScannedSurfaces | None
) -> list[tuple[PhotoView, ...]]:
    """Return, per opening, the oriented photos that show at least half of it, the finest pixels first.

    outlines  ring (k, 2) m of every opening in the facade frame, with y m of the wall that it lies on
    scanned   the surfaces that may hide an opening; None = unknown
    """
    samples = [facade.frame.apply(_samples(*outline)) for outline in outlines]
    corners = [facade.frame.apply(at_depth(*outline)) for outline in outlines]
    walls = [y for _, y in outlines]
    views: list[list[PhotoView]] = [[] for _ in outlines]
    for photo in photos:
        if photo.local_from_camera is None:
            continue
        shown = {
            k: projection
            for k in range(len(outlines))
            if (projection := _project(facade, corners[k], samples[k], photo))
        }
        if scanned is not None and shown:
            occluders = _occluders(facade, photo, np.concatenate([samples[k] for k in shown]), scanned)
            shown = {
                k: projection.without(occluders.cover(projection.at, walls[k] - _OWN_RELIEF_M))
                for k, projection in shown.items()
            }
        for k, projection in shown.items():
            if projection.shown.mean() >= _LEAST:
                views[k].append(_view(facade, samples[k][0], photo, projection))
    return [tuple(sorted(own, key=lambda v: (v.gsd, v.photo))) for own in views]


def name_photos(
    facade: Facade, elements: Elements, photos: Sequence[Photo], scanned: ScannedSurfaces | None
) -> Elements:
    """Return the elements of a facade with the names of the photos that show each opening."""
    outlines = [(o.ring, elements.wall_y(o)) for o in elements.openings]
    views = photo_views(facade, outlines, photos, scanned)
    names = (tuple(view.photo for view in own) for own in views)
    openings = (replace(o, photos=own) for o, own in zip(elements.openings, names, strict=True))
    return replace(elements, openings=tuple(openings))


@dataclass(frozen=True, eq=False)
class _Projection:
    """An opening in a photo: px of its outline (k, 2) and of samples on it (n, 2); which are shown (n,)."""

    outline: Float
    at: Float
    shown: Bool

    def without(self, hidden: Bool) -> "_Projection":
        return _Projection(self.outline, self.at, self.shown & ~hidden)


@dataclass(frozen=True, eq=False)
class _Occluders:
    """Points in a photo: px (n, 2), distance (n,) m, radius (n,) px, y (n,) m behind the facade's plane."""

    pixel: Float
    distance: Float
    radius: Float
    y: Float

    def cover(self, at: Float, before: float) -> Bool:
        """Tell which pixels (m, 2) are hidden. Points at y >= `before` m are the facade itself."""
        low, high = np.nanmin(at, axis=0), np.nanmax(at, axis=0)
        scale = max(1.0, float((high - low).max()) / _PIXELS)
        columns, rows = (int(np.ceil(v / scale)) + 1 for v in high - low)
        own = self.y < before
        buffer = splat_depth(
            (self.pixel[own] - low) / scale, self.distance[own], self.radius[own] / scale, (rows, columns)
        )
        cell = np.nan_to_num((at - low) / scale).astype(np.int64)
        hidden: Bool = np.isfinite(buffer[cell[:, 1], cell[:, 0]])
        return hidden


def _samples(ring: Float, wall_y: float) -> Float:
    """Return points (n, 3) m of the facade frame, spread over the opening, its centre first."""
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    share = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    x, z = np.meshgrid(x0 + share * (x1 - x0), z0 + share * (z1 - z0))
    inside = shapely.contains_xy(shapely.Polygon(ring), x, z)
    x, z = np.append((x0 + x1) / 2, x[inside]), np.append((z0 + z1) / 2, z[inside])
    return at_depth(np.column_stack([x, z]), wall_y)


def _occluders(facade: Facade, photo: Photo, ends: Float, scanned: ScannedSurfaces) -> _Occluders:
    """Return what stands between a photo and points `ends` (n, 3) m local of a facade."""
    ends = np.concatenate([ends, photo.pose.t[None]])
    near = ((scanned.xyz > ends.min(0) - _MARGIN) & (scanned.xyz < ends.max(0) + _MARGIN)).all(1)
    xyz, spacing = scanned.xyz[near], scanned.spacing[near]
    camera = photo.pose.inverse.apply(xyz)
    ahead = camera[:, 2] > 0.1
    camera, spacing = camera[ahead], spacing[ahead]
    distance = np.linalg.norm(camera, axis=1)
    step = 1e-4
    axis = photo.camera.project(np.array([[0, 0, 1.0], [step, 0, 1.0]]))
    focal = float(np.linalg.norm(axis[1] - axis[0])) / step
    y = (xyz[ahead] - facade.frame.t) @ facade.frame.R[:, 1]
    return _Occluders(photo.camera.project(camera), distance, focal * _SPLAT * spacing / distance, y)


def _project(facade: Facade, outline: Float, samples: Float, photo: Photo) -> _Projection | None:
    """Project an opening into a photo; None if less than half of it lies inside the frame."""
    if (photo.pose.t - samples[0]) @ facade.frame.R[:, 1] >= 0:
        return None  # behind the wall
    corners, at = photo.project(outline), photo.project(samples)
    size = np.array([photo.camera.width, photo.camera.height])
    with np.errstate(invalid="ignore"):
        inside = np.minimum(at, size - at).min(1) >= 0
    if not np.isfinite(corners).all() or not np.isfinite(at[0]).all() or inside.mean() < _LEAST:
        return None
    return _Projection(corners, at, inside)


def _view(facade: Facade, middle: Float, photo: Photo, projection: _Projection) -> PhotoView:
    ray = middle - photo.pose.t
    cosine = float(ray @ facade.frame.R[:, 1] / np.linalg.norm(ray))
    return PhotoView(
        photo.id,
        tuple((round(float(u), 2), round(float(v), 2)) for u, v in projection.outline),
        visible=round(float(projection.shown.mean()), 3),
        angle=round(float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))), 1),
        gsd=_gsd(facade, middle, photo),
    )


def _gsd(facade: Facade, middle: Float, photo: Photo) -> float:
    """Return m on the wall per px, the mean of both directions."""
    step = 0.01
    right, up = facade.frame.R[:, 0], facade.frame.R[:, 2]
    at = photo.project(np.array([middle, middle + step * right, middle + step * up]))
    scale = float(np.linalg.norm(at[1:] - at[0], axis=1).mean())
    return round(step / scale, 6)
