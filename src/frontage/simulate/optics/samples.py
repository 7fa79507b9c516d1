"""Supersampling: where the samples of a pixel lie, and how those that see one face are shaded only once."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Array, Float, Int


def lattice(n: int) -> Float:
    """Return offsets (n, 2) px, -0.5..0.5, of n samples whose columns and rows all differ.

    Window edges run along pixel rows and columns. There n samples give n steps of grey, where a square grid
    gives sqrt(n). Of all rank-1 lattices, the one whose samples lie farthest apart (on the torus) is taken.
    """
    i = np.arange(n)
    best = max(range(1, n + 1), key=lambda k: (np.gcd(k, n) == 1, _spread(n, k), -k))
    return np.asarray((np.column_stack([i, i * best % n]) + 0.5) / n - 0.5)


def _spread(n: int, k: int) -> int:
    i = np.arange(1, n)
    j = i * k % n
    return int(np.min(np.minimum(i, n - i) ** 2 + np.minimum(j, n - j) ** 2, initial=2 * n * n))


@dataclass(frozen=True, eq=False)
class Groups:
    """Samples of m pixels, n each, in g groups: the samples of one pixel that have equal keys.

    order   (m n,) samples sorted by pixel, then by group
    begin   (g,) where each group starts in `order`
    share   (g,) float32, share of its pixel's samples
    first   (m,) first group of each pixel
    """

    order: Int
    begin: Int
    share: Array
    first: Int

    @property
    def pick(self) -> Int:
        """One sample (g,) of each group."""
        return np.asarray(self.order[self.begin])

    def mean(self, values: Float) -> Float:
        """Return the means (g, k) over each group of values (m n, k) per sample."""
        count = np.diff(np.append(self.begin, len(self.order)))
        return np.asarray(np.add.reduceat(values[self.order], self.begin, axis=0) / count[:, None])

    def blend(self, values: Array) -> Array:
        """Return the means (m, k) over each pixel of values (g, k) per group."""
        return np.asarray(np.add.reduceat(values * self.share[:, None], self.first, axis=0))


def group_samples(key: Array, n: int) -> Groups:
    """Group the samples of pixels, n each, by their keys (m n,)."""
    keys = key.reshape(-1, n)
    order = np.argsort(keys, axis=1, kind="stable")
    ordered = np.take_along_axis(keys, order, axis=1)
    new = np.ones(keys.shape, np.bool_)
    new[:, 1:] = ordered[:, 1:] != ordered[:, :-1]
    begin = np.flatnonzero(new)
    share = np.diff(np.append(begin, keys.size)).astype(np.float32) / np.float32(n)
    flat = (order + n * np.arange(len(keys))[:, None]).ravel()
    return Groups(flat, begin, share, np.flatnonzero(begin % n == 0))
