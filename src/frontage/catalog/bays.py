"""Finds the bays of a facade: the columns that its openings share over all floors."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from frontage.geometry.arrays import Float, Int


def find_bays(boxes: Float, floor: Int) -> Int:
    """Returns the bay (n,) of openings with boxes (n, 4) m (x0, z0, x1, z1), counted from 1 from the left.

    Two openings on different floors share a bay when the centre line of each runs through the other. Every
    opening of the floor that has the most of them has a bay of its own. An opening that shares no bay (a shop
    front below two axes, the windows of a gable) takes the nearest bay that it overlaps, or forms a new one.
    `floor` (n,) int64.
    """
    if not len(boxes):
        return np.empty(0, np.int64)
    middle = boxes[:, ::2].mean(1)
    half = np.ptp(boxes[:, ::2], axis=1) / 2
    near = np.abs(middle[:, None] - middle) < np.minimum(half[:, None], half)
    link = coo_matrix(near & (floor[:, None] != floor))
    _, group = connected_components(link, directed=False)
    size = np.bincount(group)
    places = np.array([np.median(middle[group == g]) for g in range(len(size))])
    floors, number = np.unique(floor, return_counts=True)
    known = (size > 1) | np.isin(np.arange(len(size)), group[floor == floors[np.argmax(number)]])
    shared = np.flatnonzero(known)
    for i in np.flatnonzero(~known[group]):
        held = shared[np.abs(places[shared] - middle[i]) < half[i] + 0.25 * half[i]]
        if len(held):
            group[i] = held[np.argmin(np.abs(places[held] - middle[i]))]
    used = np.unique(group)
    order = used[np.argsort(places[used], kind="stable")]
    rank = np.zeros(len(size), np.int64)
    rank[order] = 1 + np.arange(len(order))
    return rank[group]
