"""Select the points of each wall of a registered model (paper B, section 2.1).

Every wall polygon gets the points of a buffer around it. The plane that the facade really has is estimated
from the scan, robustly and by area; its offset, turn and lean against the model come with standard errors. In
that plane the facade is a 2.5-D relief on a grid. Buildings that only the model or only the scan has are
listed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy import ndimage

from frontage.geometry.arrays import Array, Float, Int
from frontage.geometry.plane import facade_axes
from frontage.geometry.rigid import Rigid3
from frontage.model import CityModel, Scan
from frontage.registration.options import RegistrationOptions
from frontage.registration.walls import ModelPatch, ModelWalls, model_walls
from frontage.solve.robust import irls, mad_sigma
from frontage.solve.surfels import Surfels, make_surfels

_FEWEST_CELLS = 50  # cells of a wall, at least
_STOREY_M = 2.5  # m, least height of a building that the model lacks
_FRONT_M2 = 10.0  # m2, least area of its walls
_BEYOND_M = 1.0  # m that a ray must go on behind a wall to have passed it
_MOST_RAYS = 20_000  # rays that are examined, at most


@dataclass(frozen=True, eq=False)
class WallPoints:
    """One wall of the model, and what the scan has of it.

    building, surface  ids of the model
    index              (n,) int64 into the scan: points in the buffer of the wall's polygon
    local_from_facade  frame of the measured plane: X right as seen from the street, Y into the building, Z up
    offset             m against the model, positive = before it
    turn               rad about the vertical; `lean` rad, positive = the top leans out
    sigma              (3,) of offset, turn and lean
    relief             (h, w) m, median y of the points in cells of `cell` m, NaN = none; row 0 at the top
    corner             (x, z) m of the relief's upper left corner
    coverage           share of the polygon's cells with points, 0..1
    """

    building: str
    surface: str
    index: Int
    local_from_facade: Rigid3
    offset: float
    turn: float
    lean: float
    sigma: Float
    relief: Float
    corner: tuple[float, float]
    cell: float
    coverage: float

    @property
    def significance(self) -> Float:
        """Offset, turn and lean in units of their sigmas (3,)."""
        return np.array([self.offset, self.turn, self.lean]) / self.sigma


@dataclass(frozen=True, eq=False)
class Selection:
    """All walls with points, and the buildings on which model and scan differ.

    absent   buildings of the model that rays pass through
    unseen   buildings of the model that the scan says nothing of
    unknown  walls of the scan outside the model: centre (3,) m local and area m2
    """

    walls: tuple[WallPoints, ...]
    absent: tuple[str, ...]
    unseen: tuple[str, ...]
    unknown: tuple[tuple[Float, float], ...]


def select_walls(
    scan: Scan, model: CityModel, buffer: float = 1.0, options: RegistrationOptions | None = None
) -> Selection:
    """Selects the points within `buffer` m of every exposed wall of a model, for a scan registered to it."""
    options = options or RegistrationOptions()
    walls = model_walls(model)
    found = [w for p in walls.of_kind("wall") if (w := _wall(scan, walls, p, buffer, options.cell))]
    seen = {w.building for w in found}
    passed = _passed(scan, walls)
    absent = tuple(n for n, share in zip(walls.names, passed, strict=True) if n not in seen and share > 0.5)
    unseen = tuple(n for n in walls.names if n not in seen and n not in absent)
    return Selection(tuple(found), absent, unseen, _unknown(scan, walls, options))


def _wall(scan: Scan, walls: ModelWalls, patch: ModelPatch, buffer: float, cell: float) -> WallPoints | None:
    """Returns a wall's points and plane; None where too little of it was seen."""
    x0, y0, x1, y1 = patch.polygon.bounds
    middle = patch.point + 0.5 * (x0 + x1) * patch.along + 0.5 * (y0 + y1) * patch.up
    reach = 0.5 * float(np.hypot(x1 - x0, y1 - y0)) + buffer
    index = np.flatnonzero((np.abs(scan.xyz - middle) < reach).all(1))
    d, u, h = patch.coordinates(scan.xyz[index])
    near = (np.abs(d) < buffer) & (u > x0) & (u < x1) & (h > y0) & (h < y1)
    index, d, u, h = index[near], d[near], u[near], h[near]
    inside = np.asarray(shapely.contains_xy(patch.polygon, u, h), np.bool_)
    index, d, u, h = index[inside], d[inside], u[inside], h[inside]
    grid = _medians(u, h, d, (x0, y0, x1, y1), cell)
    known = np.isfinite(grid)
    if known.sum() < _FEWEST_CELLS:
        return None
    parameters, covariance = _plane(grid, (x0, y0), cell, float(_modal(grid[known])))
    offset, turn, lean = parameters
    normal = patch.normal - turn * patch.along - lean * patch.up
    frame = Rigid3("local", "facade", facade_axes(-normal), middle + offset * patch.normal)
    relief, corner = _relief(frame.inverse.apply(scan.xyz[index]), cell)
    area = float(patch.polygon.area) / cell**2
    return WallPoints(
        walls.names[patch.building],
        patch.source,
        index,
        frame,
        float(offset),
        float(turn),
        float(lean),
        np.sqrt(np.diag(covariance)),
        relief,
        corner,
        cell,
        float(min(known.sum() / max(area, 1.0), 1.0)),
    )


