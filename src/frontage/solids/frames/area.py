"""The area that a frame and its bars cover in the plane of a window: one polygon, whose holes are the panes.

All windows are processed together, because calls of the geometry library for single ones take longer.
"""

from collections.abc import Sequence

import numpy as np
import shapely

from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.solids.brep import GRID_PER_M
from frontage.solids.frames.plan import DEPTHS_M, VERTICAL, WindowPlan, bar_boxes

_APART = 30.0  # 0.1 mm: least distance between corners and edges, three times the validator's snap tolerance
_STEEPEST_DEG = 5.0  # of the triangles of a face; the validator accepts 20 degrees between two of them
_POSE = (("R", (3, 3)), ("t", (3,)))
_SIMPLER = 5.0  # 0.1 mm: corners of a pane this close to the line between their neighbours are left out
_GROWTHS = (20.0, 40.0, 80.0)  # 0.1 mm: bars that almost touch are widened by this until they do


def frame_areas(plans: Sequence[WindowPlan], gap: float) -> list[tuple[Array, bool]]:
    """Returns for every window the polygons of frame and bars (0.1 mm), and whether all bars are in them.

    Bars are cut off at the outline, crossing bars are one polygon, and panes narrower than `gap` (0.1 mm) are
    filled. Polygons have no corner within 3 mm of another corner or edge, so that they can be extruded to
    valid solids. Bars of a layout that allows no such polygon are widened by some millimetres or, failing
    that, left out. Outer rings are counter-clockwise, holes clockwise.
    """
    if not plans:
        return []
    outlines = np.array([p.outline for p in plans], object)
    frames = np.array([p.frame for p in plans])
    clear = outlines.copy()
    poses = np.array([p.pose for p in plans], object)
    framed = frames > 0
    clear[framed] = _on_grid(shapely.buffer(outlines[framed], -frames[framed], join_style="mitre"))
    shapely.prepare(clear)
    boxes = [bar_boxes(p, c, gap) for p, c in zip(plans, clear, strict=True)]
    panes = clear
    for upright in (True, False):  # bars of one axis seldom overlap, so that two cuts replace a union
        own = [b[(p.axis == VERTICAL) == upright] for p, b in zip(plans, boxes, strict=True)]
        panes = shapely.difference(panes, _joined(own))
    areas, complete = _sound_areas(outlines, clear, _on_grid(panes), poses, gap)
    areas = shapely.orient_polygons(areas)
    parts, owner = shapely.get_parts(areas, return_index=True)
    kept = ~shapely.is_empty(parts)
    return [(parts[kept & (owner == k)], bool(complete[k])) for k in range(len(plans))]


def _on_grid(areas: Array) -> Array:
    """Rounds the corners of areas (n,) to whole numbers."""
    return np.asarray(shapely.transform(areas, np.rint))


def _joined(boxes: Sequence[Array]) -> Array:
    """Returns for every window its parallel bars as one geometry."""
    owner = np.repeat(np.arange(len(boxes)), [len(b) for b in boxes])
    joined = np.full(len(boxes), shapely.MultiPolygon(), object)
    shapely.multipolygons(np.concatenate([np.zeros(0, object), *boxes]), indices=owner, out=joined)
    overlapping = ~shapely.is_valid(joined)
    joined[overlapping] = [shapely.union_all(boxes[k]) for k in np.flatnonzero(overlapping).tolist()]
    return joined


def _sound_areas(outlines: Array, clear: Array, panes: Array, poses: Array, gap: float) -> tuple[Array, Bool]:
    """Returns the areas around the panes (n,), with wider bars or without bars where they are not sound."""
    areas = _around(outlines, panes, gap)
    sound = _are_sound(areas, poses)
    for growth in _GROWTHS:
        bad = np.flatnonzero(~sound)
        narrower = shapely.buffer(shapely.make_valid(panes[bad]), -growth, join_style="mitre")
        areas[bad] = _around(outlines[bad], _on_grid(narrower), gap)
        sound[bad] = _are_sound(areas[bad], poses[bad])
    bad = np.flatnonzero(~sound)
    areas[bad] = _around(outlines[bad], clear[bad], gap)
    areas[bad[~_are_sound(areas[bad], poses[bad])]] = shapely.Polygon()
    return areas, sound


