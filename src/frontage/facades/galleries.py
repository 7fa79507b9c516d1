"""Tells the fronts of galleries and long balconies from walls: they are bands with free ways between them."""

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from frontage.facades.candidate import FacadeCandidate, sample_rays
from frontage.facades.scene import FacadeScene
from frontage.facades.street import crossings
from frontage.geometry.arrays import Bool
from frontage.model.masonry import MASONRY, TOLERANCES

_PIER_M = 0.5  # m: what is narrower is a post, or a wall between two flats seen from its end
_PARAPET_M = 0.8  # m: a parapet is 0.9 m high by the German model building code, and a cell may be lost
_FEWEST = 2  # parapets: one band alone is an entablature, or a balcony
_ALONG = 0.5  # share of the width that a band runs along
# share of the area between bands that piers cover, and points there for every line of sight that passes:
# frames and panes return more
_FREE = 0.1
_OFF_M = 0.3  # m off the bands: handrails, flowers


def without_galleries(
    candidates: Sequence[FacadeCandidate], scene: FacadeScene, rng: np.random.Generator
) -> list[FacadeCandidate]:
    """Drops the fronts of galleries, because they are layers of a larger wall behind them.

    Where the sensors of the points are not known, nothing is dropped.
    """
    return [
        outer
        for outer in candidates
        if not any(_are_galleries(outer, inner, scene, rng) for inner in candidates if inner is not outer)
    ]


def _are_galleries(
    outer: FacadeCandidate, inner: FacadeCandidate, scene: FacadeScene, rng: np.random.Generator
) -> bool:
    """Decides whether a front consists of bands before a larger wall that is seen freely between them."""
    depth = float((inner.wall.point - outer.wall.point) @ outer.wall.normal)
    parallel = outer.wall.normal @ inner.wall.normal > TOLERANCES.parallel_cos
    if not (parallel and MASONRY.relief < depth < MASONRY.facade_reach):
        return False
    bands = _bands(outer) if inner.cells.area >= outer.cells.area else None
    if bands is None:
        return False
    rows = sample_rays(inner.wall.inliers, rng)
    crosses, x, z = crossings(outer.wall, scene.cloud.xyz[rows], scene.sensors(rows))
    cells, q = outer.cells, outer.slab.q
    between = cells.whole & (ndimage.distance_transform_edt(~bands) * cells.cell > _OFF_M)[:, None]
    through = (crosses & cells.within(x, z, between)).sum()
    near = np.abs(q[:, 1]) < MASONRY.relief
    held = (near & cells.within(q[:, 0], q[:, 2], between)).sum()
    return bool(held < _FREE * through)


def _bands(outer: FacadeCandidate) -> Bool | None:
    """Returns which rows (h,) of cells the bands of a front fill; bands are lower than a room.

    Returns None where there are too few of them, and where anything as wide as a pier stands between them.
    """
    cells = outer.cells
    pier, room = (round(size / cells.cell) for size in (_PIER_M, MASONRY.room_height))
    q = outer.slab.q[np.abs(outer.slab.q[:, 1]) < MASONRY.step_out]
    wall = ndimage.binary_closing(cells.marked(q[:, 0], q[:, 2]), np.ones((3, 3), np.bool_))
    rows = wall.sum(1) > _ALONG * cells.whole.any(0).sum()
    labels, _ = ndimage.label(rows)
    high = np.bincount(labels)[1:]
    if (high * cells.cell >= _PARAPET_M).sum() < _FEWEST or high.max() > room:
        return None
    first, last = np.flatnonzero(rows)[[0, -1]]
    between = ~rows & (np.arange(len(rows)) > first) & (np.arange(len(rows)) < last)
    piers = ndimage.binary_opening(wall, np.ones((1, max(2, pier)), np.bool_))[between]
    return rows if piers.sum() < _FREE * cells.whole[between].sum() else None
