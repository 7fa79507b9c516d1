"""Layouts of the same wall on several rasters compete, so that the place of its cells decides nothing.

Whether a narrow pier shows depends on where the borders of cells cut it. What one raster misses, others find.
"""

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float, Int
from frontage.openings.boxes import Box
from frontage.openings.layout.candidates import find_boxes
from frontage.openings.layout.framing import Framing
from frontage.openings.layout.posts import Post
from frontage.openings.layout.selection import PRICE, best_apart, worth_of
from frontage.openings.options import OpeningOptions
from frontage.openings.wall.evidence import Evidence
from frontage.openings.wall.raster import summed

_HALF = 0.5  # share of a rectangle that a layout covers if it tells of an opening there
_DIGITS = 6  # of nats: sums in another order differ by less, and must not choose between equal rectangles
_ALIKE = 0.5  # share of their union that two rectangles have in common if they are the same opening


def find_on_rasters(
    evidences: Sequence[Evidence],
    options: OpeningOptions,
    ground: float,
    posts: Sequence[Post] = (),
    densest: float = np.inf,
) -> list[tuple[Box, float]]:
    """Returns the rectangles that may be openings, and their worth in nats, row by row.

    `evidences` are those of one wall on several rasters; `ground` is the height z m of the ground; `posts`
    part openings. The best layouts of all rasters are one set of rectangles, of which those count that are in
    most of them. Their worth is the mean over the rasters, and the set without overlap that is worth most is
    the result. Parts of the wall are left out where all cells would hold `densest` beams or more.
    """
    layouts = [_layout(evidence, options, ground, posts, densest) for evidence in evidences]
    boxes = _told_by_most(layouts)
    worth = np.mean([_worth(boxes, evidence) for evidence in evidences], axis=0)
    boxes, worth = boxes[worth > 0.0], worth[worth > 0.0]
    chosen = best_apart(worth, _overlapping(boxes))
    chosen = chosen[np.lexsort((boxes[chosen, 0], boxes[chosen, 1]))]
    return [((x0, z0, x1, z1), w) for x0, z0, x1, z1, w in np.column_stack([boxes, worth])[chosen].tolist()]


def _told_by_most(layouts: Sequence[Float]) -> Float:
    """Returns the boxes (n, 4) of all layouts that are in most of them.

    Where most layouts tell of an opening and each of another one, all of these count.
    """
    boxes, most = np.concatenate(layouts), len(layouts) / 2
    told = np.sum([_covered(boxes, layout) > _HALF for layout in layouts], axis=0) > most
    agreed = np.sum([_like(boxes, layout) for layout in layouts], axis=0) > most
    rivals = (shared_areas(boxes, boxes) > 0.0) & agreed
    return np.asarray(boxes[agreed | (told & ~rivals.any(1))])


def _layout(
    evidence: Evidence, options: OpeningOptions, ground: float, posts: Sequence[Post], densest: float
) -> Float:
    """Returns the best layout (n, 4) x0, z0, x1, z1 m of rectangles on one raster."""
    found = find_boxes(evidence, options, Framing(evidence, ground, posts), posts, densest)
    return np.array([evidence.raster.box(b.r0, b.c0, b.r1, b.c1) for b in found]).reshape(-1, 4)


def shared_areas(boxes: Float, others: Float) -> Float:
    """Returns the areas (n, m) m2 that boxes (n, 4) share with others (m, 4)."""
    low = np.maximum(boxes[:, None, :2], others[None, :, :2])
    high = np.minimum(boxes[:, None, 2:], others[None, :, 2:])
    return np.asarray(np.clip(high - low, 0.0, None).prod(2))


def _covered(boxes: Float, layout: Float) -> Float:
    """Returns the share (n,) of the area of boxes (n, 4) that the boxes (m, 4) of a layout cover."""
    return np.asarray(shared_areas(boxes, layout).sum(1) / _area(boxes))


def _like(boxes: Float, layout: Float) -> Bool:
    """Returns which boxes (n, 4) are the same as one of the boxes (m, 4) of a layout."""
    common = shared_areas(boxes, layout)
    union = _area(boxes)[:, None] + _area(layout) - common
    return np.asarray((common > _ALIKE * union).any(1))


def _area(boxes: Float) -> Float:
    """Returns the areas (n,) m2 of boxes (n, 4)."""
    return np.asarray((boxes[:, 2:] - boxes[:, :2]).prod(1))


def _overlapping(boxes: Float) -> Int:
    """Returns the pairs (2, k) of boxes (n, 4) that overlap, the lower number first."""
    return np.stack(np.nonzero(np.triu(shared_areas(boxes, boxes) > 0.0, 1)))


def _worth(boxes: Float, evidence: Evidence) -> Float:
    """Returns the nats (n,) that boxes (n, 4) m are worth as openings by the evidence of one raster.

    Cells that a box covers in part count in part: sums below and left of places between cells are linear.
    """
    raster = evidence.raster
    total = summed(worth_of(evidence, (slice(None), slice(None))))
    c0, r0, c1, r1 = ((boxes - np.array(raster.corner * 2)) / raster.cell).T
    below = [ndimage.map_coordinates(total, at, order=1, mode="nearest") for at in ((r0, c0), (r0, c1))]
    above = [ndimage.map_coordinates(total, at, order=1, mode="nearest") for at in ((r1, c0), (r1, c1))]
    return np.asarray(np.round(above[1] - above[0] - below[1] + below[0], _DIGITS) - PRICE)
