"""The result of orientation: photos with poses, what supports them, and the photos that got none."""

from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Array, Float, Int, freeze
from frontage.model import Photo, Rig

MANY = 200
"""Control points that determine a photo well all over the picture."""

PRECISE_PX = 0.7
"""The rms residual, px per axis, that so many of them shall have."""


@dataclass(frozen=True, eq=False)
class OrientedPhoto:
    """A photo with its adjusted pose and camera, and what supports it.

    photo           pose local_from_camera with its covariance (6, 6)
    number          of the photo among those given
    control         number of control points used; `control_rms` px, their residuals per axis
    ties            number of tie points used; `tie_rms` px
    check_rms       m, of control points that were left out of another adjustment; NaN without any
    redundancy      mean redundancy of its control points, 0..1
    detectable      px, median of the errors that would be detected in a single control point
    verdict         "confirmed", "tied" (only other photos support it), "carried" (only the other
                    cameras of its rig do) or "plain" (too little scan in view)
    rival           correlation of the best other place nearby, relative to that of the pose
    camera_sigma    (c,) standard errors of the camera's parameters, 0 = held fixed
    residual_at     (k, 2) px, where its control points are, those with the smallest standard error first;
                    `residual` (k, 2) px, computed minus measured
    """

    photo: Photo
    number: int
    control: int
    control_rms: float
    ties: int
    tie_rms: float
    check_rms: float
    redundancy: float
    detectable: float
    verdict: str
    rival: float
    camera_sigma: Float = field(repr=False)
    residual_at: Float = field(repr=False)
    residual: Float = field(repr=False)

    def __post_init__(self) -> None:
        k = len(self.residual_at)
        freeze(self, residual_at=((k, 2), np.float64), residual=((k, 2), np.float64))

    @property
    def precise_rms(self) -> float:
        """The rms residual, px per axis, of its 200 most precise control points; NaN where it has fewer."""
        best = self.residual[:MANY]
        return float(np.sqrt((best**2).mean())) if len(best) == MANY else float("nan")


@dataclass(frozen=True, eq=False)
class Unoriented:
    """A photo without a usable pose: its id, a code of `frontage.errors.CODES`, and the reason."""

    photo: str
    code: str
    reason: str


@dataclass(frozen=True, eq=False)
class Drawing:
    """The scan as a photo sees it, made from its reflectance, colour or shape.

    pixels  (h, w) uint8, contrast normalised; 0 where nothing was scanned
    xyz     (h, w, 3) float32 m local, the point behind every pixel; NaN where nothing was scanned
    """

    photo: str
    pixels: Array
    xyz: Array


@dataclass(frozen=True, eq=False)
class Orientation:
    """What orienting photos found.

    photos       the oriented ones, in the given order
    unoriented   the others, each with a reason
    source       what of the scan was compared with them
    points       (n, 3) m local, tie points; `sigma_points` (n, 3) m
    point        (m,) int64 into `points`, photo (m,) into `photos`, pixels (m, 2) px: their measurements
    factors      standard deviations found for tie points, control and surfaces, relative to the stated ones
    sigma0       standard deviation of unit weight; `redundancy` observations beyond those needed
    rejected     number of image measurements that were removed as gross errors
    drawings     what the scan looks like from every oriented photo
    notes        sentences for the user
    rigs         that took some of the oriented photos, with adjusted relative poses
    """

    photos: tuple[OrientedPhoto, ...]
    unoriented: tuple[Unoriented, ...]
    source: str
    points: Float
    sigma_points: Float
    point: Int
    photo: Int
    pixels: Float
    factors: dict[str, float]
    sigma0: float
    redundancy: int
    rejected: int
    notes: tuple[str, ...] = ()
    rigs: tuple[Rig, ...] = ()
    drawings: tuple[Drawing, ...] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        n, m = len(self.points), len(self.point)
        freeze(self, points=((n, 3), np.float64), sigma_points=((n, 3), np.float64))
        freeze(self, point=((m,), np.int64), photo=((m,), np.int64), pixels=((m, 2), np.float64))
