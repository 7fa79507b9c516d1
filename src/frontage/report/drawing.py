"""Openings and protrusions drawn on a picture of their facade, coloured by where they come from."""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.geometry.ring import box_sigmas
from frontage.model import Elements, Opening, Provenance
from frontage.report.colours import COLOURS
from frontage.report.evidence import Picture
from frontage.report.windows import bar_ring

SIGMAS = 1.96
"""Standard errors to either side of a border that are drawn: 95 %."""

_PROTRUSION = (255, 93, 177)
_FINE = 4  # binary digits of a pixel that outlines are drawn to
_WIDEST = 0.25  # of the opening's size that a band goes to either side of a border
_STRENGTH = 0.45  # of the bands of the borders' errors


def opening_picture(background: Picture, elements: Elements) -> Picture:
    """Outlines and bars on a picture of the facade; bands are 95 % errors of borders, crosses: inferred."""
    image = background.image.copy()
    x0, _, x1, z1 = background.extent
    scale = image.shape[1] / (x1 - x0)

    def pixels(ring: Float) -> Array:
        return np.asarray(np.round(((ring - (x0, z1)) * (scale, -scale) - 0.5) * 2**_FINE), np.int32)

    bands = image.copy()
    for opening in elements.openings:
        rings = [pixels(ring) for ring in error_band(opening)]
        cv2.fillPoly(bands, rings, (*COLOURS[opening.provenance][::-1], 255), cv2.LINE_AA, _FINE)
    image = cv2.addWeighted(bands, _STRENGTH, image, 1 - _STRENGTH, 0.0)
    for bar in (bar for opening in elements.openings for bar in opening.bars):
        cv2.fillPoly(
            image, [pixels(bar_ring(bar))], (*COLOURS[bar.provenance][::-1], 255), cv2.LINE_AA, _FINE
        )
    for protrusion in elements.protrusions:
        _outline(image, pixels(protrusion.ring), _PROTRUSION)
    for opening in elements.openings:
        colour = COLOURS[opening.provenance]
        _outline(image, pixels(opening.ring), colour)
        if opening.provenance is Provenance.INFERRED:
            (left, low), (right, high) = opening.ring.min(0), opening.ring.max(0)
            for diagonal in ([[left, low], [right, high]], [[left, high], [right, low]]):
                _outline(image, pixels(np.array(diagonal)), colour)
    caption = (
        "Openings: green measured, blue pooled, orange and crossed inferred (never seen); pink protrusions"
    )
    return Picture("openings", caption, image, background.extent)


def error_band(opening: Opening) -> tuple[Float, Float]:
    """The outline grown and shrunk by the 95 % errors of its borders, (k, 2) m each; unknown ones count 0.

    By no more than a quarter of its size: a border that was hardly seen must not hide the facade.
    """
    sigma = SIGMAS * np.nan_to_num(np.array(box_sigmas(opening.ring, opening.ring_covariance)), posinf=0.0)
    shown = np.minimum(sigma, _WIDEST * np.tile(np.ptp(opening.ring, axis=0), 2))
    return _moved(opening.ring, shown), _moved(opening.ring, -shown)


def _moved(ring: Float, by: Float) -> Float:
    """The ring with its box's sides moved outwards by (left, bottom, right, top) m, the rest in between."""
    low, size = ring.min(0), np.ptp(ring, axis=0)
    grown = size + by[:2] + by[2:]
    return np.asarray(low - by[:2] + (ring - low) / np.maximum(size, 1e-9) * grown)


def _outline(image: Array, ring: Array, colour: tuple[int, int, int]) -> None:
    cv2.polylines(image, [ring], True, (0, 0, 0, 255), 3, cv2.LINE_AA, _FINE)
    cv2.polylines(image, [ring], True, (*colour[::-1], 255), 1, cv2.LINE_AA, _FINE)
