"""Tell the sides of bays from what only looks like one: walls of rooms behind their windows, and columns.

The surface of a side is flat, and most of it is not seen through the windows of another side, or of the face
of a bay, which is the wall parallel to the front that its sides lead to.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import ndimage

from frontage.facades.candidate import FacadeCandidate, sample_rays
from frontage.facades.cells import CellMap
from frontage.facades.layers import SortedOffsets, find_layers
from frontage.facades.outline import widest_gap
from frontage.facades.scene import FacadeScene
from frontage.facades.sequential import in_prism, is_large
from frontage.facades.street import SEEN_THROUGH, share_through
from frontage.geometry.arrays import Bool, Int
from frontage.model.masonry import MASONRY

_FILLED = 0.25  # share of its outline that a flat wall fills at least; the rest is glass
_ROUGHEST = 2.0  # times the inlier distance of the search that the one of a wall is at most


def is_flat(side: FacadeCandidate, scene: FacadeScene, least: float, size: tuple[float, float]) -> bool:
    """Decides whether a wall is flat: `least` m2 of it, as wide and as high as `size` m, lie along its plane.

    A plane through columns, or through walls that it meets at an angle, holds only strips of such a surface,
    or its points scatter more than those of walls.
    """
    if side.wall.threshold > _ROUGHEST * scene.cloud.threshold:
        return False
    q, cells = side.slab.q, side.cells
    offsets = SortedOffsets(q[:, 1], cells.flat(q[:, 0], q[:, 2]), cells.whole.size)
    along = offsets.cells(0.0, min(side.wall.threshold, scene.cloud.threshold))
    flat = cells.wall & _mask(along, cells)
    part = replace(cells, wall=flat, whole=flat)
    return is_large(part, max(least, _FILLED * float(np.prod(part.size))), size)


def faces_before(front: FacadeCandidate, scene: FacadeScene) -> list[FacadeCandidate]:
    """Returns the walls that stand parallel to a front and farther before it than its relief."""
    q = front.wall.coordinates(scene.cloud.thinned)
    q = q[in_prism(q, front, scene.options)]
    reach = (-scene.options.depth_front, scene.options.depth_back)
    flat = front.cells.flat(q[:, 0], q[:, 2])
    layers = find_layers(q[:, 1], flat, front.cells, scene.cloud.threshold / 3.0, reach)
    offsets = SortedOffsets(q[:, 1], flat, front.cells.whole.size)
    before = [layer.y for layer in layers if layer.y < -MASONRY.relief]
    return [_face(y, offsets.cells(y, scene.cloud.threshold), front) for y in before]


def _face(y: float, held: Int, front: FacadeCandidate) -> FacadeCandidate:
    """Returns the wall that the cells `held` (k,) of a front show `y` m behind its plane.

    Its windows belong to it. Where the front itself shows, there is no wall before it.
    """
    cells = front.cells
    wall = _mask(held, cells)
    wide = round(widest_gap(cells.cell) / cells.cell)
    closed = ndimage.grey_closing(np.pad(wall, wide), (wide, wide))[wide:-wide, wide:-wide]
    closed = ndimage.binary_fill_holes(closed)
    plane = replace(front.wall, point=front.wall.point + y * front.wall.normal)
    cells = replace(cells, wall=wall, whole=closed & cells.whole & ~cells.wall, shut=wall)
    return replace(front, wall=plane, cells=cells)


def is_seen_through(
    side: FacadeCandidate, walls: Sequence[FacadeCandidate], scene: FacadeScene, rng: np.random.Generator
) -> bool:
    """Decides whether most of a side was measured through one of the walls."""
    rows = sample_rays(side.wall.inliers, rng)
    xyz, sensors = scene.cloud.xyz[rows], scene.sensors(rows)
    return any(share_through(w.wall, w.cells.within, xyz, sensors) > SEEN_THROUGH for w in walls)


def _mask(flat: Int, cells: CellMap) -> Bool:
    """Returns the cells (h, w) with the numbers (k,)."""
    mask = np.zeros(cells.whole.size, np.bool_)
    mask[flat] = True
    return mask.reshape(cells.whole.shape)
