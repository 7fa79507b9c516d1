"""The depth of a wall, place by place: the surface that fills much of its surroundings."""

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Array, Float, Int, distinct
from frontage.model.masonry import MASONRY
from frontage.openings.wall.gaps import between, filled
from frontage.openings.wall.raster import FITTING, TILE, WallRaster
from frontage.openings.wall.setback import is_set_back_foot, shown_at, with_set_back_tops

_FINE = 8  # cells of a tile, along and across, in which its area is counted
_KERNEL = 0.8  # m, one sigma of the surroundings that determine the depth of a tile: wider than half a window
_PEAK = 0.25  # share of the largest area that a surface needs to be the wall: glass fronts hold little wall
_ALIKE = 0.8  # share of the area of the fullest surface of a recess that another has that may be its wall
_FINEST = 0.01  # m, least bin of depths
# bins by which depths of one surface differ: a little over three, so that no rounding decides
_SAME = 3.01
_STEPS = 6  # steps of the search for the fullest layer, in its thickness
# m: the wall that a pier belongs to is that near; a recess smaller than that is no bay of the wall
_BESIDE = 1.5
_FRAMED = 0.8  # share of the tiles around a window that its frame fills
_PIER = 0.4  # share of a tile that a pier fills
_FULL = 0.6  # share of a tile that a wall which stands out fills, counted once per bin of its depth
_LARGE = 5  # tiles that such a part is wide and high at least: 1.25 m


def wall_depth(xyz: Float, raster: WallRaster, roughness: float, rays: bool = True) -> Float:
    """Returns the depth (h, w) y m of the surface that fills much of the area around each tile.

    Of several surfaces it is the one on the facade plane or nearest before it, else the first behind it:
    frames and panes lie behind the wall they belong to, balconies and bays well before it. `rays` says
    whether the lines of sight are known: without them, rooms are as full of points as walls.
    """
    own, area, y, slack = _areas(xyz, raster, roughness)
    wall = _without_recesses(_chosen(area, y, slack, rays), own, y, slack)
    stepped = _stepped(wall, own, y, slack)
    if not rays:  # only feet that are set back, and what stands out
        wall = _with_standing_parts(wall, own, y, slack)
        stepped = np.where(is_set_back_foot(stepped, slack), stepped, wall)
    wall = with_set_back_tops(stepped, own, y, slack)
    return _refined(wall, xyz, raster, slack)


def recess_depth(xyz: Float, number: Int, raster: WallRaster, roughness: float) -> Float:
    """Returns the depth (h, w) y m of the wall of recesses from the points (n, 3) m in them.

    It is the surface that fills most of the area around each tile. Columns and piers before it may be nearer
    to the facade plane, and what lies behind it and is no larger than an opening is one. Where columns stand
    before a recess, its wall goes on behind them. `number` (n,) tells the recess of every point.
    """
    own, area, y, slack = _areas(xyz, raster, roughness)
    empty = np.asarray(area.max(2) <= 0.0)
    outside = _prevailing(_numbers(xyz, number, raster), own, y, slack)
    fullest = np.where(own.any(2), filled(y[area.argmax(2)], empty), outside)
    wall = _without_framed(_without_recesses(fullest, own, y, slack), slack)
    return _refined(wall, xyz, raster, slack)


def _numbers(xyz: Float, number: Int, raster: WallRaster) -> Int:
    """Returns the largest number (h, w) of a recess with points in each tile, or in the nearest with any."""
    flat = raster.flat(xyz[:, 0], xyz[:, 2])
    held = np.zeros(raster.shape[0] * raster.shape[1])
    np.maximum.at(held, flat[flat >= 0], number[flat >= 0])
    held = held.reshape(raster.shape)
    return filled(held, held == 0).astype(np.int64)


def _prevailing(number: Int, own: Array, y: Float, slack: float) -> Float:
    """Returns the depth (h, w) m of the largest surface of the recess that each tile belongs to.

    Of surfaces that are about as large, the foremost is the wall, because panes lie behind it.
    """
    out = np.zeros(number.shape)
    for k in np.unique(number):
        held = own[number == k].sum(0)
        layer = np.array([held[np.abs(y - depth) <= slack / 2.0].sum() for depth in y])
        peak = layer >= np.maximum(np.r_[0.0, layer[:-1]], np.r_[layer[1:], 0.0])
        out[number == k] = y[peak & (layer >= _ALIKE * layer.max())][0]
    return out


