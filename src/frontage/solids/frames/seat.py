"""Seats the frames and bars of windows on the surfaces of their openings in the finished solids."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float
from frontage.geometry.plane import facade_axes
from frontage.geometry.rigid import Rigid3
from frontage.model import Elements, Facade, Face, Glazing, Solid, WorldRef
from frontage.solids.brep import GRID_PER_M, newell_normal, rings_of
from frontage.solids.frames.area import frame_areas
from frontage.solids.frames.extrude import extruded
from frontage.solids.frames.plan import DEPTHS_M, HORIZONTAL, VERTICAL, WindowPlan
from frontage.solids.options import BuildOptions
from frontage.solids.relief import Built

_THINNEST_BAR_M = 0.005  # a bar narrower than this is no bar


@dataclass(frozen=True, eq=False)
class WindowFrame:
    """The frame of an opening with its bars, or one piece of them where they do not hang together.

    id       "B07/F1/W1-1/frame", further pieces "B07/F1/W1-1/frame-2"
    solid    closed; its front is the first face, its back the second one, faces have no semantic class
    around   whether the frame goes round the opening; else there are bars only
    """

    id: str
    opening: str
    facade: str
    solid: Solid
    around: bool = True


@dataclass(frozen=True, eq=False)
class _Seat:
    """The surface of an opening: its pose, whose plane y = 0 it is, and its polygon (x, z) in 0.1 mm."""

    pose: Rigid3
    outline: BaseGeometry


def window_frames(
    built: Sequence[Built], fronts: Sequence[tuple[Facade, Elements]], world: WorldRef, options: BuildOptions
) -> tuple[list[WindowFrame], list[str]]:
    """Returns the frames and bars of all openings that have a surface in the solids, with notes.

    The frame follows the surface as it was projected, joined and clipped for the solid, and reaches from the
    surface back into the building by the usual thickness; bars are projected along its normal. An opening
    without a measured frame gets its bars alone.
    """
    if not (options.bars and options.depth):
        return [], []
    known = {
        o.id: (o, facade)
        for facade, elements in fronts
        for o in elements.openings
        if o.glazing is not None and (o.glazing.frame_width is not None or o.glazing.bars)
    }
    found = [(*known[name], seat) for b in built for name, seat in _seats(b.solid, known)]
    plans = [_plan(seat, facade.frame, o.glazing) for o, facade, seat in found if o.glazing]
    frames: list[WindowFrame] = []
    notes: list[str] = []
    areas = frame_areas(plans, options.gap * GRID_PER_M)
    for (opening, facade, seat), plan, (polygons, complete) in zip(found, plans, areas, strict=True):
        if not complete:
            what = "the bars of its layout" if len(polygons) else "its frame and bars"
            notes.append(f"{opening.id}: {what} are not drawn, because they make no valid solid")
        for k, polygon in enumerate(polygons):
            name = f"{opening.id}/frame" + (f"-{k + 1}" if k else "")
            solid = extruded(name, polygon, seat.pose, DEPTHS_M, world.origin)
            frames.append(WindowFrame(name, opening.id, facade.id, solid, plan.frame > 0))
    return frames, notes


def _seats(solid: Solid, names: Collection[str]) -> Iterator[tuple[str, _Seat]]:
    """Yields the surfaces of the openings with these names; faces of one opening are joined."""
    own: dict[str, list[Face]] = {}
    for face in solid.faces:
        if face.opening in names:
            own.setdefault(str(face.opening), []).append(face)
    for name, faces in own.items():
        xyz = [[solid.vertices[list(r)] / GRID_PER_M for r in rings_of(f)] for f in faces]
        pose = Rigid3("local", "window", facade_axes(-newell_normal(xyz[0][0])), xyz[0][0][0])
        flat = [[_on_grid((ring - pose.t) @ pose.R) for ring in rings] for rings in xyz]
        polygons = [shapely.Polygon(outer, holes) for outer, *holes in flat]
        yield name, _Seat(pose, polygons[0] if len(polygons) == 1 else shapely.union_all(polygons))


def _on_grid(xyz: Float) -> Float:
    return np.rint(xyz[:, [0, 2]] * GRID_PER_M)


def _plan(seat: _Seat, facade: Rigid3, glazing: Glazing) -> WindowPlan:
    """Projects the bars of a window along the normal of its surface."""
    bars = [b for b in glazing.bars if b.width >= _THINNEST_BAR_M]
    upright = np.array([b.axis == "vertical" for b in bars], np.bool_)
    along = np.array([b.extent for b in bars]).reshape(-1, 2)
    across = np.repeat(np.array([b.position for b in bars]), 2).reshape(-1, 2)
    xz = np.where(upright[:, None, None], np.stack([across, along], 2), np.stack([along, across], 2))
    local = xz.reshape(-1, 2) @ facade.R[:, [0, 2]].T + facade.t
    ends = ((local - seat.pose.t) @ seat.pose.R[:, [0, 2]]).reshape(-1, 2, 2) * GRID_PER_M
    rows = np.arange(len(bars))
    axis = np.where(upright, VERTICAL, HORIZONTAL)
    frame = 0.0 if glazing.frame_width is None else max(0.0, float(glazing.frame_width.value))
    return WindowPlan(
        seat.pose,
        seat.outline,
        frame * GRID_PER_M,
        axis,
        ends[rows, :, axis].mean(1),
        np.sort(ends[rows, :, 1 - axis], axis=1),
        np.array([b.width for b in bars]) * GRID_PER_M,
    )
