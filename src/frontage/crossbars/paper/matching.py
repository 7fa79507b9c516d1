"""2-D edges of two photos, matched inside the window (paper B, section 3.3.1)."""

from dataclasses import dataclass

import numpy as np

from frontage.crossbars.paper.plane import FramePlane
from frontage.crossbars.paper.seen import SeenEdges
from frontage.geometry.arrays import Bool, Float, Int

_SEARCH_M = 0.5  # before and behind the frame's plane, where the window's reveal and its room end
_OVERLAP = 0.5  # of the shorter edge, which lies between the epipolar lines of the other's ends
_SIMILAR = 0.7  # correlation of the grey values across both edges
_SIGMAS = 3.0


@dataclass(frozen=True, eq=False)
class Matches:
    """Pairs of edges that may be one: numbers (n,) in the first and second photo, likeness (n,) -1..1."""

    first: Int
    second: Int
    likeness: Float


def match(a: SeenEdges, b: SeenEdges, plane: FramePlane) -> Matches:
    """Returns the edges of two photos that may show one edge in space.

    Both have the same sign of contrast, resemble one another across the edge, and each lies between the
    epipolar lines of the other's ends, from half a metre before the window's plane to as far behind it. An
    edge may have several partners: windows repeat themselves, and the 3-D edges decide.
    """
    likeness = _correlation(a.profile, b.profile)
    possible = (a.contrast[:, None] * b.contrast > 0) & (likeness > _SIMILAR)
    possible &= _epipolar(a, b, plane)
    first, second = np.nonzero(possible)
    return Matches(first, second, likeness[first, second])


def depth_of(a: SeenEdges, b: SeenEdges, plane: FramePlane) -> tuple[Float, Float]:
    """Returns how far behind the frame's plane pairs of edges meet, and the standard error, (na, nb) m each.

    The lines of sight to the middles meet at t = (a - b) / (ray_b - ray_a). Along the baseline (transoms in
    photos taken at one height) they are parallel and tell nothing; there the plane itself, as an observation
    with its standard error, takes over.
    """
    gap, variance, parallax = gaps(a, b)
    weight = 1 / plane.sigma**2
    information = parallax**2 / variance + weight
    return gap * parallax / variance / information, 1 / np.sqrt(information)


def gaps(a: SeenEdges, b: SeenEdges) -> tuple[Float, Float, Float]:
    """Returns a - b across on the plane, its variance, and its change per m of depth, all (na, nb)."""
    gap = a.across[:, None] - b.across
    variance = a.sigma[:, None] ** 2 + b.sigma**2 + a.shift**2 + b.shift**2
    return gap, variance, b.ray[:, 0] - a.ray[:, 0][:, None]


def _epipolar(a: SeenEdges, b: SeenEdges, plane: FramePlane) -> Bool:
    """Whether each of two edges lies between the epipolar lines of the other's ends (na, nb)."""
    gap, variance, parallax = gaps(a, b)
    reachable = np.abs(gap) <= np.abs(parallax) * _SEARCH_M + _SIGMAS * np.sqrt(variance)
    depth, _ = depth_of(a, b, plane)
    own = a.along[:, None] + (a.ray[:, 1, None] * depth)[..., None]
    other = b.along[None] + (b.ray[:, 1] * depth)[..., None]
    common = np.minimum(own[..., 1], other[..., 1]) - np.maximum(own[..., 0], other[..., 0])
    shorter = np.minimum(own[..., 1] - own[..., 0], other[..., 1] - other[..., 0])
    return np.asarray(reachable & (common >= _OVERLAP * shorter))


def _correlation(a: Float, b: Float) -> Float:
    """Returns the correlation (na, nb) of the grey values across edges (n, k)."""
    a, b = (p - p.mean(1, keepdims=True) for p in (a, b))
    a, b = (p / np.maximum(np.linalg.norm(p, axis=1, keepdims=True), 1e-9) for p in (a, b))
    return np.asarray(a @ b.T)
