"""What the simulated sensors record: the library's own nouns, each with its truth."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from frontage.geometry.arrays import Array, Float, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model import Photo, Scan


class Echo(IntEnum):
    """The origin of an echo."""

    PLAIN = 0
    MIXED = 1  # one echo from several surfaces
    THROUGH_GLASS = 2
    GHOST = 3  # mirrored by a pane, recorded straight behind it
    PANE = 4
    STRAY = 5


@dataclass(frozen=True, eq=False)
class Recording:
    """The points of a scan, and the truth about them.

    scan         what the file contains
    surface      (n,) int32, index into `Scene.surfaces`; -1 for stray points
    echo         (n,) uint8, `Echo`
    true_range   (n,) m, to that surface
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
    """One terrestrial scan; its raster includes the beams without return.

    true    the true pose, local_from_scanner
    given   the pose that is handed over, with which the points were placed
    """

    true: Rigid3
    given: Rigid3


@dataclass(frozen=True, eq=False)
class Drive(Recording):
    """One mobile recording, whose points were placed with the navigation's trajectory.

    `scan.time` is gps_time, and `scan.origins` are the sensor positions according to the navigation.

    trajectory        (k, 7) as handed over: gps_time s, x, y, z m local, roll, pitch, heading rad
    true_trajectory   (k, 7), likewise
    scanner           (n,) uint8, 1 or 2
    """

    trajectory: Float
    true_trajectory: Float
    scanner: Array

    def __post_init__(self) -> None:
        super().__post_init__()
        freeze(self, scanner=((len(self.scan),), np.uint8))


@dataclass(frozen=True, eq=False)
class Shot:
    """One photograph: pixels (h, w, 3) uint8, the photo with its true pose, and the pose `given` in EXIF."""

    image: Array
    photo: Photo
    given: Rigid3
