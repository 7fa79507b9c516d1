"""Curved outlines as rings whose chords stay within a stated distance of the curve."""

import numpy as np

from frontage.geometry.arrays import Float


def steps(radius: float, angle: float, chord_error: float) -> int:
    """Number of chords of an arc: the sagitta ``r (1 - cos(angle / 2n))`` is at most `chord_error` (m).

    Raises ValueError when a value is not positive.
    """
    if radius <= 0 or angle <= 0 or chord_error <= 0:
        raise ValueError("radius, angle and chord error must be positive")
    half = np.arccos(max(1.0 - chord_error / radius, 0.0))
    return max(1, int(np.ceil(angle / (2 * half) - 1e-9)))


def circle_ring(x: float, z: float, radius: float, chord_error: float) -> Float:
    """A circle as a counter-clockwise ring (k, 2), its vertices on the circle."""
    count = max(4, steps(radius, 2 * np.pi, chord_error))
    turn = np.linspace(0, 2 * np.pi, count, endpoint=False)
    return np.column_stack([x + radius * np.cos(turn), z + radius * np.sin(turn)])


def arch_ring(x0: float, x1: float, z0: float, spring: float, rise: float, chord_error: float) -> Float:
    """An opening with an arch: jambs from `z0` to `spring`, and a circular arc of height `rise` above.

    ``rise = (x1 - x0) / 2`` is the round arch, less a segmental one; more is a pointed arch of two arcs
    whose centres lie on the springing line, ``r = (rise^2 + h^2) / (2 h)`` with half the width h.
    Ring (k, 2) m, counter-clockwise.

    Raises ValueError when a size is not positive.
    """
    half = (x1 - x0) / 2
    if half <= 0 or rise <= 0 or spring < z0:
        raise ValueError("an arch needs a width, a rise and its springing line above the sill")
    middle = (x0 + x1) / 2
    right = _quarter(half, rise, chord_error)
    left = right[::-1][1:] * [-1.0, 1.0]
    arch = np.concatenate([right, left]) + np.array([middle, spring])
    sill = np.array([[x0, z0], [x1, z0]])
    return np.concatenate([sill, arch]) if spring > z0 else arch


def _quarter(half: float, rise: float, chord_error: float) -> Float:
    """The right half of an arch from its springing point (half, 0) to its crown (0, rise)."""
    radius = (half * half + rise * rise) / (2 * min(half, rise))
    if rise <= half:  # centre below the crown
        first = np.arcsin(min(half / radius, 1.0))
        turn = np.linspace(first, 0.0, steps(radius, first, chord_error) + 1)
        arc = np.column_stack([radius * np.sin(turn), radius * np.cos(turn) - (radius - rise)])
    else:  # centre on the springing line
        last = np.arcsin(min(rise / radius, 1.0))
        turn = np.linspace(0.0, last, steps(radius, last, chord_error) + 1)
        arc = np.column_stack([radius * np.cos(turn) - (radius - half), radius * np.sin(turn)])
    arc[0], arc[-1] = (half, 0.0), (0.0, rise)
    return arc
