"""Smooths clouds so noisy that only neighbours together tell a reveal from the wall."""

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Float, drawn
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY, TOLERANCES
from frontage.model.scan import Scan

_HALF_WAY = 0.035  # m: half a quarter of a brick, the least depth that is a recess and no relief
_SIGMAS = 3.0  # of the noise of a point, within which all points of a surface lie
_MEDIAN = np.pi / 2.0  # how many times more points a median needs than a mean
_SAMPLE = 20_000  # points that tell the noise
_AROUND = 12  # neighbours that tell the noise at a point
_TO_SIGMA = 1.4826 * np.sqrt(_AROUND / (_AROUND - _MEDIAN))  # of deviations from the median of so many
_FURTHER = 3  # times the neighbours wanted: at an edge half of them lie on another surface, at a corner more
_AT_ONCE = 100_000  # points that are smoothed at a time


def smoothed(facade: Facade, scan: Scan) -> tuple[Facade, Scan]:
    """Returns a facade and its working cloud with less noise, or both as they are.

    A point tells on which side of half a recess's least depth it lies if that is three sigmas of its noise.
    Where the noise is larger, every point of the facade moves to the median depth of its neighbours on the
    same surface, of as many as bring the noise down to that. It moves straight, for a point of a reveal that
    followed its line of sight to the depth of the wall would lie within the opening.
    """
    if _SIGMAS * facade.roughness <= _HALF_WAY:
        return facade, scan
    q = facade.frame.inverse.apply(np.take(scan.xyz, facade.support, axis=0))
    near = np.flatnonzero(np.abs(q[:, 1]) < MASONRY.facade_reach)
    if len(near) < _AROUND:
        return facade, scan
    noise = _noise(q[near])
    number = int(np.ceil(_MEDIAN * (_SIGMAS * noise / _HALF_WAY) ** 2))
    if _SIGMAS * noise <= _HALF_WAY:
        return facade, scan
    q[near, 1] = _medians(q[near], number, noise)
    xyz = scan.xyz.copy()
    xyz[facade.support] = facade.frame.apply(q)
    left = max(noise * np.sqrt(_MEDIAN / number), TOLERANCES.least_on_wall / _SIGMAS)
    return replace(facade, roughness=min(left, facade.roughness)), replace(scan, xyz=xyz)


def _noise(q: Float) -> float:
    """Returns the robust sigma m of the depths of points q (n, 3) m about their neighbours' median."""
    seeds = q[drawn(np.abs(q), _SAMPLE)]  # the same in a mirrored cloud
    # few questions: a tree that is quick to build
    tree = cKDTree(q[:, ::2], balanced_tree=False, compact_nodes=False)
    near = tree.query(seeds[:, ::2], min(_AROUND, len(q)))[1]
    off = seeds[:, 1] - np.median(q[near, 1], axis=1)
    return float(_TO_SIGMA * np.median(np.abs(off)))


def _medians(q: Float, number: int, noise: float) -> Float:
    """Returns the median depth (n,) m of the `number` nearest points of one surface around points q (n, 3) m.

    Depths on one surface differ by three sigmas of the difference of two points at most.
    """
    tree, many = cKDTree(q[:, ::2]), min(_FURTHER * number, len(q))
    out = np.empty(len(q))
    for start in range(0, len(q), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        depth = q[tree.query(q[part, ::2], many)[1].reshape(-1, many), 1]
        same = np.abs(depth - q[part, 1:2]) <= _SIGMAS * np.sqrt(2.0) * noise
        same &= np.cumsum(same, axis=1) <= number
        depth, held = np.sort(np.where(same, depth, np.inf), axis=1), same.sum(1, keepdims=True)
        middle = np.hstack([(held - 1) // 2, held // 2])
        out[part] = np.take_along_axis(depth, middle, 1).mean(1)
    return out
