"""The facade's raster of cells: which are seen wall, which connected part is the facade, its outline."""

from dataclasses import dataclass, replace

import numpy as np
import shapely
from scipy import ndimage
from shapely.geometry import Polygon

from frontage.geometry.arrays import Array, Bool, Float, Int, distinct
from frontage.geometry.ring import cells_ring, polygon_ring

_GAP = 2.0  # m: the widest opening or shadow that a wall bridges (shop window, gate)
_GAP_CELLS = 10  # and as many cells: a wider gap in a sparse cloud is chance
_GATE = (
    4.0  # m: the widest notch in the border that is bridged once the part is known (gate, shadow of a tree)
)
_STEEP = np.radians(20.0)  # no wall leans so much
BESIDE = 0.5  # m beside a wall in which a volume shows
_THINNEST = 0.3  # m: what is thinner is no wall (a strip of ground, a wire)


@dataclass(frozen=True, eq=False)
class CellMap:
    """Cells (h, w) of a facade: row r, column c covers `corner + cell * (c, r)` .. + cell, in (x, z) m.

    wall   cells with points on the plane, of the chosen part only
    whole  cells of the outline: the wall with its openings
    shut   cells with points on the wall or in front of it: what no line of sight passes
    """

    corner: tuple[float, float]
    cell: float
    wall: Bool
    whole: Bool
    shut: Bool

    @property
    def area(self) -> float:
        """m2 of seen wall."""
        return float(self.wall.sum()) * self.cell**2

    @property
    def coverage(self) -> float:
        """Share of the outline with points on the wall."""
        return float((self.wall & self.whole).sum() / max(self.whole.sum(), 1))

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in m of the outline."""
        rows, columns = np.flatnonzero(self.whole.any(1)), np.flatnonzero(self.whole.any(0))
        if len(rows) == 0:
            return 0.0, 0.0
        return float(np.ptp(columns) + 1) * self.cell, float(np.ptp(rows) + 1) * self.cell

    @property
    def outline(self) -> Float:
        """Ring (k, 2) m of the outline, through the middles of the border cells, which are half filled."""
        ring = cells_ring(self.whole, self.corner, self.cell, 0.75 * self.cell)
        inner = Polygon(ring).buffer(-0.5 * self.cell, join_style="mitre")
        parts = [part for part in shapely.get_parts(inner) if isinstance(part, Polygon)]
        return polygon_ring(max(parts, key=lambda part: float(part.area))) if parts else ring

    def marked(self, x: Float, z: Float) -> Bool:
        """Raster (h, w): the cells of the outline that hold at least one of the points (n,)."""
        mask = np.zeros(self.whole.size, np.bool_)
        mask[self.flat(x, z)] = True
        return mask.reshape(self.whole.shape) & self.whole

    def flat(self, x: Float, z: Float) -> Int:
        """Cell number (n,) of points (n,), row by row; points outside get the nearest border cell,
        which is in no outline (the raster has a margin).
        """
        h, w = self.wall.shape
        column = ((x - self.corner[0]) * (1.0 / self.cell)).astype(np.int64)
        row = ((z - self.corner[1]) * (1.0 / self.cell)).astype(np.int64)
        np.clip(column, 0, w - 1, out=column)
        np.clip(row, 0, h - 1, out=row)
        row *= w
        row += column
        return row

    def shrunk(self, border: float) -> Bool:
        """The cells (h, w) of the outline that are further than `border` m from what is not."""
        return np.asarray(ndimage.distance_transform_edt(self.whole) * self.cell > border, np.bool_)

    def moved(self, x: float, z: float) -> "CellMap":
        """The same cells, counted from the point (x, z) m."""
        return replace(self, corner=(self.corner[0] - x, self.corner[1] - z))

    @property
    def mirrored(self) -> "CellMap":
        """The same cells seen from the other side: x changes sign."""
        corner = (-self.corner[0] - self.wall.shape[1] * self.cell, self.corner[1])
        return CellMap(corner, self.cell, self.wall[:, ::-1], self.whole[:, ::-1], self.shut[:, ::-1])

    def locate(self, x: Float, z: Float) -> tuple[Int, Int, Bool]:
        """Row, column (clipped) and whether inside the raster, of points (n,)."""
        column = np.floor((x - self.corner[0]) / self.cell).astype(np.int64)
        row = np.floor((z - self.corner[1]) / self.cell).astype(np.int64)
        h, w = self.wall.shape
        inside = (row >= 0) & (row < h) & (column >= 0) & (column < w)
        return np.clip(row, 0, h - 1), np.clip(column, 0, w - 1), inside

    def within(self, x: Float, z: Float, mask: Bool | None = None) -> Bool:
        """Whether points (n,) fall on a cell that is set in `mask` (the outline when omitted)."""
        return np.asarray(
            (self.whole if mask is None else mask & self.whole).ravel()[self.flat(x, z)], np.bool_
        )


def occupied(x: Float, z: Float, cell: float) -> tuple[Array, tuple[float, float], Int]:
    """Number of points per cell (h, w) with a margin of one gap, the raster's corner (x, z) m on whole
    cells, and every point's cell (n,).
    """
    margin = int(np.ceil(widest_gap(cell) / cell)) + 2
    c0, r0 = int(np.floor(x.min() / cell)) - margin, int(np.floor(z.min() / cell)) - margin
    column = (x * (1.0 / cell) - c0).astype(np.int64)
    row = (z * (1.0 / cell) - r0).astype(np.int64)
    h, w = int(row.max()) + margin + 1, int(column.max()) + margin + 1
    flat = row * w + column
    return np.bincount(flat, minlength=h * w).reshape(h, w), (c0 * cell, r0 * cell), flat


def sloping(y: Float, count: Array, flat: Int, cell: float) -> Bool:
    """Cells (h, w) where the surface is no wall: its mean offset changes with height by more than 20 degrees.

    Roofs and ground near the plane; plinths and claddings are parallel to it.
    """
    mean = np.bincount(flat, y, minlength=count.size).reshape(count.shape) / np.maximum(count, 1)
    mean = np.where(count > 0, mean, np.nan)
    above, below = np.full_like(mean, np.nan), np.full_like(mean, np.nan)
    above[:-1], below[1:] = mean[1:], mean[:-1]
    up, down = np.abs(above - mean), np.abs(mean - below)
    steep = np.tan(_STEEP) * cell
    # on both sides, or at the end of the surface on the one there is: an edge between two walls is one-sided
    one = np.where(np.isnan(up), down, up)
    both = np.fmin(np.where(np.isnan(up), one, up), np.where(np.isnan(down), one, down))
    return np.asarray(both > steep, np.bool_)


def contrast(x: Float, y: Float, z: Float, cells: CellMap, threshold: float) -> float:
    """Area on the plane over the median area of equally thick slabs to half a metre on both sides: a wall
    has much, even one in several layers; a bush or a furnished room has about 1.

    x, y, z    (n,) m, facade coordinates; threshold m, half the thickness of a slab
    """
    slabs = max(2, round(BESIDE / (2.0 * threshold)) - 1)
    level = np.rint(y / (2.0 * threshold)).astype(np.int64) + slabs
    use = (level >= 0) & (level <= 2 * slabs) & cells.within(x, z)
    # area is counted: a cell once per slab
    held = distinct(level[use] * cells.whole.size + cells.flat(x[use], z[use])) // cells.whole.size
    area = np.bincount(held, minlength=2 * slabs + 1)
    return float(area[slabs] / max(float(np.median(np.delete(area, slabs))), 1.0))


def widest_gap(cell: float) -> float:
    """The widest gap in m that a wall on a raster of `cell` m bridges."""
    return max(_GAP, _GAP_CELLS * cell)


def _disk(radius: float) -> Bool:
    reach = int(np.ceil(radius))
    grid = np.arange(-reach, reach + 1)
    return np.asarray(np.hypot(grid[:, None], grid[None, :]) <= radius, np.bool_)


def _close(mask: Bool, radius: float) -> Bool:
    """Closing by a disk of `radius` cells, by distance transforms (cost independent of the radius)."""
    grown = ndimage.distance_transform_edt(~mask) <= radius
    return np.asarray(ndimage.distance_transform_edt(grown) > radius, np.bool_)


def _fill_along(mask: Bool, reach: float, axis: int) -> Bool:
    """Set the cells between two set ones that are at most `reach` cells apart along `axis`."""
    place = np.indices(mask.shape)[axis]
    far = sum(mask.shape) + 1 + int(reach)
    before = np.maximum.accumulate(np.where(mask, place, -far), axis=axis)
    after = np.flip(np.minimum.accumulate(np.flip(np.where(mask, place, 2 * far), axis), axis=axis), axis)
    return np.asarray(after - before <= reach + 1, np.bool_)


def largest_part(
    count: Array, corner: tuple[float, float], cell: float, votes: Float, gap: float | None = None
) -> CellMap | None:
    """The connected part with the most votes, gaps up to `gap` m bridged (`widest_gap`), its holes filled;
    None when empty.

    votes (n, 3) m: facade coordinates of points that say which part is meant; a cell counts once.
    """
    gap = widest_gap(cell) if gap is None else gap
    wall = count > 0
    pruned = ndimage.binary_opening(_close(wall, 1.5), _disk(max(_THINNEST / cell / 2, 1.0)))
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


def _under_wall(whole: Bool, pruned: Bool, cell: float, gap: float) -> Bool:
    """The outline with gates and shadows bridged, as far as there is wall above: what has none is sky.

    Cells between wall on both sides (at most `_GATE` m) are bridged, below the wall's upper edge. That
    edge is the highest wall cell of every column, interpolated over columns without any; its notches of a
    gap's width are closed.
    """
    bridged = _fill_along(_fill_along(whole, _GATE / cell, 1), _GATE / cell, 0)
    own = whole & pruned
    columns = np.flatnonzero(own.any(0))
    if len(columns) == 0:
        return bridged
    top = own.shape[0] - 1 - np.argmax(own[::-1, columns], axis=0)
    edge: Array = np.interp(np.arange(own.shape[1]), columns, top)
    notch = 2 * round(0.5 * gap / cell) + 1
    edge = ndimage.grey_closing(np.pad(edge, notch, mode="edge"), (notch,))[notch:-notch]
    return np.asarray(bridged & (np.arange(own.shape[0])[:, None] <= edge), np.bool_)
