"""Find the outline of a facade: the connected component of wall cells, with its openings filled."""

import numpy as np
from scipy import ndimage

from frontage.facades.cells import CellMap
from frontage.geometry.arrays import Array, Bool, Float, Int, distinct

BESIDE_M = 0.5  # m on either side of a wall within which a volume (bush, room) shows
_GAP_M = 2.0  # m, the widest opening or shadow that a wall bridges (shop window, gate)
_GAP_CELLS = 10  # the same in cells: in a sparse cloud even wider gaps are chance
CLOSING = 1.5  # cells, radius of the disks that close a wall whose points are dense enough
_SPARSEST_M = 0.6  # m, radius of the largest disk that closes a sparse wall: points 0.5 m apart
_IN_DISK = 4.5  # points that a disk should hold: one in a hundred is empty by chance
_AROUND_M = 0.5  # m, one sigma of the surroundings that tell the density of a wall
_GATE_M = 4.0  # m, the widest notch in the border that is bridged once the component is known
_STEEP_RAD = np.radians(20.0)  # rad, more than any wall leans
_FEWEST_IN_PATCH = 4  # points that tell the depths of a patch
_THINNEST_M = 0.3  # m, narrower pieces are no wall (a strip of ground, a wire)


def occupied(x: Float, z: Float, cell: float) -> tuple[Array, tuple[float, float], Int]:
    """Counts points (n,) m per cell of a raster with a margin as wide as one gap.

    Returns the counts (h, w), the raster's corner (x, z) m on whole cells, and each point's cell (n,).
    """
    margin = int(np.ceil(widest_gap(cell) / cell)) + 2
    c0, r0 = int(np.floor(x.min() / cell)) - margin, int(np.floor(z.min() / cell)) - margin
    column = (x * (1.0 / cell) - c0).astype(np.int64)
    row = (z * (1.0 / cell) - r0).astype(np.int64)
    h, w = int(row.max()) + margin + 1, int(column.max()) + margin + 1
    flat = row * w + column
    return np.bincount(flat, minlength=h * w).reshape(h, w), (c0 * cell, r0 * cell), flat


def sloping(y: Float, count: Array, flat: Int, cell: float) -> Bool:
    """Finds the cells (h, w) whose mean offset changes with height by more than 20 degrees.

    These are roofs and ground near the plane; plinths and claddings are parallel to it and stay.

    y     (n,) m, offsets of the points from the plane
    count (h, w) points per cell; flat (n,) the cell of each point; cell m
    """
    mean = np.bincount(flat, y, minlength=count.size).reshape(count.shape) / np.maximum(count, 1)
    mean = np.where(count > 0, mean, np.nan)
    above, below = np.full_like(mean, np.nan), np.full_like(mean, np.nan)
    above[:-1], below[1:] = mean[1:], mean[:-1]
    up, down = np.abs(above - mean), np.abs(mean - below)
    steep = np.tan(_STEEP_RAD) * cell
    # A slope must show both above and below the cell; at the end of a surface its one neighbour decides.
    # An edge between two walls shows on one side only.
    one = np.where(np.isnan(up), down, up)
    both = np.fmin(np.where(np.isnan(up), one, up), np.where(np.isnan(down), one, down))
    return np.asarray(both > steep, np.bool_)


def contrast(x: Float, y: Float, z: Float, cells: CellMap, threshold: float) -> float:
    """Compares the area on the plane with the median area of equally thick slabs within 0.5 m of it.

    The ratio is large for a wall, even for one in several layers, and about 1 for a bush or a furnished room.

    x, y, z    (n,) m, facade coordinates
    threshold  m, half the thickness of a slab
    """
    slabs = max(2, round(BESIDE_M / (2.0 * threshold)) - 1)
    level = np.rint(y / (2.0 * threshold)).astype(np.int64) + slabs
    use = (level >= 0) & (level <= 2 * slabs) & cells.within(x, z)
    # area is counted: each cell counts once per slab
    held = distinct(level[use] * cells.whole.size + cells.flat(x[use], z[use])) // cells.whole.size
    area = np.bincount(held, minlength=2 * slabs + 1)
    return float(area[slabs] / max(float(np.median(np.delete(area, slabs))), 1.0))


