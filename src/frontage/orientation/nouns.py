"""What the steps of orientation hand to one another: key points, matched pairs, and blocks of photos."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Float, Int, freeze
from frontage.model import Photo


@dataclass(frozen=True, eq=False)
class KeyPoints:
    """The key points of one photo, in the order of falling scale.

    pixels       (n, 2) px of the full picture, first pixel centre at 0.5
    scale        (n,) px, size of the blob
    descriptors  (n, 128) uint8, RootSIFT times 512
    sharpness    px, width of the finest edges; large for blurred pictures
    """

    pixels: Float
    scale: Float
    descriptors: Array
    sharpness: float = float("nan")

    def __post_init__(self) -> None:
        n = len(self.pixels)
        freeze(self, pixels=((n, 2), np.float64), scale=((n,), np.float64), descriptors=((n, 128), np.uint8))

    def __len__(self) -> int:
        return len(self.pixels)


@dataclass(frozen=True, eq=False)
class PairMatches:
    """Key points of two photos that agree with one relative orientation.

    first, second  numbers of the photos
    rows           (m, 2) int64, key point of the first and of the second photo
    rotation       (3, 3) second_from_first
    direction      (3,) unit vector, the position of the first camera in the frame of the second
    angle          rad, median angle at which the rays of the pair meet
    rival          share of matches, relative to `rows`, that a second, different orientation explains;
                   near 1 the two photos may be shifted against each other by one window
    """

    first: int
    second: int
    rows: Int
    rotation: Float
    direction: Float
    angle: float
    rival: float = 0.0

    def __post_init__(self) -> None:
        freeze(self, rows=((None, 2), np.int64), rotation=((3, 3), np.float64), direction=((3,), np.float64))


@dataclass(frozen=True, eq=False)
class CommonPoints:
    """What two photos both show, in pixels.

    first, second  numbers of the photos
    pixels         (m, 2, 2) px in the first and in the second photo
    sizes          (m, 2) px, of the blobs there; None: not known
    """

    first: int
    second: int
    pixels: Float
    sizes: Float | None = None

    def __post_init__(self) -> None:
        freeze(self, pixels=((None, 2, 2), np.float64), sizes=((len(self.pixels), 2), np.float64))

    @staticmethod
    def of(pair: PairMatches, keypoints: Sequence[KeyPoints]) -> "CommonPoints":
        """Those of a matched pair; `keypoints` are of all photos."""
        both = [(keypoints[n], pair.rows[:, k]) for k, n in enumerate((pair.first, pair.second))]
        pixels = np.stack([points.pixels[rows] for points, rows in both], axis=1)
        sizes = np.stack([points.scale[rows] for points, rows in both], axis=1)
        return CommonPoints(pair.first, pair.second, pixels, sizes)


@dataclass(frozen=True, eq=False)
class Block:
    """Photos oriented relative to one another, in a frame of arbitrary place, direction and scale.

    numbers  (p,) int64, which of the given photos these are
    photos   (p,), with poses and cameras in the block's frame
    points   (n, 3) in block units
    photo    (m,) int64 of every image measurement, into `photos`; point (m,) int64 into `points`
    pixels   (m, 2) px
    sizes    (m,) px, of the blobs there; None: not known
    """

    numbers: Int
    photos: tuple[Photo, ...]
    points: Float
    photo: Int
    point: Int
    pixels: Float
    sizes: Float | None = None

    def __post_init__(self) -> None:
        m = len(self.photo)
        freeze(
            self,
            numbers=((len(self.photos),), np.int64),
            points=((None, 3), np.float64),
            photo=((m,), np.int64),
            point=((m,), np.int64),
            pixels=((m, 2), np.float64),
            sizes=((m,), np.float64),
        )
