"""The network of the final adjustment: tie points, control from the scan, surfaces, and poses from GPS."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model import Camera, Estimate, Photo, Rig
from frontage.orientation.adjustment import (
    ImageObservations,
    Network,
    PointObservations,
    control_rows,
)
from frontage.orientation.control import ControlPoints
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.rigs import carriers_of

TIES, CONTROL, PLACES, SURFACES = 0, 1, 2, 3
"""Groups of observations, each with a variance of its own; PLACES are the rows that hold control points."""

TIES_ONCE, TIES_NEVER = 4, 5
"""Groups of measurements of tie points of which only one of a third photo and the scan tells that they are
right, and of which neither does; those in TIES have both."""

TIE_GROUPS = (TIES, TIES_ONCE, TIES_NEVER)

TIE_SIGMA_PX = 0.5
"""First standard error of a measurement of a tie point, px per axis."""

# Displacement of a blob per px that it is larger or smaller than its counterparts, relative to TIE_SIGMA_PX:
# the likeliest value for the true errors of simulated scenes.
_DISPLACED = 1.5
_HELD_M = 1e-4  # rows that hold control points; their errors are part of the image observations
_REACH_M = 0.2  # between a tie point and the middle of the flat piece that it lies on
_OFF_M = 0.05  # from its plane
_ROUGH_M = 0.003  # least standard error of a surface
# Measurements of a group of tie points, from which its variance is estimated: two of a point in two photos
# have a redundancy of one, and the standard error of a variance from 40 of them is a fifth of it.
_FEWEST = 80


@dataclass(frozen=True, eq=False)
class TiePoints:
    """Tie points with their image measurements, in local coordinates.

    xyz     (n, 3) m, approximate
    photo   (m,) int64 into the photos of the network; point (m,) int64 into `xyz`
    pixels  (m, 2) px
    sizes   (m,) px, of the blobs there; NaN where they are not known
    """

    xyz: Float
    photo: Int
    point: Int
    pixels: Float
    sizes: Float | None = None

    def __post_init__(self) -> None:
        m = len(self.photo)
        if self.sizes is None:
            object.__setattr__(self, "sizes", np.full(m, np.nan))
        freeze(self, xyz=((None, 3), np.float64), photo=((m,), np.int64), point=((m,), np.int64))
        freeze(self, pixels=((m, 2), np.float64), sizes=((m,), np.float64))

    def take(self, rows: Int | Bool) -> "TiePoints":
        """The same points with some of their measurements (m,)."""
        sizes = None if self.sizes is None else self.sizes[rows]
        return TiePoints(self.xyz, self.photo[rows], self.point[rows], self.pixels[rows], sizes)

    @staticmethod
    def joined(parts: Sequence["TiePoints"]) -> "TiePoints":
        """The measurements of several parts; their numbers of photos and points are those of the whole."""
        if not parts:
            return TiePoints.none()
        fields = ("xyz", "photo", "point", "pixels", "sizes")
        return TiePoints(*(np.concatenate([getattr(part, f) for part in parts]) for f in fields))

    @staticmethod
    def none() -> "TiePoints":
        """No tie points."""
        empty = np.empty(0, np.int64)
        return TiePoints(np.empty((0, 3)), empty, empty, np.empty((0, 2)))


def build_network(
    photos: Sequence[Photo],
    ties: TiePoints,
    control: Sequence[ControlPoints],
    surface: ScannedSurface,
    *,
    priors: Sequence[Estimate[Rigid3] | None] = (),
    camera_sigmas: Sequence[Float] = (),
    rigs: Sequence[Rig] = (),
) -> Network:
    """Puts everything that is known about oriented photos into one network.

    `photos` have approximate poses; `control`, `priors` and `camera_sigmas` belong to them in this order. A
    control point keeps its place in the scan, and its image measurement carries the error of that place too.
    The photos that `rigs` took at one moment are one body.
    """
    cameras, number = distinct_cameras([p.camera for p in photos])
    images = [tie_images(photos, ties)]
    images += [
        _control_images(k, p, c, surface) for k, (p, c) in enumerate(zip(photos, control, strict=True))
    ]
    start = len(ties.xyz)
    shifted = []
    for part in images[1:]:
        shifted.append(ImageObservations(part.photo, part.point + start, part.pixels, part.sigma, part.group))
        start += len(part)
    xyz = np.concatenate([ties.xyz, *(c.xyz for c in control)])
    carriers = carriers_of(photos, number.tolist(), rigs)
    return Network(
        carriers.bodies,
        tuple(cameras),
        carriers.photos,
        xyz,
        _joined([images[0], *shifted]),
        PointObservations.joined(_held(len(ties.xyz), xyz), _surfaces(ties.xyz, surface)),
        carriers.priors(priors) if len(priors) else (),
        tuple(_sigmas_of(cameras, number, camera_sigmas)),
    )


def distinct_cameras(cameras: Sequence[Camera]) -> tuple[list[Camera], Int]:
    """Returns the cameras without repetition, and the number (p,) of each photo's among them."""
    known: dict[tuple[object, ...], int] = {}
    kept: list[Camera] = []
    number = []
    for camera in cameras:
        key = (camera.model, camera.width, camera.height, camera.params.tobytes())
        if key not in known:
            known[key] = len(kept)
            kept.append(camera)
        number.append(known[key])
    return kept, np.array(number, np.int64)


