"""What plans share: error ellipses, by how much they are magnified, and the scale bar."""

import math
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.report.figures import nice

_QUANTILE = 2.448  # of the two-dimensional normal distribution: 95 % lie within as many sigma


@dataclass(frozen=True)
class Ellipse:
    """An error ellipse in a figure: centre and half-axes in px, angle of the longer axis in degrees."""

    x: float
    y: float
    major: float
    minor: float
    angle: float


def error_ellipse(at: Float, axes: tuple[float, float, float], scale: float) -> Ellipse:
    """The ellipse at a place (2,) px of the figure; `axes` from `half_axes`, `scale` px per metre."""
    major, minor, angle = axes
    return Ellipse(float(at[0]), float(at[1]), major * scale, minor * scale, angle)


def half_axes(C: Float) -> tuple[float, float, float]:
    """Half-axes (m) of the 95 % ellipse of a (2, 2) covariance, and the longer one's angle in the figure."""
    values, vectors = np.linalg.eigh(C)
    minor, major = _QUANTILE * np.sqrt(np.maximum(values, 0.0))
    return float(major), float(minor), float(-np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))


def magnification(length: float, shown: float) -> int:
    """The largest of 1, 2, 5, 10, 20, ... that makes `length` px no longer than `shown` px; at least 1."""
    if not (0.0 < length < shown):
        return 1
    most = shown / length * (1 + 1e-9)
    power = int(10 ** math.floor(math.log10(most)))
    return next(m * power for m in (5, 2, 1) if m * power <= most)


def scale_bar(scale: float) -> tuple[float, str]:
    """Length in px and label of a scale bar of 60 px or more, for `scale` px per metre."""
    bar = nice(max(1.0, 60.0 / scale))
    return bar * scale, f"{bar:g} m"
