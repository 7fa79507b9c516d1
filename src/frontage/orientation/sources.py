"""Which property of a scan tells most about the photos: its intensity, its colour, or its shape?

Lasers of other wavelengths see other contrasts than a camera, damp walls are dark to them, and colours from a
scanner's camera may be shifted or taken in another light. Nothing but the photos themselves can tell: control
points are looked for with every property, and the one whose points agree best with one place of the photos is
taken. A point counts by its weight, the inverse square of the spread.
"""

from collections.abc import Sequence

import numpy as np

from frontage.model import Photo, Scan
from frontage.orientation.control import all_control
from frontage.orientation.drawnwall import Similarity
from frontage.orientation.reflectance.surface import ScannedSurface, scanned_surface, sources_of
from frontage.orientation.reflectance.tones import ImageOf
from frontage.orientation.similarity import fit_similarity

_PHOTOS = 5  # that are asked
_COARSER, _RADIUS = 1.5, 12  # of the renderings, as in the last step of placing
_FEWEST = 12


def most_telling(
    photos: Sequence[Photo], surface: ScannedSurface, scan: Scan, image_of: ImageOf, seed: int
) -> ScannedSurface:
    """Returns the surface to compare photos with, which already have approximate poses in the scan.

    `surface` is one of those that the scan offers, and is not prepared again.
    """
    offered = [
        surface if kind == surface.kind else scanned_surface(scan, kind, seed) for kind in sources_of(scan)
    ]
    if len(offered) == 1 or not photos:
        return surface
    asked = [photos[k] for k in np.unique(np.linspace(0, len(photos) - 1, _PHOTOS).round().astype(int))]
    told = [_information(asked, one, image_of) for one in offered]
    return offered[int(np.argmax(told))]


def _information(photos: Sequence[Photo], surface: ScannedSurface, image_of: ImageOf) -> float:
    """The summed weight (1 / px^2) of the control points that agree with one place of the photos."""
    control = all_control(photos, surface, image_of, coarser=_COARSER, radius=_RADIUS)
    if sum(len(c) for c in control) < _FEWEST:
        return 0.0
    here = Similarity(1.0, np.eye(3), np.zeros(3))
    fitted = fit_similarity(photos, control, here)
    return fitted.count / fitted.sigma**2
