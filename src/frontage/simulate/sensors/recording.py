"""What the simulated instruments bring home: the library's own nouns, and the truth of each."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from frontage.geometry.arrays import Array, Float, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model import Photo, Scan


class Echo(IntEnum):
    """How a return came about."""

    PLAIN = 0
    MIXED = 1  # one echo from two surfaces
    THROUGH_GLASS = 2
    GHOST = 3  # mirrored by a pane, recorded straight behind it
    PANE = 4
    STRAY = 5


@dataclass(frozen=True, eq=False)
class Recording:
    """Points and the truth about them: scan = what the file holds.

    surface (n,) int32 into Scene.surfaces, -1 stray; echo (n,) uint8 `Echo`; true_range (n,) m to it
    """

    scan: Scan
    surface: Array
    echo: Array
    true_range: Float

    def __post_init__(self) -> None:
        n = len(self.scan)
        freeze(self, surface=((n,), np.int32), echo=((n,), np.uint8), true_range=((n,), np.float64))


@dataclass(frozen=True, eq=False)
class Station(Recording):
    """One terrestrial scan position: points placed with `given`, raster with beams without return.

    true, given   local_from_scanner
    """

    true: Rigid3
    given: Rigid3


@dataclass(frozen=True, eq=False)
class Drive(Recording):
    """One mobile recording: points placed with the given trajectory; `scan.time` is gps_time, `scan.origins`
    the given sensor positions.

    trajectory     given (k, 7): gps_time s, x, y, z m local, roll, pitch, heading rad; true_trajectory alike
    scanner (n,) uint8, 1 or 2
    """

    trajectory: Float
    true_trajectory: Float
    scanner: Array

    def __post_init__(self) -> None:
        super().__post_init__()
        freeze(self, scanner=((len(self.scan),), np.uint8))


@dataclass(frozen=True, eq=False)
class Shot:
    """One photograph: pixels (h, w, 3) uint8, the photo with its true pose, and the pose in its EXIF."""

    image: Array
    photo: Photo
    given: Rigid3
