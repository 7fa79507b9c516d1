"""3-D edges from matched 2-D edges, and the wrong ones rejected (paper B, section 3.3.1)."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from frontage.crossbars.paper.matching import Matches
from frontage.crossbars.paper.plane import FramePlane
from frontage.crossbars.paper.seen import SeenEdges
from frontage.geometry.arrays import Bool, Float

_SIGMAS = 3.0
_OBLIQUE = np.tan(np.radians(3.0))  # of a horizontal or vertical edge, beside what its own error explains


@dataclass(frozen=True, eq=False)
class Edges3D:
    """Edges in space along one axis of the window, in the facade frame.

    across  (n,) m: x of vertical edges, z of horizontal ones
    along   (n, 2) m, ends on the other axis, ascending
    behind  (n,) m behind the frame's plane
    sigma   (n, 2) m, standard errors of `across` and `behind`
    oblique (n, 2) m/m, slope within the plane and out of it
    error   (n, 2) m/m, standard errors of both
    misfit  (n,) distance of both lines of sight from a meeting on the plane, in standard errors
    contrast  (n,) change of the grey value to the right or upwards, mean of both photos
    pair    (n,) number of the pair of photos
    """

    across: Float
    along: Float
    behind: Float
    sigma: Float
    oblique: Float
    error: Float
    misfit: Float
    contrast: Float
    pair: Float

    def __len__(self) -> int:
        return len(self.across)

    def kept(self, mask: Bool) -> "Edges3D":
        """Returns the edges that `mask` (n,) selects."""
        return Edges3D(**{name: values[mask] for name, values in vars(self).items()})

    @staticmethod
    def joined(parts: Iterable["Edges3D"]) -> "Edges3D":
        """Returns the edges of several sets as one."""
        columns = [vars(part) for part in parts]
        return Edges3D(**{name: np.concatenate([c[name] for c in columns]) for name in columns[0]})


NO_EDGES = Edges3D(*(np.empty(s) for s in ((0,), (0, 2), (0,), (0, 2), (0, 2), (0, 2), (0,), (0,), (0,))))
"""No edges at all."""


def triangulate(a: SeenEdges, b: SeenEdges, matches: Matches, plane: FramePlane, pair: int) -> Edges3D:
    """Returns the 3-D edges of matched edges: the least-squares meeting of their planes of sight.

    On the line of sight of photo i, `across = a_i + ray_i t` at t metres behind the frame's plane. Both
    photos and t = 0 with the plane's standard error give `across` and t. The slopes of both edges on the
    plane give, in the same way, the slopes of the 3-D edge.
    """
    i, j = matches.first, matches.second
    ray = np.stack([a.ray[i, 0], b.ray[j, 0]], 1)
    low = np.maximum(a.along[i, 0], b.along[j, 0])
    high = np.minimum(a.along[i, 1], b.along[j, 1])
    middle = (low + high) / 2
    at = np.stack([_at(a, i, middle), _at(b, j, middle)], 1)
    variance = np.stack([a.sigma[i] ** 2 + a.shift**2, b.sigma[j] ** 2 + b.shift**2], 1)
    place, sigma = _meet(at, ray, variance, plane.sigma)
    slopes = np.stack([a.slope[i], b.slope[j]], 1)
    length = np.stack([np.diff(a.along[i])[:, 0], np.diff(b.along[j])[:, 0]], 1)
    # The error of the slope of a line through evenly spread points is sqrt(12) that of its place per length.
    spread = 12 * np.stack([a.sigma[i] ** 2, b.sigma[j] ** 2], 1) / length**2
    oblique, error = _meet(slopes, ray, spread, plane.sigma / np.maximum(high - low, 1e-3)[:, None])
    allowed = np.sqrt(variance.sum(1) + (np.diff(ray)[:, 0] * plane.sigma) ** 2)
    misfit = np.abs(np.diff(at)[:, 0]) / allowed
    lift = (a.ray[i, 1] + b.ray[j, 1]) / 2 * place[:, 1]
    along = np.stack([np.minimum(a.along[i, 0], b.along[j, 0]), np.maximum(a.along[i, 1], b.along[j, 1])], 1)
    return Edges3D(
        place[:, 0],
        along + lift[:, None],
        place[:, 1],
        sigma,
        oblique,
        error,
        misfit,
        (a.contrast[i] + b.contrast[j]) / 2,
        np.full(len(i), float(pair)),
    )


def _at(seen: SeenEdges, k: np.ndarray, along: Float) -> Float:
    """Returns where edges k (n,) cross the frame's plane at `along` (n,) m."""
    return np.asarray(seen.across[k] + seen.slope[k] * (along - seen.along[k].mean(1)))


def _meet(at: Float, ray: Float, variance: Float, prior: Float | float) -> tuple[Float, Float]:
    """Solves at = u - ray t for (u, t) with t = 0 +- prior; returns (n, 2) values and standard errors."""
    w = 1 / variance
    uu, ut = w.sum(1), -(w * ray).sum(1)
    tt = (w * ray**2).sum(1) + 1 / np.broadcast_to(np.asarray(prior).reshape(-1), len(at)) ** 2
    u, t = (w * at).sum(1), -(w * ray * at).sum(1)
    det = uu * tt - ut**2
    value = np.stack([tt * u - ut * t, uu * t - ut * u], 1) / det[:, None]
    return value, np.sqrt(np.stack([tt, uu], 1) / det[:, None])


def plausible(edges: Edges3D, ring: Float, axis: int) -> Bool:
    """Returns which 3-D edges (n,) may belong to a window.

    Wrong matches lead to edges outside the window, which is easy to see; of the others, only horizontal and
    vertical ones near the plane of the frame are used.

    ring  (k, 2) m, outline of the window
    axis  0 for vertical edges (across x), 1 for horizontal ones
    """
    low, high = ring[:, axis].min(), ring[:, axis].max()
    inside = (edges.across > low) & (edges.across < high)
    straight = (np.abs(edges.oblique) <= _OBLIQUE + _SIGMAS * edges.error).all(1)
    return np.asarray(inside & straight & (edges.misfit <= _SIGMAS))


def confirmed(edges: Edges3D) -> Bool:
    """Returns which 3-D edges (n,) another pair of photos found at the same place.

    Edges before and behind the frame (railings, curtains, rooms, reflections) come out at another place from
    each pair of photos that hardly sees depth.
    """
    near = np.abs(edges.across[:, None] - edges.across) <= _SIGMAS * np.hypot(
        edges.sigma[:, 0, None], edges.sigma[:, 0]
    )
    low, high = edges.along.T
    common = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
    shorter = np.minimum((high - low)[:, None], high - low)
    other = (edges.pair[:, None] != edges.pair) & (edges.contrast[:, None] * edges.contrast > 0)
    return np.asarray((near & other & (common >= 0.5 * shorter)).any(1))