def _medians(u: Float, h: Float, d: Float, bounds: tuple[float, ...], cell: float) -> Float:
    """Returns the median of d in cells (rows up, columns along); NaN where there are fewer than three points.

    u, h, d  (n,) m, place along and up, and distance
    bounds   (x0, y0, x1, y1) m
    """
    x0, y0, x1, y1 = bounds
    w, tall = int((x1 - x0) / cell) + 1, int((y1 - y0) / cell) + 1
    flat = ((h - y0) / cell).astype(np.int64) * w + ((u - x0) / cell).astype(np.int64)
    order = np.lexsort((d, flat))
    count = np.bincount(flat, minlength=w * tall)
    start = np.concatenate([[0], np.cumsum(count)[:-1]])
    out = np.full(w * tall, np.nan)
    some = count >= 3
    out[some] = d[order][(start + count // 2)[some]]
    return out.reshape(tall, w)


def _modal(d: Float) -> float:
    """Returns the offset (m) that most cells share, to 2 cm: that of the main layer, not of a balcony."""
    edges = np.arange(d.min() - 0.05, d.max() + 0.1, 0.02)
    count, _ = np.histogram(d, edges)
    k = int(np.argmax(ndimage.gaussian_filter1d(count.astype(np.float64), 1.5)))
    return float(0.5 * (edges[k] + edges[k + 1]))


def _plane(grid: Float, corner: tuple[float, float], cell: float, start: float) -> tuple[Float, Float]:
    """Fits offset (m) at the polygon's middle, turn and lean (rad) of the main layer, with covariance (3, 3).

    One square metre counts as one observation, because relief is correlated.
    """
    rows, columns = np.nonzero(np.isfinite(grid))
    h, w = grid.shape
    design = np.column_stack(
        [np.ones(len(rows)), (columns + 0.5 - w / 2) * cell, (rows + 0.5 - h / 2) * cell]
    )
    d = grid[rows, columns]
    first = np.array([start, 0.0, 0.0])
    fit = irls(design, d, np.ones(len(d)), sigma_floor=0.003, start=first, sigma_start=0.03)
    near = np.abs(d - design @ fit.parameters) < 3 * fit.sigma
    sigma = max(mad_sigma((d - design @ fit.parameters)[near]), 0.003)
    normal = (design[near].T @ design[near]) * cell**2
    return fit.parameters, sigma**2 * np.linalg.pinv(normal)


def _relief(xyz: Float, cell: float) -> tuple[Float, tuple[float, float]]:
    """Returns the relief y (h, w) m of points in the facade frame, row 0 at the top, and its corner."""
    x, z = xyz[:, 0], xyz[:, 2]
    bounds = (float(x.min()), float(z.min()), float(x.max()), float(z.max()))
    grid = _medians(x, z, xyz[:, 1], bounds, cell)
    return np.ascontiguousarray(grid[::-1]), (bounds[0], bounds[1] + len(grid) * cell)


def _passed(scan: Scan, walls: ModelWalls) -> Float:
    """Returns the share (b,) of the rays that meet a building's walls from outside and go on behind them."""
    rows = np.flatnonzero(scan.origin_index >= 0)
    rows = rows[:: max(1, len(rows) // _MOST_RAYS)]
    share = np.zeros((2, len(walls.names)))
    if len(rows) == 0:
        return np.zeros(len(walls.names))
    start, end = scan.sensor_of(rows), scan.xyz[rows]
    for p in walls.of_kind("wall"):
        a, _, _ = p.coordinates(start)
        b, _, _ = p.coordinates(end)
        meets = (a > 0) & (b < _BEYOND_M)
        t = (a[meets] / np.maximum(a[meets] - b[meets], 1e-9))[:, None]
        _, u, h = p.coordinates(start[meets] + t * (end[meets] - start[meets]))
        inside = np.asarray(shapely.contains_xy(p.polygon, u, h), np.bool_)
        share[0, p.building] += np.count_nonzero(b[meets][inside] < -_BEYOND_M)
        share[1, p.building] += np.count_nonzero(inside)
    return np.asarray(share[0] / np.maximum(share[1], 20.0))


def _unknown(scan: Scan, walls: ModelWalls, options: RegistrationOptions) -> tuple[tuple[Float, float], ...]:
    """Finds upright surfaces of a storey's height outside all footprints, in connected pieces of 1 m."""
    centre = scan.origins.mean(0) if len(scan.origins) else scan.xyz.mean(0)
    s = make_surfels(scan, options.cell, centre, options.reach)
    s = s.take(s.upright)
    known = shapely.union_all([f.buffer(_BEYOND_M) for f in walls.footprints])
    shapely.prepare(known)
    s = s.take(~np.asarray(shapely.contains_xy(known, s.xyz[:, 0], s.xyz[:, 1]), np.bool_))
    return tuple(_clusters(s)) if len(s) else ()


def _clusters(s: Surfels) -> Sequence[tuple[Float, float]]:
    """Groups surfels by connected cells of 1 m in plan; returns centre (3,) m and area m2 of large ones."""
    ij = np.floor(s.xyz[:, :2]).astype(np.int64)
    ij -= ij.min(0) - 1
    image: Array = np.zeros(ij.max(0) + 2, np.int64)
    image[ij[:, 0], ij[:, 1]] = 1
    label = ndimage.label(image, np.ones((3, 3)))[0][ij[:, 0], ij[:, 1]]
    out = []
    for k in range(1, int(label.max()) + 1):
        part = s.take(label == k)
        if part.area.sum() >= _FRONT_M2 and np.ptp(part.xyz[:, 2]) >= _STOREY_M:
            out.append((np.average(part.xyz, axis=0, weights=part.area), float(part.area.sum())))
    return out
