"""Polygonises curved outlines: rings whose chords stay within a stated distance of the curve."""

import numpy as np

from frontage.geometry.arrays import Float


def chord_count(radius: float, angle: float, chord_error: float) -> int:
    """Returns how many chords an arc needs so that none is further than `chord_error` from it.

    The sagitta of n chords is ``r (1 - cos(angle / 2n))``; lengths in m, angle in rad. Raises ValueError if a
    value is not positive.
    """
    if radius <= 0 or angle <= 0 or chord_error <= 0:
        raise ValueError("radius, angle and chord error must be positive")
    half = np.arccos(max(1.0 - chord_error / radius, 0.0))
    return max(1, int(np.ceil(angle / (2 * half) - 1e-9)))


def circle_ring(x: float, z: float, radius: float, chord_error: float) -> Float:
    """Returns a circle as a counter-clockwise ring (k, 2) m whose vertices lie on the circle."""
    count = max(4, chord_count(radius, 2 * np.pi, chord_error))
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.column_stack([x + radius * np.cos(turn), z + radius * np.sin(turn)])


def arch_ring(x0: float, x1: float, z0: float, *, spring: float, rise: float, chord_error: float) -> Float:
    """Returns an arched opening as a counter-clockwise ring (k, 2) m (x, z).

    The jambs at `x0` and `x1` run from the sill `z0` to the springing line `spring`; the arch rises by `rise`
    above it. ``rise = (x1 - x0) / 2`` gives a round arch, less a segmental one, and more a pointed arch of
    two arcs whose centres lie on the springing line, ``r = (rise^2 + h^2) / (2 h)`` with half the width h.

    Raises ValueError if the width or the rise is not positive or the springing line lies below the sill.
    """
    half = (x1 - x0) / 2
    if half <= 0 or rise <= 0 or spring < z0:
        raise ValueError("an arch needs a width, a rise and its springing line above the sill")
    middle = (x0 + x1) / 2
    right = _half_arch(half, rise, chord_error)
    left = right[::-1][1:] * [-1.0, 1.0]
    arch = np.concatenate([right, left]) + np.array([middle, spring])
    sill = np.array([[x0, z0], [x1, z0]])
    return np.concatenate([sill, arch]) if spring > z0 else arch


def _half_arch(half: float, rise: float, chord_error: float) -> Float:
    """Returns the right half of an arch from its springing point (half, 0) to its crown (0, rise)."""
    radius = (half * half + rise * rise) / (2 * min(half, rise))
    if rise <= half:  # centre below the crown
        first = np.arcsin(min(half / radius, 1.0))
        turn = np.linspace(first, 0.0, chord_count(radius, first, chord_error) + 1)
        arc = np.column_stack([radius * np.sin(turn), radius * np.cos(turn) - (radius - rise)])
    else:  # centre on the springing line
        last = np.arcsin(min(rise / radius, 1.0))
        turn = np.linspace(0.0, last, chord_count(radius, last, chord_error) + 1)
        arc = np.column_stack([radius * np.cos(turn) - (radius - half), radius * np.sin(turn)])
    arc[0], arc[-1] = (half, 0.0), (0.0, rise)
    return arc
