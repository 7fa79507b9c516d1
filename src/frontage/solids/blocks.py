"""The host where there is no city model: a block behind the facades that were measured.

One facade gives a block with its own upper outline. Several give an upright block: in plan every facade is
pulled into the building, neighbours are lengthened to the corner where their planes meet, and what lies
before a facade that looks another way is cut off.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import LineString, MultiPoint, Polygon
from shapely.geometry.base import BaseGeometry

from frontage.geometry.arrays import Float
from frontage.model import Facade, Failed, Surface, WorldRef
from frontage.solids.host import Host, facade_block, ground_block
from frontage.solids.relief import GRID

_CORNER = 1.5  # m: facades whose ends are this close to where their planes meet, meet there
_PARALLEL = 0.3  # sine between planes that have no corner
_LEVEL = 0.3  # m: an upper outline that varies by less is level; what a raster of cells and a gutter make
_STEP = 0.1  # m: columns in which the upper outline is looked up
_SLIT = 0.5  # m: half of the gap between blocks that is closed
_FOOT = 3.0  # m: an outline that ends so far above the ground was hidden below, not in the air


def cloud_blocks(
    building: str, facades: Sequence[Facade], ground_z: float, depth: float, world: WorldRef
) -> tuple[Host, ...] | Failed:
    """Closed blocks, `depth` m deep, behind a building's facades; `ground_z` m local, nan = not known."""
    if not facades:
        return Failed("S305", f"{building}: no facade, so there is nothing to make a block from")
    if len(facades) == 1:
        facade = facades[0]
        made = facade_block(building, facade.frame, clean_outline(facade, ground_z), depth, world)
        return made if isinstance(made, Failed) else (made,)
    outlines = [_in_space(f, clean_outline(f, ground_z)) for f in facades]
    low, high = (
        pick([o[:, 2].max() if pick is max else o[:, 2].min() for o in outlines]) for pick in (min, max)
    )
    hosts = []
    for polygon in _plan(facades, depth):
        rings = [
            np.insert(np.asarray(r.coords)[:-1], 2, low, axis=1)
            for r in (polygon.exterior, *polygon.interiors)
        ]
        made = ground_block(building, [Surface(rings[0], "GroundSurface", "", tuple(rings[1:]))], world, high)
        if isinstance(made, Failed):
            return made
        note = (
            f"{building}: no city model; a block of {depth:g} m behind {len(facades)} facades stands for it"
        )
        hosts.append(Host(made.solid, (note, *made.notes[1:])))
    return tuple(hosts)


def clean_outline(facade: Facade, ground_z: float) -> Float:
    """The facade's outline (k, 2) m (x, z) as a building has it: upright sides, a level foot, its roof line.

    The upper outline loses what is smaller than 0.3 m; the foot is the ground, where that is known and near.
    """
    polygon = shapely.make_valid(Polygon(facade.outline))
    x0, foot, x1, top = polygon.bounds
    ground = _ground(facade, ground_z)
    if np.isfinite(ground) and foot - _FOOT < ground:
        foot = min(foot, ground)
    x = np.linspace(x0, x1, max(2, int(np.ceil((x1 - x0) / _STEP)) + 1))
    inside = np.clip(x, x0 + 1e-3, x1 - 1e-3)
    columns = shapely.linestrings([[(v, foot - 1), (v, top + 1)] for v in inside])
    upper = shapely.bounds(shapely.intersection(columns, polygon))[:, 3]
    known = np.isfinite(upper)
    x, upper = x[known], upper[known]
    if np.ptp(upper) <= _LEVEL:
        line = np.array([[x0, upper.max()], [x1, upper.max()]])
    else:
        line = np.asarray(LineString(np.column_stack([x, upper])).simplify(_LEVEL).coords)
        line[[0, -1], 0] = x0, x1
    return np.concatenate([[[x0, foot], [x1, foot]], line[::-1]])


def _ground(facade: Facade, ground_z: float) -> float:
    """The ground's height in the facade frame, m."""
    return float((ground_z - facade.frame.t[2]) / facade.frame.R[2, 2])


def _in_space(facade: Facade, ring: Float) -> Float:
    return facade.frame.apply(np.insert(ring, 1, 0.0, axis=1))


@dataclass(eq=False)
class _Front:
    """A facade in plan: its ends (2, 2) m from left to right, and the unit vector (2,) into the building."""

    ends: Float
    inward: Float

    def quad(self, depth: float) -> Polygon:
        """What lies behind it, before it for a negative depth."""
        a, b = self.ends
        return Polygon([a, b, b + depth * self.inward, a + depth * self.inward])


def _plan(facades: Sequence[Facade], depth: float) -> list[Polygon]:
    """The blocks in plan, m local, largest first."""
    fronts = []
    for facade in facades:
        x0, _, x1, _ = facade.extent
        inward = facade.frame.R[:2, 1] / np.linalg.norm(facade.frame.R[:2, 1])
        fronts.append(_Front(facade.frame.apply(np.array([[x0, 0, 0], [x1, 0, 0.0]]))[:, :2], inward))
    corners = _met(fronts, depth)
    body: list[BaseGeometry] = list(corners)
    for front in fronts:
        others = [f.quad(-depth) for f in fronts if f.inward @ front.inward < 0.5]
        body.append(front.quad(depth).difference(shapely.union_all(others)))
    union = shapely.union_all(body).buffer(_SLIT, join_style="mitre").buffer(-_SLIT, join_style="mitre")
    parts = shapely.get_parts(shapely.set_precision(union, 1 / GRID))
    polygons = [p.simplify(1 / GRID) for p in parts if isinstance(p, Polygon) and p.area > 1.0]
    return sorted(polygons, key=lambda p: -float(p.area))


def _met(fronts: Sequence[_Front], depth: float) -> list[Polygon]:
    """Move ends that are near the corner of two planes to it; what fills a corner that looks inwards."""
    fills = []
    for i, one in enumerate(fronts):
        for other in fronts[:i]:
            if abs(_cross(one.inward, other.inward)) < _PARALLEL:
                continue
            corner = np.linalg.solve(
                np.array([one.inward, other.inward]),
                np.array([one.inward @ one.ends[0], other.inward @ other.ends[0]]),
            )
            near = [int(np.argmin(np.linalg.norm(f.ends - corner, axis=1))) for f in (one, other)]
            away = [
                float(np.linalg.norm(f.ends[k] - corner)) for f, k in zip((one, other), near, strict=True)
            ]
            if max(away) > _CORNER:
                continue
            middles = [f.ends.mean(0) - corner for f in (one, other)]
            one.ends[near[0]] = other.ends[near[1]] = corner
            if middles[0] @ other.inward < 0:  # the one lies before the other: a corner of a courtyard
                a, b = corner + depth * one.inward, corner + depth * other.inward
                hull = MultiPoint([corner, a, b, a + b - corner]).convex_hull
                fills += [hull] if isinstance(hull, Polygon) else []
    return fills


def _cross(a: Float, b: Float) -> float:
    return float(a[0] * b[1] - a[1] * b[0])
