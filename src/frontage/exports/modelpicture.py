"""Draws a model as seen from the street: the nearest surface at every pixel, shaded, with its edges."""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.exports.model3d import COLOURS
from frontage.exports.triangles import KINDS, ModelTriangles
from frontage.geometry.arrays import Array, Float

_MOST_PX = 1200  # width of the picture
_OVERSAMPLING = 2  # pixels drawn per pixel kept, along each axis
_ASIDE_RAD, _ABOVE_RAD = np.radians(28.0), np.radians(16.0)  # of the view direction against the normal
_LIGHT = np.array([0.45, -0.55, 0.70])  # in the axes of the view: right, away from the eye, up
_AMBIENT = 0.45
_EDGE_TOLERANCE_M = 0.02  # an edge is drawn if it lies no farther behind the surface
_THINNEST_PX = 0.4  # a triangle less high than this hardly has a pixel's centre; models have thousands
_NONE = np.empty((0, 3))
_EDGE_COLOUR = np.array([45.0, 45.0, 50.0])


@dataclass(frozen=True, eq=False)
class ParallelView:
    """A parallel projection.

    axes    (3, 3), rows: right, away from the eye, up
    scale   px per m
    corner  (right, up) m of the upper left corner of the picture
    size    width and height, px
    """

    axes: Float
    scale: float
    corner: Float
    size: tuple[int, int]

    def place(self, xyz: Float) -> Float:
        """Projects points (..., 3) m local to (..., 3): column px, row px, distance m."""
        q = xyz @ self.axes.T
        column = (q[..., 0] - self.corner[0]) * self.scale
        row = (self.corner[1] - q[..., 2]) * self.scale
        return np.stack([column, row, q[..., 1]], axis=-1)


def render_model(shapes: ModelTriangles, inward: Float, others: Float = _NONE, most: int = _MOST_PX) -> Array:
    """Draws the model (h, w, 3) uint8 RGB from the street side of a facade with the normal `inward` (3,).

    The view is parallel, slightly from above and from the left, or from the right if more can be seen from
    there of the facades `others` (n, 3), given by normals as long as the facades are wide. The background is
    white, and the picture is at most `most` px wide. Raises ValueError without triangles.
    """
    if not len(shapes):
        raise ValueError("there is nothing to draw")
    view = _view(shapes.corners.reshape(-1, 3), _ahead(inward, others), most * _OVERSAMPLING)
    image, depth = _surfaces(shapes, view)
    _edges(image, depth, shapes, view)
    small: Array = cv2.resize(
        image.astype(np.float32),
        (view.size[0] // _OVERSAMPLING, view.size[1] // _OVERSAMPLING),
        interpolation=3,
    )
    return np.asarray(np.clip(np.rint(small), 0, 255), np.uint8)


def _ahead(inward: Float, others: Float) -> Float:
    """Returns the horizontal direction (3,) of the view."""
    flat = np.array([inward[0], inward[1], 0.0]) / np.hypot(inward[0], inward[1])
    side = np.array([flat[1], -flat[0], 0.0])
    left, right = (np.cos(_ASIDE_RAD) * flat + s * np.sin(_ASIDE_RAD) * side for s in (1.0, -1.0))
    from_left, from_right = (np.maximum(others @ ahead, 0).sum() for ahead in (left, right))
    return np.asarray(right if from_right > from_left else left)


def _view(xyz: Float, ahead: Float, most: int) -> ParallelView:
    """Returns the view along `ahead` in which all points (n, 3) lie, at most `most` px wide."""
    right = np.array([ahead[1], -ahead[0], 0.0])
    away = np.cos(_ABOVE_RAD) * ahead - np.array([0, 0, np.sin(_ABOVE_RAD)])
    axes = np.array([right, away, np.cross(right, away)])
    q = xyz @ axes.T
    low, high = q.min(0) - 0.5, q.max(0) + 0.5
    wide, tall = high[0] - low[0], high[2] - low[2]
    scale = most / max(wide, tall * 1.3)
    w, h = (int(np.ceil(v * scale / _OVERSAMPLING)) * _OVERSAMPLING for v in (wide, tall))
    return ParallelView(axes, float(scale), np.array([low[0], high[2]]), (w, h))


def _surfaces(shapes: ModelTriangles, view: ParallelView) -> tuple[Array, Array]:
    """Draws the nearest surfaces: colours (h, w, 3) and distances (h, w) m."""
    w, h = view.size
    image = np.full((h, w, 3), 255.0, np.float32)
    depth = np.full((h, w), np.inf, np.float32)
    light = _LIGHT / np.linalg.norm(_LIGHT)
    towards = shapes.normals @ view.axes.T
    shade = _AMBIENT + (1 - _AMBIENT) * np.clip(towards @ light, 0, 1)
    base = np.array([COLOURS[k] for k in KINDS])[shapes.kind]
    colour = 255 * np.clip(base * shade[:, None] * 1.5, 0, 1) ** (1 / 2.2)
    place = view.place(shapes.corners)
    for k in np.flatnonzero((towards[:, 1] < 0) & (_heights(place) > _THINNEST_PX)).tolist():
        _fill(image, depth, place[k], colour[k])
    return image, depth


def _heights(place: Float) -> Float:
    """Returns the least height (t,) px of triangles (t, 3, 3) of column, row and distance."""
    sides = np.roll(place, -1, axis=1)[..., :2] - place[..., :2]
    twice = np.abs(sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0])
    return np.asarray(twice / np.maximum(np.linalg.norm(sides, axis=2).max(1), 1e-9))