def _around(outlines: Array, panes: Array, gap: float) -> Array:
    """Returns the outlines (n,) without their panes (n,); panes narrower than `gap` stay filled."""
    parts, owner = shapely.get_parts(panes, return_index=True)
    wide = ~shapely.is_empty(shapely.buffer(parts, -gap / 2, join_style="mitre"))
    parts, owner = shapely.simplify(parts[wide], _SIMPLER), owner[wide]
    inner = np.full(len(outlines), shapely.MultiPolygon(), object)
    shapely.multipolygons(parts, indices=owner, out=inner)  # returns nothing where no pane is left
    left = shapely.difference(outlines, shapely.make_valid(inner))
    return _without_slivers(_on_grid(left))


def _without_slivers(areas: Array) -> Array:
    """Removes the parts of areas (n,) that are too narrow for a solid."""
    parts, owner = shapely.get_parts(areas, return_index=True)
    thick = ~shapely.is_empty(shapely.buffer(parts, -_APART / 2, join_style="mitre"))
    thin = np.unique(owner[~thick])
    areas[thin] = [shapely.MultiPolygon(parts[thick & (owner == k)].tolist()) for k in thin]
    return areas


def _are_sound(areas: Array, poses: Array) -> Bool:
    """Decides for areas (n,) whether a prism over them is valid after its corners are rounded in space.

    All corners lie far enough from all others and from the edges, and no triangle is too flat.
    """
    sound = shapely.is_valid(areas) & ~shapely.is_empty(areas) & _without_touch(areas)
    sound &= shapely.minimum_clearance(areas) >= _APART
    sound[sound] = _steepest(areas[sound], poses[sound]) < _STEEPEST_DEG
    return np.asarray(sound)


def _steepest(areas: Array, poses: Array) -> Float:
    """Returns the largest tilt (n,), degrees, of the triangles of areas after rounding in space."""
    xz, owner = shapely.get_coordinates(areas, return_index=True)
    R, t = (np.array([getattr(p, name) for p in poses]).reshape(-1, *shape) for name, shape in _POSE)
    steepest = np.zeros(len(areas))
    for y in DEPTHS_M:
        flat = np.insert(xz, 1, y * GRID_PER_M, axis=1)
        grid = np.rint(np.einsum("nij,nj->ni", R[owner], flat) + t[owner] * GRID_PER_M)
        seen = np.einsum("nij,ni->nj", R[owner], grid - t[owner] * GRID_PER_M)
        rounded = shapely.set_coordinates(shapely.force_3d(areas), seen[:, [0, 2, 1]])
        parts, of = shapely.get_parts(shapely.constrained_delaunay_triangles(rounded), return_index=True)
        a, b, c = np.moveaxis(shapely.get_coordinates(parts, include_z=True).reshape(-1, 4, 3), 1, 0)[:3]
        normal = np.abs(np.cross(b - a, c - a))
        tilt = np.degrees(np.arctan2(np.hypot(normal[:, 0], normal[:, 1]), normal[:, 2]))
        np.maximum.at(steepest, of, tilt)
    return steepest


def _without_touch(areas: Array) -> Bool:
    """Decides for areas (n,) whether no two corners of their rings are the same point."""
    xz, owner = shapely.get_coordinates(areas, return_index=True)
    parts, of = shapely.get_parts(areas, return_index=True)
    rings = np.bincount(of, 1 + shapely.get_num_interior_rings(parts), len(areas))
    order = np.lexsort((xz[:, 1], xz[:, 0], owner))
    rows = np.column_stack([owner, xz])[order]
    same = (rows[1:] == rows[:-1]).all(1)
    repeated: Int = np.bincount(owner[order][1:][same], minlength=len(areas))
    return np.asarray(repeated == rings)  # every ring repeats its first corner, and no other
