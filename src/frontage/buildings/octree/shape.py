"""The local shape of the surface around each cell, from the principal components of its leaves."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from frontage.buildings.octree.cells import MOMENTS, OctreeLevel
from frontage.geometry.arrays import Float


@dataclass(frozen=True, eq=False)
class LocalShape:
    """How the leaves in each cell's 3 x 3 x 3 neighbourhood lie: eigenvalues l1 >= l2 >= l3 of their scatter.

    normal     (m, 3) unit, direction of least extent
    linearity  (m,) (l1 - l2) / l1; planarity (m,) (l2 - l3) / l1; scatter (m,) l3 / l1
    support    (m,) number of leaves
    """

    normal: Float
    linearity: Float
    planarity: Float
    scatter: Float
    support: Float


def local_shape(level: OctreeLevel, touch: sparse.csr_array) -> LocalShape:
    """Computes the principal components of the leaves in every cell's 3 x 3 x 3 neighbourhood."""
    around = touch + sparse.identity(len(level), format="csr")
    centre = level.origin + (level.ijk + 0.5) * level.size
    n = around @ level.weight
    first = level.mean - centre
    moment = level.moment
    assert moment is not None
    # the moments of each cell are about its own centre; moments about one common point would lose digits
    local = centre - centre.mean(0)
    s1 = level.weight[:, None] * (local + first)
    mean = (around @ s1) / n[:, None]
    cov = np.empty((len(level), 3, 3))
    for q, (a, b) in enumerate(MOMENTS):
        w, da, db = level.weight, first[:, a], first[:, b]
        raw = moment[:, q] + w * (local[:, a] * db + local[:, b] * da + local[:, a] * local[:, b])
        cov[:, a, b] = cov[:, b, a] = (around @ raw) / n - mean[:, a] * mean[:, b]
    value, vector = np.linalg.eigh(cov)
    l3, l2, l1 = np.maximum(value, 0).T
    l1 = np.maximum(l1, 1e-12)
    return LocalShape(vector[:, :, 0], (l1 - l2) / l1, (l2 - l3) / l1, l3 / l1, n)
