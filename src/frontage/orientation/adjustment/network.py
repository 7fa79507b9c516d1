"""The network that is adjusted: bodies, photos, cameras, object points and all observations."""

from dataclasses import dataclass, field

import numpy as np

from frontage.errors import InputError
from frontage.geometry.arrays import Array, Float, Int, freeze, readonly
from frontage.geometry.rigid import Rigid3
from frontage.model.estimate import Estimate
from frontage.model.photo import Camera


@dataclass(frozen=True, eq=False)
class Photos:
    """The photos: which body carries each, which camera took it, and how the camera sits on the body.

    body    (p,) int64
    camera  (p,) int64
    mount   (p,) int64 into `mounts`
    mounts  body_from_camera with covariances (6, 6) in the axes of the body: 0 on the diagonal holds a
            parameter fixed, inf leaves it free, and all else is a prior

    A photo on its own is its own body with the identity. The cameras of a vehicle are several photos of one
    body, and share a mount over all its poses. One mount of a vehicle has to be held or have a prior:
    otherwise nothing says what its body is.
    """

    body: Int
    camera: Int
    mount: Int
    mounts: tuple[Estimate[Rigid3], ...]

    def __post_init__(self) -> None:
        p = len(self.body)
        freeze(self, body=((None,), np.int64), camera=((p,), np.int64), mount=((p,), np.int64))
        if any(m.covariance.shape != (6, 6) or not (np.diag(m.covariance) >= 0).all() for m in self.mounts):
            raise ValueError("photos: a mount needs a covariance (6, 6)")

    def __len__(self) -> int:
        return len(self.body)

    @property
    def body_from_camera(self) -> tuple[Rigid3, ...]:
        """Per photo how its camera sits on its body, as approximately known."""
        return tuple(self.mounts[k].value for k in self.mount)

    @staticmethod
    def free(camera: Array) -> "Photos":
        """Photos that are their own bodies, of the cameras (p,)."""
        count = len(camera)
        return Photos(np.arange(count), camera, np.zeros(count, np.int64), (held_mount(),))


def held_mount(body_from_camera: Rigid3 | None = None) -> Estimate[Rigid3]:
    """How a camera sits on its body, known exactly; by default it is the body itself."""
    return Estimate(body_from_camera or Rigid3.identity("body", "camera"), np.zeros((6, 6)), np.inf)


@dataclass(frozen=True, eq=False)
class ImageObservations:
    """Measured image points.

    photo, point  (m,) int64
    pixels        (m, 2) px, first pixel centre at 0.5
    sigma         (m,) px, standard error per coordinate
    group         (m,) int64; the observations of a group share one variance component
    """

    photo: Int
    point: Int
    pixels: Float
    sigma: Float
    group: Int

    def __post_init__(self) -> None:
        m = len(self.photo)
        freeze(self, photo=((m,), np.int64), point=((m,), np.int64), pixels=((m, 2), np.float64))
        freeze(self, sigma=((m,), np.float64), group=((m,), np.int64))
        if not (np.isfinite(self.pixels).all() and _positive(self.sigma)):
            raise InputError("image observations: pixels are not finite, or a standard error is not positive")

    def __len__(self) -> int:
        return len(self.photo)

    def take(self, rows: Array) -> "ImageObservations":
        """Selects rows, by number or mask."""
        return ImageObservations(
            self.photo[rows], self.point[rows], self.pixels[rows], self.sigma[rows], self.group[rows]
        )


@dataclass(frozen=True, eq=False)
class PointObservations:
    """Linear observations of object points: ``direction . (X - at) = 0`` with a standard error.

    A tie point on a scanned surface has one row with the normal of the surface; a control point has three
    (see `control_rows`).

    point      (k,) int64
    direction  (k, 3), unit
    at         (k, 3) m, local
    sigma      (k,) m
    group      (k,) int64, numbered together with the groups of the image observations
    """

    point: Int
    direction: Float
    at: Float
    sigma: Float
    group: Int

    def __post_init__(self) -> None:
        k = len(self.point)
        freeze(self, point=((k,), np.int64), direction=((k, 3), np.float64), at=((k, 3), np.float64))
        freeze(self, sigma=((k,), np.float64), group=((k,), np.int64))
        if not (np.isfinite(self.at).all() and _positive(self.sigma)):
            raise InputError("point observations: a place is not finite, or a standard error is not positive")
        if not np.allclose(np.linalg.norm(self.direction, axis=1), 1.0, atol=1e-6):
            raise InputError("point observations: a direction is not a unit vector")

    def __len__(self) -> int:
        return len(self.point)

    def take(self, rows: Array) -> "PointObservations":
        """Selects rows, by number or mask."""
        return PointObservations(
            self.point[rows], self.direction[rows], self.at[rows], self.sigma[rows], self.group[rows]
        )

    @staticmethod
    def none() -> "PointObservations":
        """No observation."""
        empty = np.empty(0, np.int64)
        return PointObservations(empty, np.empty((0, 3)), np.empty((0, 3)), np.empty(0), empty)

    @staticmethod
    def joined(*parts: "PointObservations") -> "PointObservations":
        """All rows of several sets, in their order."""
        fields = ("point", "direction", "at", "sigma", "group")
        return PointObservations(*(np.concatenate([getattr(p, f) for p in parts]) for f in fields))