def _areas(xyz: Float, raster: WallRaster, roughness: float) -> tuple[Array, Array, Float, float]:
    """Returns the area that tiles (h, w, bins) show at depths y (bins,) m, and that of their surroundings.

    Areas are counted in cells. The depths and the slack m within which depths are the same come last.
    """
    step = max(roughness, _FINEST)
    low, high = float(xyz[:, 1].min()), float(xyz[:, 1].max())
    bins = int((high - low) / step) + 2
    level = ((xyz[:, 1] - low) / step).astype(np.int64)
    flat = raster.flat(xyz[:, 0], xyz[:, 2])
    fine = WallRaster(raster.corner, TILE / _FINE, (raster.shape[0] * _FINE, raster.shape[1] * _FINE))
    kept = flat >= 0
    key = fine.flat(xyz[kept, 0], xyz[kept, 2]) * bins + level[kept]
    cell, offset = np.divmod(distinct(key), bins)  # area, not points: every cell counts once per offset
    row, column = np.divmod(cell, fine.shape[1])
    tile = row // _FINE * raster.shape[1] + column // _FINE
    held = np.bincount(tile * bins + offset, minlength=raster.shape[0] * raster.shape[1] * bins)
    own = held.reshape(*raster.shape, bins).astype(np.float32)
    wide = (_KERNEL / TILE, _KERNEL / TILE, 1.0)
    area = ndimage.gaussian_filter(own, wide, mode="constant", truncate=3.0)
    np.round(area, 3, out=area)  # so that equal areas are equal in a mirrored facade
    return own, area, np.asarray(low + (np.arange(bins) + 0.5) * step, np.float64), _SAME * step


def _chosen(area: Array, y: Float, slack: float, rays: bool) -> Float:
    """Returns the depth (h, w) m of the wall among the peaks of `area` (h, w, bins) at y (bins,) m.

    With known lines of sight, a tile beside a bay well before the plane belongs to the wall right behind the
    plane where that shows more.
    """
    peak = (area >= _PEAK * area.max(2, keepdims=True)) & (area > 0)
    peak[..., 1:-1] &= (area[..., 1:-1] >= area[..., :-2]) & (area[..., 1:-1] > area[..., 2:])
    # surfaces before the plane rank by how far they stand out; those behind it come after all of them
    rank = np.where(y <= slack, np.abs(y), 10.0 + y)
    best = np.where(peak, rank, np.inf).argmin(2)
    if rays:
        behind = np.where(peak & (y > slack) & (y <= FITTING), area, 0.0)
        shown = np.take_along_axis(area, best[..., None], 2)[..., 0]
        best = np.where((y[best] < -FITTING) & (behind.max(2) > shown), behind.argmax(2), best)
    empty = ~peak.any(2)
    if empty.all():
        return np.zeros(empty.shape)
    return filled(y[best], empty)


def _without_recesses(wall: Float, own: Array, y: Float, slack: float) -> Float:
    """Corrects the depth (h, w) m where it follows panes, gates and rooms of wide openings.

    These may be the surface with most area around, but they are neither as wide nor as high as a set-back
    part of the building. Piers between them are wall: tiles that mostly hold (`own` (h, w, bins)) the wall
    beside.
    """
    bay = int(_BESIDE / TILE) | 1  # odd: as far to the left as to the right
    panel = (ndimage.grey_closing(wall, (bay, bay)) > wall + slack) & (wall < -FITTING)
    wall = filled(wall, panel)
    beside = ndimage.minimum_filter(wall, bay)
    pier = shown_at(beside, own, y, slack).sum(2) > _PIER * own.sum(2)
    high, wide = _opened(wall)
    wall = np.where(pier & (wall > np.minimum(high, wide) + slack), beside, wall)
    return _without_openings(wall, slack)


