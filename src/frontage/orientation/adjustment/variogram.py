"""By how much neighbouring errors are alike, estimated from the residuals of an adjustment.

A method of moments for variance components (Rao's MINQUE with the classes of distances as its forms). The
products of the errors of two cells are summed over all pairs in a class of distance, for pairs in one photo
and in two. The adjustment hides part of the errors, most of all those that are alike everywhere: the
expected sum is therefore computed for each structure with the residuals that it leaves. Shares that are not
negative are fitted to the sums by least squares.

Poses absorb so much of what is alike over a whole front that a large error over the longest range leaves
nearly the same residuals as a small one over a shorter range. Shares that fade with the range are therefore
fitted as well, for groups whose errors are known to do so. Of what is alike over more than all of the object
residuals tell nothing at all: such a share is left to what is stated (`Dependence.least`).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import nnls

from frontage.geometry.arrays import Array, Float, Int
from frontage.orientation.adjustment.cells import Cells
from frontage.orientation.adjustment.dependence import BEYOND, RANGES, Variogram, distances, spherical

_EDGES = (0.0, 0.75, 1.25, 1.75, 2.5, 3.5, 5.0, 8.0, 12.0, 20.0, BEYOND)
"""Of the classes of distance, in units of the reach: fine where spherical structures change."""
_FEWEST_PAIRS = 8
_MOST_CELLS = 1500  # that are asked, for the memory that their pairs take
_CUBE = 4.0  # reaches
_FULL = 4.0  # rows of a cell, from which its weight no longer grows: they err alike


def estimated_variogram(
    cells: Cells, wide: Float, reach: float, *, own: bool, shared: bool
) -> tuple[Variogram, Variogram]:
    """Estimates which shares of the errors of a group are alike.

    wide    (u, u) the inverse of the reduced normal equations
    own     whether errors may be alike in one photo, `shared` in all photos

    Returns the likeliest shares, and the likeliest of those of which no more is alike over a longer range
    than over a shorter one, and nothing over a range that is longer than the object.
    """
    some = cells.take(_asked(cells, reach))
    kinds = [k for k, wanted in enumerate((own, shared)) if wanted]
    moments = _moments(some, wide, reach, own, shared)
    # A share that fades is a sum of steps, each of which holds for its range and all shorter ones.
    steps = np.triu(np.ones((len(RANGES), len(RANGES))))
    steps = steps[:, np.array(RANGES) * reach < cells.extent]
    return _fitted(moments, kinds, np.eye(len(RANGES)), reach), _fitted(moments, kinds, steps, reach)


def _fitted(moments: tuple[Float, Float] | None, kinds: list[int], parts: Float, reach: float) -> Variogram:
    """The shares that are combinations, with no negative weight, of `parts`: shares (r,) in columns."""
    shares = np.zeros((2, len(RANGES)))
    if moments is not None and parts.size:
        combined = np.kron(parts, np.eye(len(kinds)))
        found = combined @ nnls(moments[0] @ combined, moments[1])[0]
        shares[kinds] = found.reshape(len(RANGES), len(kinds)).T
    return Variogram(shares[0], shares[1], reach)


def _asked(cells: Cells, reach: float) -> Int:
    """As many cells as there is room for: all those in some cubes, in which neighbours stay together."""
    cube = np.floor(cells.middle / (_CUBE * reach)).astype(np.int64)
    _, cube, counts = np.unique(cube, axis=0, return_inverse=True, return_counts=True)
    order = np.random.default_rng(0).permutation(len(counts))
    chosen = order[np.cumsum(counts[order]) <= max(_MOST_CELLS, counts[order[0]])]
    return np.flatnonzero(np.isin(cube.ravel(), chosen))


@dataclass(frozen=True, eq=False)
class _Structure:
    """One structure of covariance between cells (c, c), and what it makes of the gradient.

    pulled  (3 c, u) response times covariance times pull, `gradient` (u, u) covariance of the gradient
    """

    covariance: Array
    pulled: Float
    gradient: Float


def _moments(cells: Cells, wide: Float, reach: float, own: bool, shared: bool) -> tuple[Float, Float] | None:
    """Weighted equations (classes, structures) and their right-hand sides; None without any pairs."""
    apart = distances(cells.middle, cells.middle)
    same = cells.photo[:, None] == cells.photo
    alone = _structure(cells, np.diag(1.0 / cells.count))
    parts = [
        _structure(cells, spherical(apart, range_ * reach) * mask)
        for range_ in RANGES
        for mask, wanted in ((same, own), (True, shared))
        if wanted
    ]
    rows, right = [], []
    flat = cells.pull.reshape(-1, cells.pull.shape[2])
    response = cells.response.reshape(len(cells.count), 9)
    overlap, products = response @ response.T, cells.error @ cells.error.T
    length = np.square(cells.error).sum(1)
    for pairs in _classes(cells, apart / reach, same):
        lifted = (pairs @ cells.pull.reshape(len(pairs), -1)).reshape(flat.shape)
        both = flat.T @ lifted
        expected = [_expected(part, pairs * overlap, lifted, both, wide) for part in (alone, *parts)]
        weight = 1.0 / np.sqrt(max((np.square(pairs) * np.outer(length, length)).sum(), 1e-300))
        # independent errors alone would leave this in the residuals of different rows
        base = -float((both * wide).sum())
        rows.append(weight * (np.array(expected[1:]) - expected[0]))
        right.append(weight * ((pairs * products).sum() - base))
    return (np.array(rows), np.array(right)) if rows else None


def _classes(cells: Cells, apart: Float, same: Array) -> Iterator[Float]:
    """The weights (c, c) of the pairs of cells in every class of distance, in one photo and in two."""
    share = cells.count / (cells.count + _FULL)
    weight = np.outer(share, share)
    np.fill_diagonal(weight, 0.0)
    for low, high in pairwise(_EDGES):
        near = (apart >= low) & (apart < high)
        for mask in (near & same, near & ~same):
            if np.count_nonzero(mask) >= _FEWEST_PAIRS:
                yield np.where(mask, weight, 0.0)


def _structure(cells: Cells, covariance: Float) -> _Structure:
    pull = cells.count[:, None, None] * cells.pull
    spread = (covariance @ pull.reshape(len(pull), -1)).reshape(pull.shape)
    u = pull.shape[2]
    return _Structure(
        covariance, (cells.response @ spread).reshape(-1, u), pull.reshape(-1, u).T @ spread.reshape(-1, u)
    )


def _expected(part: _Structure, pairs: Float, lifted: Float, both: Float, wide: Float) -> float:
    """The expected sum over weighted pairs; `pairs` (c, c) include how the errors of both cells show."""
    absorbed = float((wide * (lifted.T @ part.pulled)).sum())
    carried = float((both * (wide @ part.gradient @ wide)).sum())
    return float((pairs * part.covariance).sum()) - 2.0 * absorbed + carried
