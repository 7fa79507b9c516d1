"""Recesses larger than any opening: the wall between columns or piers, which lies behind their plane."""

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float, Int
from frontage.model.canonical import steady
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.evidence import SHADED, VISIBLE, Evidence
from frontage.openings.wall.raster import FITTING, opened
from frontage.openings.wall.surface import recess_depth, value_at

_CORE = 0.75  # m, least width of the core of a recess: ledges and joints join cells over less


def with_recesses(beams: Beams, evidence: Evidence, facade: Facade) -> Float | None:
    """Returns the depth (h, w) y m of the wall with large recesses at their own depth; None without any.

    Open cells that are connected over more than the size of an opening are no opening: the wall lies deeper
    there, as between the columns of a portico or the piers of a belfry. It is the surface that fills most of
    the recess, must return more beams than the frames of a glass front do, and must itself be longer than an
    opening, as far as nothing hides it: a band that returns nothing joins the windows below it, but not their
    panes. What stands before the wall (columns, capitals, the masonry of an arch) is fitted to it like any
    surround.
    """
    cells = _recesses(evidence)
    if not cells.any():
        return None
    raster, tiles = evidence.raster, beams.raster
    points = steady(beams.points)
    at = raster.flat(points[:, 0], points[:, 2])
    behind = points[:, 1] - beams.depth_at(points[:, 0], points[:, 2]) > beams.least
    inside = np.flatnonzero((at >= 0) & (cells.ravel()[at] > 0) & behind)
    if not len(inside):
        return None
    points = points[inside]
    depth = recess_depth(points, cells.ravel()[at[inside]], tiles, facade.roughness)
    off = points[:, 1] - value_at(depth, tiles, points[:, 0], points[:, 2])
    points, off = points[off > -FITTING], off[off > -FITTING]
    held = raster.count(*points[off <= beams.least][:, [0, 2]].T)
    near = raster.count(*points[off <= MASONRY.panel][:, [0, 2]].T)  # a wall may slant from its plane
    come, due = (np.bincount(cells.ravel(), m.ravel()) for m in (held, evidence.expected))
    hidden = evidence.expected < VISIBLE * evidence.expected_free
    shown = ndimage.binary_dilation(near > 0, np.ones((3, 3), np.bool_))
    walls = _longer_than_openings(cells, shown | hidden, raster.cell)
    x, z = raster.middles((cells > 0) & (walls & (come > SHADED * due))[cells]).T
    return np.where(tiles.count(x, z) > 0, depth, beams.wall) if len(x) else None


def _longer_than_openings(cells: Int, joined: Bool, cell: float) -> Bool:
    """Returns by number of recess (k,) whether cells that show its wall reach over more than any opening.

    `cells` (h, w) are the numbers of the recesses, and `joined` (h, w) the cells that show a wall or are
    hidden. Only the length counts, because the strips of a bent front are narrow. Cells are `cell` m wide.
    """
    out = np.zeros(int(cells.max()) + 1, np.bool_)
    for k, place in enumerate(ndimage.find_objects(cells), 1):
        if place is not None:
            parts, _ = ndimage.label(joined[place] & (cells[place] == k))
            sides = [(s.stop - s.start) * cell for part in ndimage.find_objects(parts) for s in part]
            out[k] = max(sides, default=0.0) > MASONRY.largest_opening
    return out


def _recesses(evidence: Evidence) -> Int:
    """Returns the number (h, w) of the recess that a cell belongs to, from 1 on; 0 outside."""
    cell = evidence.raster.cell
    open_ = evidence.is_open
    core = max(int(_CORE / cell), 2)
    cores, _ = ndimage.label(opened(open_, (core, core)))
    labels = cores.copy()
    for k, (rows, columns) in enumerate(ndimage.find_objects(cores), 1):
        high, wide = (rows.stop - rows.start) * cell, (columns.stop - columns.start) * cell
        part = labels[rows, columns]
        if MASONRY.exceeds_opening(wide, high):
            part[ndimage.binary_fill_holes(part == k)] = k
        else:
            part[part == k] = 0
    if not labels.any():
        return np.zeros(labels.shape, np.int64)
    area = np.bincount(labels.ravel())
    area[0] = 0
    labels = area.argsort(kind="stable").argsort()[labels]  # the larger of two takes what both reach
    # up to the edges of columns and ledges, which the core leaves out, but not over a pier to a window beside
    near = np.where(open_, ndimage.grey_dilation(labels, (2 * core + 1, 2 * core + 1)), labels)
    parts, _ = ndimage.label(open_ | (labels > 0))
    windows = np.setdiff1d(parts[(cores > 0) & (labels == 0)], parts[labels > 0])
    return np.where(np.isin(parts, windows), 0, near)