def _without_openings(wall: Float, slack: float, narrow: int = 1) -> Float:
    """Fills the tiles (h, w) that lie deeper than those around them and are no larger than an opening.

    Parts that are fewer than `narrow` tiles wide count as openings, however high they are.
    """
    return filled(wall, wall > np.maximum(*_opened(wall, narrow)) + slack)


def _without_framed(wall: Float, slack: float) -> Float:
    """Fills the deeper parts (h, w) that have a frame of one depth all round them.

    They are windows too long for `_without_openings`, but narrower or lower than a set-back part.
    """
    labels, _ = ndimage.label(wall > np.minimum(*_opened(wall)) + slack)
    framed = np.zeros(wall.shape, np.bool_)
    for number, (rows, columns) in enumerate(ndimage.find_objects(labels), 1):
        near = tuple(slice(max(s.start - 1, 0), s.stop + 1) for s in (rows, columns))
        part = labels[near] == number
        ring = wall[near][ndimage.binary_dilation(part, np.ones((3, 3), bool)) & ~part]
        if len(ring) and np.mean(np.abs(ring - np.median(ring)) <= slack) >= _FRAMED:
            framed[near] |= part
    return filled(wall, framed)


def _stepped(wall: Float, own: Array, y: Float, slack: float) -> Float:
    """Returns the depth (h, w) m of the wall, with each step where the points of the tiles show it.

    The surroundings that determine a depth reach across a step. A tile that shows a wall further back within
    their reach (and no further than fittings are thick), and more of it than of all else, belongs to that
    wall; one that shows no wall (panes, frames) does if the tiles to the left and right do. What lies behind
    does not count where a wall fills most of the tile, for rooms are seen aslant behind piers. A tile that
    a nearer wall fills belongs to that one.
    """
    reach = int(3.0 * _KERNEL / TILE)
    # The wall further back is looked for below and beside: what leans back above a wall is a roof.
    around = (reach + 1, 2 * reach + 1)
    behind = ndimage.maximum_filter(wall, around, origin=(reach // 2, 0), mode="nearest")
    at_depth = (shown_at(depth, own, y, slack) for depth in (wall, behind))
    (held, held_most), (shown, shown_most) = ((area.sum(2), area.max(2)) for area in at_depth)
    is_full = np.maximum(held_most, shown_most) > _FINE**2 / 2
    is_wall = (np.maximum(held, shown) > own.sum(2) / 2) | is_full
    step = (behind > wall + slack) & (behind <= wall + FITTING)
    stepped = np.where(step & (shown > held) & is_wall, behind, wall)
    beside = between(stepped, is_wall)
    stepped = np.where(step & (np.abs(beside - behind) <= slack), behind, stepped)
    # panes and frames may happen to lie as deep as the wall further back
    return _without_openings(_nearer(stepped, own, y, slack), slack)


def _with_standing_parts(wall: Float, own: Array, y: Float, slack: float) -> Float:
    """Returns the depth (h, w) m of the wall with the parts that stand out before the plane at their own.

    The plane of a facade may be that of another storey, in which the bars of windows here happen to lie. What
    fills tile after tile, wider and higher than signs and shutters, hides all that lies behind it.
    """
    width = 2 * int(_SAME) + 1
    layer = ndimage.uniform_filter1d(own, width, axis=2, mode="constant") * width
    before = (y < (wall - slack)[..., None]) & (y >= (wall - MASONRY.pier)[..., None])
    layer = np.where(before, layer, 0.0)
    held = layer.max(2)
    full = (held > _FULL * _FINE**2) & (held > own.sum(2) / 2.0)
    part = ndimage.binary_opening(ndimage.binary_closing(full), np.ones((_LARGE, _LARGE), np.bool_))
    part &= full
    if not part.any():
        return wall
    out = _nearer(np.where(part, y[layer.argmax(2)], wall), own, y, slack, MASONRY.pier)
    return _without_openings(out, slack, _LARGE)


def _nearer(wall: Float, own: Array, y: Float, slack: float, most: float = FITTING) -> Float:
    """Returns the depth (h, w) m of the wall; tiles full of a wall beside them that is nearer belong to it.

    That wall stands at most `most` m before theirs.
    """
    reach = int(3.0 * _KERNEL / TILE)
    before = ndimage.minimum_filter(wall, (1, 2 * reach + 1), mode="nearest")
    shown = shown_at(before, own, y, slack)
    full = (shown.sum(2) > own.sum(2) / 2.0) & (shown.max(2) > _FINE**2 / 2)
    return np.where(full & (before < wall - slack) & (before >= wall - most), before, wall)


def _opened(wall: Float, narrow: int = 1) -> tuple[Float, Float]:
    """Removes from the map (h, w) what is lower, and what is narrower, than a set-back part of a building.

    A recess ends at the ground, whereas nothing is known of what lies beside the map. Parts that are fewer
    than `narrow` tiles wide count as low, however high they are.
    """
    size = int(MASONRY.largest_opening / TILE) | 1
    tall = min(size, (len(wall) - 1) | 1)
    high = ndimage.grey_opening(wall, (tall, narrow), mode="constant", cval=-np.inf)
    return high, ndimage.grey_opening(wall, (1, size))


def _refined(wall: Float, xyz: Float, raster: WallRaster, slack: float) -> Float:
    """Refines the depth (h, w) m of each tile to that of the fullest surface near it in the tiles around.

    Two surfaces that are nearer to one another than the slack (the masonry of a ground floor and the wall
    above it, or the bars before a window) do not mix. Tiles with few points of the wall belong to openings:
    they take the depth of the wall beside, not that of their mullions and frames.
    """
    flat = raster.flat(xyz[:, 0], xyz[:, 2])
    d = xyz[:, 1] - value_at(wall, raster, xyz[:, 0], xyz[:, 2])
    on = (flat >= 0) & (np.abs(d) <= slack)
    flat, d = flat[on], d[on]
    peak = _fullest(flat, d, raster.shape, slack)
    near = np.abs(d - peak.ravel()[flat]) <= slack / 2.0
    size = raster.shape[0] * raster.shape[1]
    number = np.bincount(flat[near], minlength=size).reshape(raster.shape).astype(np.float64)
    total = np.bincount(flat[near], d[near], minlength=size).reshape(raster.shape)
    weight = np.round(9.0 * ndimage.uniform_filter(number, 3, mode="constant"))  # whole points
    mean = 9.0 * ndimage.uniform_filter(total, 3, mode="constant") / np.maximum(weight, 1.0)
    own = wall + np.where(weight > 0, mean, 0.0)
    most = ndimage.maximum_filter(weight, 2 * int(_BESIDE / TILE) + 1)
    beside = between(own, weight >= np.round(_PIER * most, 6))
    return np.where(np.abs(beside - own) <= slack, beside, own)


def _fullest(flat: Int, d: Float, shape: tuple[int, int], slack: float) -> Float:
    """Returns the middle (h, w) m of the fullest layer, `slack` m thick, of depths d (n,) m around each tile.

    `flat` (n,) are the numbers of their tiles. Layers begin at steps of a sixth of their thickness.
    """
    step = slack / _STEPS
    level = np.clip(np.floor((d + slack) / step), 0, 2 * _STEPS - 1).astype(np.int64)
    held = np.bincount(flat * 2 * _STEPS + level, minlength=shape[0] * shape[1] * 2 * _STEPS)
    near = ndimage.uniform_filter(held.reshape(*shape, -1).astype(np.float64), (3, 3, 1), mode="constant")
    summed = np.pad(near.cumsum(2), ((0, 0), (0, 0), (1, 0)))
    layer = np.round(summed[..., _STEPS:] - summed[..., :-_STEPS], 6)
    middle = (np.arange(layer.shape[2]) - _STEPS / 2.0) * step  # of those as full, the one in the middle
    best = layer >= layer.max(2, keepdims=True)
    return np.asarray((best * middle).sum(2) / best.sum(2))


def value_at(values: Float, raster: WallRaster, x: Float, z: Float) -> Float:
    """Returns the value (n,) of the cell of each place, or of the nearest cell."""
    h, w = raster.shape
    c = np.clip((x - raster.corner[0]) / raster.cell, 0, w - 1).astype(np.int64)
    r = np.clip((z - raster.corner[1]) / raster.cell, 0, h - 1).astype(np.int64)
    return np.asarray(values.ravel()[r * w + c])