def _fill(image: Array, depth: Array, corners: Float, colour: Float) -> None:
    """Draws one triangle (3, 3) of column, row and distance where it is nearest."""
    h, w = depth.shape
    c0, r0 = np.maximum(np.floor(corners[:, :2].min(0)).astype(int), 0)
    c1, r1 = np.minimum(np.ceil(corners[:, :2].max(0)).astype(int) + 1, [w, h])
    if c1 <= c0 or r1 <= r0:
        return
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = corners.tolist()
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    if abs(area) < 1e-9:
        return
    x, y = np.arange(c0, c1) + 0.5, (np.arange(r0, r1) + 0.5)[:, None]
    s = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area
    t = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area
    z = az + s * (bz - az) + t * (cz - az)
    near = depth[r0:r1, c0:c1]
    shown = (s >= 0) & (t >= 0) & (s + t <= 1) & (z < near)
    near[shown] = z[shown]
    image[r0:r1, c0:c1][shown] = colour


def _edges(image: Array, depth: Array, shapes: ModelTriangles, view: ParallelView) -> None:
    """Draws the borders of the faces where nothing lies in front of them."""
    ends = view.place(shapes.edges)
    h, w = depth.shape
    steps = np.maximum(1, np.ceil(np.abs(ends[:, 1, :2] - ends[:, 0, :2]).max(1))).astype(np.int64)
    which = np.repeat(np.arange(len(ends)), steps)
    t = (np.arange(len(which)) - np.repeat(np.cumsum(steps) - steps, steps)) / np.repeat(steps, steps)
    at = ends[which, 0] + t[:, None] * (ends[which, 1] - ends[which, 0])
    c, r = at[:, 0].astype(np.int64), at[:, 1].astype(np.int64)
    inside = (c >= 1) & (c < w - 1) & (r >= 1) & (r < h - 1)
    c, r, z = c[inside], r[inside], at[inside, 2]
    behind = np.min([depth[r + i, c + j] for i in (-1, 0, 1) for j in (-1, 0, 1)], axis=0)
    shown = z <= behind + _EDGE_TOLERANCE_M + 2.0 / view.scale
    image[r[shown], c[shown]] = _EDGE_COLOUR