def control_rows(point: Array, at: Float, covariance: Float, group: int) -> PointObservations:
    """Three rows per control point, along the principal axes of its covariance.

    point (c,), at (c, 3) m, covariance (c, 3, 3) or (3, 3) m2. Raises InputError for a covariance that is not
    positive definite.
    """
    at = np.atleast_2d(np.asarray(at, np.float64))
    variance, axes = np.linalg.eigh(np.broadcast_to(covariance, (len(at), 3, 3)))
    if not _positive(variance):
        raise InputError("control points: a covariance is not positive definite")
    return PointObservations(
        np.repeat(np.asarray(point, np.int64), 3),
        axes.transpose(0, 2, 1).reshape(-1, 3),
        np.repeat(at, 3, axis=0),
        np.sqrt(variance).ravel(),
        np.full(3 * len(at), group),
    )


@dataclass(frozen=True, eq=False)
class Network:
    """What is adjusted; all values are approximate, in the local frame.

    poses          local_from_body of the b bodies
    cameras        the distinct cameras
    photos         p photos
    points         (n, 3) m
    images         image observations
    surfaces       linear observations of object points
    pose_priors    per body a measured pose or None; () for none at all. The covariance (6, 6) has the order
                   translation, rotation; a diagonal entry inf stands for "not measured"
    camera_sigmas  per camera the standard errors (k,) of its parameters before the adjustment: 0 holds a
                   parameter fixed, inf leaves it free; () holds all fixed

    Raises InputError for numbers of photos, bodies, cameras, mounts or points that do not exist.
    """

    poses: tuple[Rigid3, ...]
    cameras: tuple[Camera, ...]
    photos: Photos
    points: Float
    images: ImageObservations
    surfaces: PointObservations = field(default_factory=PointObservations.none)
    pose_priors: tuple[Estimate[Rigid3] | None, ...] = ()
    camera_sigmas: tuple[Float, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, points=((None, 3), np.float64))
        set_field = object.__setattr__
        set_field(self, "pose_priors", self.pose_priors or (None,) * len(self.poses))
        sigmas = self.camera_sigmas or tuple(np.zeros(len(c.params)) for c in self.cameras)
        if len(self.pose_priors) != len(self.poses) or len(sigmas) != len(self.cameras):
            raise InputError("the network needs one pose prior per body and one set of sigmas per camera")
        named = [
            readonly(s, (len(c.params),), np.float64, f"sigmas of camera {i}")
            for i, (s, c) in enumerate(zip(sigmas, self.cameras, strict=True))
        ]
        if any(not (s >= 0).all() for s in named):
            raise InputError("camera_sigmas must not be negative")
        set_field(self, "camera_sigmas", tuple(named))
        self._check()

    def _check(self) -> None:
        """Checks that all numbers exist and that no group mixes both kinds of observations."""
        bounds = (
            ("body of a photo", self.photos.body, len(self.poses)),
            ("camera of a photo", self.photos.camera, len(self.cameras)),
            ("mount of a photo", self.photos.mount, len(self.photos.mounts)),
            ("photo of an image observation", self.images.photo, len(self.photos)),
            ("point of an image observation", self.images.point, len(self.points)),
            ("point of a point observation", self.surfaces.point, len(self.points)),
            ("group of an image observation", self.images.group, np.iinfo(np.int64).max),
            ("group of a point observation", self.surfaces.group, np.iinfo(np.int64).max),
        )
        for what, numbers, end in bounds:
            if len(numbers) and (numbers.min() < 0 or numbers.max() >= end):
                raise InputError(f"the {what} does not exist: numbers go from 0 to {end - 1}")
        if len(np.intersect1d(self.images.group, self.surfaces.group)):
            raise InputError("a group holds image observations and point observations; number them apart")

    @property
    def groups(self) -> int:
        """The number of groups: the largest number used, plus one."""
        return int(max(self.images.group.max(initial=-1), self.surfaces.group.max(initial=-1))) + 1


def _positive(values: Float) -> bool:
    return bool((values > 0).all() and np.isfinite(values).all())