def _sigmas_of(cameras: Sequence[Camera], number: Int, sigmas: Sequence[Float]) -> list[Float]:
    """The sigmas of every distinct camera, from those of the photos."""
    if not sigmas:
        return []
    return [sigmas[int(np.flatnonzero(number == k)[0])] for k in range(len(cameras))]


def tie_images(photos: Sequence[Photo], ties: TiePoints) -> ImageObservations:
    """Returns the image measurements of tie points as observations.

    The blob of a key point that is found larger or smaller than in the other photos is another one in part,
    whose middle lies elsewhere. Its standard error grows with that difference.
    """
    m = len(ties.photo)
    sigma = np.hypot(TIE_SIGMA_PX, _DISPLACED * _other_sizes(photos, ties))
    return ImageObservations(ties.photo, ties.point, ties.pixels, sigma, np.full(m, TIES))


def by_confirmation(network: Network) -> Network:
    """Returns a network with tie points in groups by what confirms them: a third photo, and the scan.

    A false match of two photos agrees with every point along a ray, and leaves, panes and moved things are
    not on a scanned surface. A group that is too small for a variance of its own joins the next one.
    """
    images, on = network.images, network.surfaces
    scanned = on.point[on.group == SURFACES]
    group, ties = images.group.copy(), images.group == TIES
    point = images.point[ties]
    confirmed = (np.bincount(point)[point] > 2).astype(np.int64) + np.isin(point, scanned)
    own = np.array([TIES_NEVER, TIES_ONCE, TIES])[confirmed]
    if np.count_nonzero(own == TIES_NEVER) < _FEWEST:
        own[own == TIES_NEVER] = TIES_ONCE
    if min(np.count_nonzero(own == g) for g in (TIES, TIES_ONCE)) < _FEWEST:
        own[own == TIES_ONCE] = TIES
    group[ties] = own
    return replace(network, images=replace(images, group=group))


def _other_sizes(photos: Sequence[Photo], ties: TiePoints) -> Float:
    """Returns the differences in size (m,) px between each blob and those of its point in other photos.

    They are root mean squares, and 0 where nothing is known. Near photos show a blob larger, so that sizes
    are compared in units of length.
    """
    scale, n = np.full(len(ties.photo), np.nan), len(ties.xyz)
    for k, photo in enumerate(photos):
        rows = ties.photo == k
        depth = photo.pose.inverse.apply(ties.xyz[ties.point[rows]])[:, 2]
        scale[rows] = np.where(depth > 0, depth, np.nan) / photo.camera.params[0]
    size = np.full(len(scale), np.nan) if ties.sizes is None else ties.sizes * scale
    known = np.isfinite(size)
    own, point = size[known], ties.point[known]
    count, total, square = (np.bincount(point, w, n)[point] for w in (None, own, own**2))
    apart = count * own**2 - 2.0 * own * total + square  # sum of squared differences from all of the point
    off = np.zeros(len(size))
    off[known] = np.sqrt(np.maximum(apart, 0.0) / np.maximum(count - 1, 1)) / scale[known]
    return off


def _control_images(
    number: int, photo: Photo, control: ControlPoints, surface: ScannedSurface
) -> ImageObservations:
    """The image measurements of one photo's control; sigma also has the error of the point in the scan."""
    n = len(control)
    depth = np.maximum(photo.pose.inverse.apply(control.xyz)[:, 2], 0.1) if n else np.ones(0)
    focal = float(photo.camera.params[0])
    sigma = np.hypot(control.sigma, surface.sigma * focal / depth)
    return ImageObservations(
        np.full(n, number), np.arange(n), control.pixels, np.maximum(sigma, 0.05), np.full(n, CONTROL)
    )


def _held(first: int, xyz: Float) -> PointObservations:
    points = np.arange(first, len(xyz))
    if not len(points):
        return PointObservations.none()
    return control_rows(points, xyz[points], np.eye(3) * _HELD_M**2, PLACES)


def _surfaces(xyz: Float, surface: ScannedSurface) -> PointObservations:
    """Rows that hold tie points on the scanned surface that they lie on."""
    if not len(xyz) or not len(surface.pieces):
        return PointObservations.none()
    piece = surface.near(_REACH_M, xyz)
    rows = np.flatnonzero(piece >= 0)
    at, normal = surface.pieces.xyz[piece[rows]], surface.pieces.normal[piece[rows]]
    off = np.einsum("ij,ij->i", normal, xyz[rows] - at)
    rows, at, normal, chosen = _near(rows, at, normal, off, piece)
    sigma = np.maximum(np.hypot(surface.pieces.thickness[chosen], _ROUGH_M), surface.sigma)
    return PointObservations(rows, normal, at, sigma, np.full(len(rows), SURFACES))


def _near(rows: Int, at: Float, normal: Float, off: Float, piece: Int) -> tuple[Int, Float, Float, Int]:
    near = np.abs(off) < _OFF_M
    return rows[near], at[near], normal[near], piece[rows[near]]


def _joined(parts: Sequence[ImageObservations]) -> ImageObservations:
    fields = ("photo", "point", "pixels", "sigma", "group")
    arrays: list[Array] = [np.concatenate([getattr(p, f) for p in parts]) for f in fields]
    return ImageObservations(*arrays)
