"""Results in the form that the scorers compare with the truth, in local metres of the truth's world."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Array, Float, Int, freeze
from frontage.geometry.rigid import Rigid3

BORDERS = ("left", "right", "bottom", "top")


@dataclass(frozen=True, eq=False)
class FoundFacade:
    """A facade found: frame, outline (k, 2) m (x, z), covariance (6, 6) in its own axes (m, rad)."""

    id: str
    building: str
    frame: Rigid3
    outline: Float
    covariance: Float | None = None

    def __post_init__(self) -> None:
        freeze(self, outline=((None, 2), np.float64), covariance=((6, 6), np.float64))


@dataclass(frozen=True, eq=False)
class FoundBar:
    """A window bar found: axis ("vertical" or "horizontal") and centre line (2, 3) m."""

    axis: str
    line: Float

    def __post_init__(self) -> None:
        freeze(self, line=((2, 3), np.float64))


@dataclass(frozen=True, eq=False)
class FoundOpening:
    """An opening found: its ring (k, 3) m and what else the result reports, None = nothing.

    bars    its window bars
    counts  numbers of vertical and horizontal bars, where only these are known
    sigma   standard errors in m of "left", "right", "bottom", "top", "depth", as far as reported
    coarse  whether `kind` only distinguishes windows from doors
    """

    id: str
    kind: str
    ring: Float
    depth: float | None = None
    shape: str | None = None
    bars: tuple[FoundBar, ...] | None = None
    counts: tuple[int, int] | None = None
    sigma: Mapping[str, float] = field(default_factory=dict)
    coarse: bool = False

    def __post_init__(self) -> None:
        freeze(self, ring=((None, 3), np.float64))


@dataclass(frozen=True, eq=False)
class FoundProtrusion:
    """A protrusion found: ring (k, 3) m at its front, standard errors m of its borders and of the front."""

    id: str
    kind: str
    ring: Float
    sigma_border: float | None = None
    sigma_front: float | None = None

    def __post_init__(self) -> None:
        freeze(self, ring=((None, 3), np.float64))


@dataclass(frozen=True, eq=False)
class FoundPose:
    """An estimated pose: name as in the truth, standard errors (3,) m and (3,) rad, or None."""

    name: str
    pose: Rigid3
    sigma_position: Float | None = None
    sigma_angles: Float | None = None


@dataclass(frozen=True, eq=False)
class LabelledPoints:
    """Points of a run: xyz (n, 3) m, true house and found building (n,), -1 = none; names of those found."""

    xyz: Float
    house: Int
    found: Int
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        n = len(self.xyz)
        freeze(self, xyz=((n, 3), np.float64), house=((n,), np.int64), found=((n,), np.int64))


@dataclass(frozen=True, eq=False)
class OrthoPair:
    """A true and a found ortho-image on the raster of the true one.

    facade   id of the true facade; `true`, `found` (h, w, 3) uint8; `valid` (h, w) where found has a pixel
    opening  (h, w) 1-based opening, 0 = none; gsd m per pixel of the raster, gsd_found of the found image
    depth_true, depth_found  (h, w) float m behind the true plane, NaN = unknown, or None
    """

    facade: str
    true: Array
    found: Array
    valid: Array
    opening: Array
    gsd: float
    gsd_found: float
    depth_true: Array | None = None
    depth_found: Array | None = None
