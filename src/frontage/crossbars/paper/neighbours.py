"""Windows that share their crossbars: similar size, same row or column (paper B, section 3.3.2)."""

from collections.abc import Sequence

import numpy as np
from scipy.sparse.csgraph import connected_components

from frontage.crossbars.paper.plane import border_sigma
from frontage.crossbars.window import Window

_SIZE = 0.04  # share of width and height by which windows of one kind differ
_SIGMAS = 3.0  # of the borders that the scan found


def neighbours(windows: Sequence[Window]) -> list[list[int]]:
    """Returns the groups of windows, as numbers, that are processed together.

    "The crossbar configuration is assumed to be equal for all windows of similar size which are located in
    the same row or column." Windows are of similar size when their shape, width and height agree; they stand
    in one row or column when their middles do.
    """
    if not windows:
        return []
    low = np.array([w.ring.min(0) for w in windows])
    high = np.array([w.ring.max(0) for w in windows])
    sigma = np.array([border_sigma(w) for w in windows])
    size, middle = high - low, (high + low) / 2
    error = _SIGMAS * np.hypot(sigma[:, None], sigma)[..., None]
    similar = (np.abs(size[:, None] - size) <= 2**0.5 * error + _SIZE * size).all(2)
    similar &= np.array([[a.opening.shape == b.opening.shape for b in windows] for a in windows])
    aligned = (np.abs(middle[:, None] - middle) <= error + _SIZE * size).any(2)
    linked = similar & aligned
    _, label = connected_components(linked | linked.T, directed=False)
    return [np.flatnonzero(label == k).tolist() for k in range(label.max() + 1)]
