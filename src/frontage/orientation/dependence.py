"""Which errors of the observations of oriented photos may be alike, and over which distances."""

from collections.abc import Sequence

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import Photo
from frontage.orientation.adjustment import Dependence
from frontage.orientation.control import ControlPoints
from frontage.orientation.network import CONTROL, SURFACES, TIE_GROUPS
from frontage.orientation.reflectance.surface import PIECE, ScannedSurface

_TIE_TEMPLATES = 4.0  # sides of a template over which errors of tie points may be alike
_TEMPLATE_M = 0.5  # side of a template where there is no control
# Of the variance that neighbours share: light and beams come from one side on all of a wall.
_FAR = 0.01
# The scan shows an edge displaced by about this share of its spacing, depending on where the beams hit it:
# for all photos, and all along the edge. Steps in depth, which are all that shape alone has, are displaced
# more than paint, because surfaces end at the last beam and hide others from one side only. The likeliest
# values for the true errors of simulated scenes.
_EDGE, _STEP_IN_DEPTH = 0.01, 0.25


def dependence_of(
    photos: Sequence[Photo], control: Sequence[ControlPoints], surface: ScannedSurface
) -> Dependence:
    """Which errors may be alike: over a template at least, in one photo or, by the scan, in all.

    Templates that overlap see the same samples of the scan. Tie points err like others of their photo by
    what displaces larger parts of a picture. On the surface of the scan they err like those on the same flat
    piece at least. Where the scan is displaced across its surface, control points are displaced, too.
    """
    sides = [c.side * metres_per_pixel(p, c.xyz) for p, c in zip(photos, control, strict=True) if len(c)]
    reach = float(np.median(np.concatenate(sides))) if sides else _TEMPLATE_M
    by_scan, spacing = (CONTROL, SURFACES), float(np.median(surface.spacing))
    edge = _STEP_IN_DEPTH if surface.tone is None else _EDGE
    return Dependence(
        dict.fromkeys(TIE_GROUPS, _TIE_TEMPLATES * reach) | {CONTROL: reach, SURFACES: PIECE * spacing},
        own=frozenset({*TIE_GROUPS, CONTROL}),
        shared=frozenset(by_scan),
        far=dict.fromkeys(by_scan, _FAR),
        least={CONTROL: edge * spacing},
        relief=(SURFACES, CONTROL),
        # What displaces a template is mostly what lies within it; walls bulge over more than a flat piece.
        fading=frozenset({CONTROL}),
    )


def metres_per_pixel(photo: Photo, xyz: Float) -> Float:
    """Returns the size (n,) m of a pixel of a photo at points (n, 3) m."""
    depth = photo.pose.inverse.apply(xyz)[:, 2]
    return np.asarray(depth / photo.camera.params[0], np.float64)
