"""A window with what the photos show of it: the input of both methods."""

from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Array, Float, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model import Opening, Photo


@dataclass(frozen=True, eq=False)
class WindowView:
    """The part of a photo that shows a window.

    pixels   (h, w, 3) uint8 RGB, a crop of the photo with a margin around the window
    corner   (column, row) px of the crop's upper left corner in the photo
    visible  share of the window that lies inside the photo, 0..1
    gsd      m on the wall per px of the crop at the window's middle, in the coarser direction
    cosine   of the angle between the line of sight and the wall's normal
    scale    px of the crop per px of the photo; below 1 where the photo is finer than bars need
    """

    photo: Photo
    pixels: Array = field(repr=False)
    corner: tuple[int, int]
    visible: float
    gsd: float
    cosine: float
    scale: float = 1.0

    def project(self, frame: Rigid3, xyz: Float) -> Float:
        """Project points (n, 3) m of a facade frame to pixels (n, 2) of the crop, first centre at 0.5."""
        at = self.photo.project(frame.apply(xyz)) - np.array(self.corner, np.float64)
        return np.asarray(self.scale * at, np.float64)


@dataclass(frozen=True, eq=False)
class Window:
    """A glazed opening of a facade, its views, and the scan points near the plane of its frame.

    opening  from the scan: outline, depth where it was measured
    frame    local_from_facade
    wall_y   m, of the wall that holds the opening, in the facade frame
    views    the photos that show it, those with the finest pixels on the wall first
    points   (n, 3) m, facade frame: scan points within the outline, from the wall to 0.7 m behind it
    spacing  m, of the scan points on the wall around the window
    """

    opening: Opening
    frame: Rigid3
    wall_y: float
    views: tuple[WindowView, ...] = field(repr=False)
    points: Float = field(repr=False)
    spacing: float

    def __post_init__(self) -> None:
        freeze(self, points=((None, 3), np.float64))

    @property
    def ring(self) -> Float:
        """The outline (k, 2) m (x, z) of the opening, counter-clockwise as seen from the street."""
        return self.opening.ring
