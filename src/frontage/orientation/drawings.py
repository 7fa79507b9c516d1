"""The scan as every oriented photo sees it, for a person to compare with the photo."""

from collections.abc import Sequence

import numpy as np

from frontage.geometry.arrays import Array, Bool
from frontage.model import Photo
from frontage.orientation.reflectance.render import Rendering, render, rendering_factor
from frontage.orientation.reflectance.surface import ScannedSurface
from frontage.orientation.reflectance.tones import geometry_tone
from frontage.orientation.result import Drawing
from frontage.solve.abreast import each

_SIDE_PX = 1200  # longer side, enough to look at
_ENDS = (0.01, 0.99)  # quantiles of the tone that become black and white
_DARKEST = 16  # code value, so that what was scanned is never as black as what was not


def draw_scan(photos: Sequence[Photo], surface: ScannedSurface) -> tuple[Drawing, ...]:
    """Returns what the scan looks like from photos with poses."""

    def one(photo: Photo) -> Drawing:
        longer = max(photo.camera.width, photo.camera.height)
        drawn = render(photo, surface, max(rendering_factor(photo, surface), longer / _SIDE_PX))
        return Drawing(photo.id, _picture(drawn, surface), _places(drawn))

    return tuple(each(one, photos))


def _picture(drawn: Rendering, surface: ScannedSurface) -> Array:
    tone = drawn.tone if surface.tone is not None else -geometry_tone(drawn.depth, drawn.known)[0]
    return stretched(tone, drawn.known)


def stretched(tone: Array, known: Bool) -> Array:
    """Returns log tones (h, w) as code values uint8: roots between their 1 % and 99 % quantiles."""
    if not known.any():
        return np.zeros(tone.shape, np.uint8)
    root = np.exp(0.5 * tone)
    low, high = np.quantile(root[known], _ENDS)
    share = np.clip((root - low) / max(high - low, 1e-9), 0.0, 1.0)
    return np.where(known, _DARKEST + (255 - _DARKEST) * share, 0.0).astype(np.uint8)


def _places(drawn: Rendering) -> Array:
    rows, columns = np.nonzero(drawn.known & (drawn.depth > 0))
    xyz = np.full((*drawn.known.shape, 3), np.nan, np.float32)
    xyz[rows, columns] = drawn.points(np.column_stack([columns, rows]))
    return xyz