def parallel_share(q: Float, side: float, threshold: float) -> float:
    """Returns the share of patches that show one surface parallel to a plane, at whatever depth.

    Leaves, furniture and walls that meet the plane at an angle spread over all depths within a patch.

    q          (n, 3) m, points near the plane, in its frame
    side       m, of a patch
    threshold  m, half the thickness of a surface
    """
    step = np.floor((q - q.min(0, initial=0.0)) / (side, threshold, side)).astype(np.int64)
    across, deep = step[:, 0].max(initial=0) + 1, step[:, 1].max(initial=0) + 2
    patch = step[:, 2] * across + step[:, 0]
    key, held = np.unique(patch * deep + step[:, 1], return_counts=True)
    follows = np.append(np.diff(key) == 1, False)
    both = held + np.where(follows, np.append(held[1:], 0), 0)  # a surface on the border of two slabs
    total = np.bincount(patch)
    most = np.zeros(len(total), np.int64)
    np.maximum.at(most, key // deep, both)
    known = total >= _FEWEST_IN_PATCH
    return float((2 * most > total)[known].mean()) if known.any() else 0.0


def widest_gap(cell: float) -> float:
    """Returns the width (m) of the widest gap that a wall bridges on a raster of `cell` m."""
    return max(_GAP_M, _GAP_CELLS * cell)


def largest_part(
    count: Array, corner: tuple[float, float], cell: float, votes: Float, gap: float | None = None
) -> CellMap | None:
    """Returns the connected component of occupied cells that holds the most votes, with its holes filled.

    count   (h, w) points per cell
    corner  (x, z) m of the raster
    votes   (n, 3) m, facade coordinates of points that say which component is meant; a cell counts once
    gap     m, the widest gap that is bridged; `widest_gap` when omitted

    Returns None when no piece of wall is wide enough.
    """
    gap = widest_gap(cell) if gap is None else gap
    wall = count > 0
    pruned = ndimage.binary_opening(_close_by_density(count, cell), _disk(max(_THINNEST_M / cell / 2, 1.0)))
    if not pruned.any():
        return None
    whole = ndimage.binary_fill_holes(_close(pruned, 0.5 * gap / cell))
    labels, number = ndimage.label(whole)
    if number > 1:
        voted = np.zeros_like(wall)
        row, column, inside = CellMap(corner, cell, wall, wall, wall).locate(votes[:, 0], votes[:, 2])
        voted[row[inside], column[inside]] = True
        weight = np.bincount(labels[voted], minlength=number + 1)
        weight[0] = 0
        whole = labels == int(np.argmax(weight))
    whole = ndimage.binary_fill_holes(_under_wall(whole, pruned, cell, gap))
    return CellMap(corner, cell, np.asarray(wall & whole, np.bool_), np.asarray(whole, np.bool_), wall)


def _close_by_density(count: Array, cell: float) -> Bool:
    """Closes the occupied cells by disks that hold a few points of the wall around them.

    A wall that is scanned more and more sparsely towards its end has empty cells there by chance. Disks grow
    with the distance between points, from `CLOSING` to `_SPARSEST_M`. The densest wall within a metre tells
    the density, so that nothing is closed beyond the border of a dense wall.

    count  (h, w) points per cell; cell m
    """
    asked, wall = radius_asked(count, cell), count > 0
    closed, radius, most = _close(wall, CLOSING), CLOSING, _SPARSEST_M / cell
    while radius < most:
        radius = min(2.0 * radius, most)
        closed |= _close(wall, radius) & (asked > radius / np.sqrt(2.0))
    return closed


def radius_asked(count: Array, cell: float) -> Float:
    """Returns the radius (h, w), in cells, of a disk that holds `_IN_DISK` points of the wall around it.

    count  (h, w) points per cell; cell m
    """
    dense = ndimage.gaussian_filter(count.astype(np.float64), _AROUND_M / cell)
    dense = ndimage.maximum_filter(dense, 2 * round(2.0 * _AROUND_M / cell) + 1)
    return np.asarray(np.sqrt(_IN_DISK / np.pi / np.maximum(dense, 1e-9)))


def _under_wall(whole: Bool, pruned: Bool, cell: float, gap: float) -> Bool:
    """Extends the outline over gates and shadows, but only where there is wall above: the rest is sky.

    Cells with wall on both sides are bridged: gates and shop windows of any width that have wall above them,
    and other notches up to `_GATE_M` wide, as far up as the wall's upper edge. That edge is the highest wall
    cell of every column, interpolated over columns without any, with notches as wide as a gap closed.
    """
    own = whole & pruned
    whole = whole | (at_or_below(own) & _fill_along(whole, whole.shape[1], 1))
    bridged = _fill_along(_fill_along(whole, _GATE_M / cell, 1), _GATE_M / cell, 0)
    columns = np.flatnonzero(own.any(0))
    if len(columns) == 0:
        return bridged
    top = own.shape[0] - 1 - np.argmax(own[::-1, columns], axis=0)
    edge: Array = np.interp(np.arange(own.shape[1]), columns, top)
    notch = 2 * round(0.5 * gap / cell) + 1
    edge = ndimage.grey_closing(np.pad(edge, notch, mode="edge"), (notch,))[notch:-notch]
    return np.asarray(bridged & (np.arange(own.shape[0])[:, None] <= edge), np.bool_)


def at_or_below(wall: Bool) -> Bool:
    """Returns the cells (h, w), rows upwards, that are wall or have wall above them."""
    return np.asarray(np.logical_or.accumulate(wall[::-1], 0)[::-1], np.bool_)


def _disk(radius: float) -> Bool:
    """Returns a disk of `radius` cells as a structuring element."""
    reach = int(np.ceil(radius))
    grid = np.arange(-reach, reach + 1)
    return np.asarray(np.hypot(grid[:, None], grid[None, :]) <= radius, np.bool_)


def _close(mask: Bool, radius: float) -> Bool:
    """Closes the mask by a disk of `radius` cells.

    Distance transforms make the cost independent of the radius.
    """
    grown = ndimage.distance_transform_edt(~mask) <= radius
    return np.asarray(ndimage.distance_transform_edt(grown) > radius, np.bool_)


def _fill_along(mask: Bool, reach: float, axis: int) -> Bool:
    """Sets the cells between two set ones that are at most `reach` cells apart along `axis`."""
    place = np.indices(mask.shape)[axis]
    far = sum(mask.shape) + 1 + int(reach)
    before = np.maximum.accumulate(np.where(mask, place, -far), axis=axis)
    after = np.flip(np.minimum.accumulate(np.flip(np.where(mask, place, 2 * far), axis), axis=axis), axis)
    return np.asarray(after - before <= reach + 1, np.bool_)
