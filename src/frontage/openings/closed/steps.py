"""Steps of a picture of the wall inwards across the four sides of a shape, wherever that is put."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int
from frontage.openings.borders.shapes import below
from frontage.openings.boxes import Box
from frontage.openings.wall.raster import WallRaster, summed

_STRIP = 0.12  # m, width of the strips on either side of a border
_CLEAR = 0.03  # m on either side of a border that strips leave out: cells that it cuts, mortar, seals
_FULL = 0.4  # share of a strip's cells that must hold points: walls are sparse above
_AWAY = 0.25  # m around openings that tell nothing of the wall by itself: surrounds
_PLACES = 50  # places on the wall that its own steps must be known from
_MANY = 1000  # places that determine them well enough
_BOUND = 3.0  # scales beyond which a step does not tell more of a correlation
_LEAST = 0.02  # of a step: less is drift of the instrument, however even the wall is
HEAD = 0.8
"""Share of a head's width that tells of it: at its ends a curve is too steep."""


@dataclass(frozen=True)
class OpeningForm:
    """The shape and the size m of an opening."""

    shape: str
    width: float
    height: float
    rise: float

    def drop(self, u: Float) -> Float:
        """Returns the height (n,) m of the head relative to the top (negative), u (n,) m from the middle."""
        return below(self.shape, self.rise, self.width / 2.0, u)


class ChannelMap:
    """Channels (h, w, c) on a raster, as sums over boxes.

    Only `known` cells (h, w) count; where these are not given, all whose values are finite.
    """

    def __init__(self, values: Float, raster: WallRaster, known: Bool | None = None) -> None:
        finite = np.asarray(np.isfinite(values).all(2)) if known is None else known
        self.values, self.raster, self._known = values, raster, finite
        counted = np.empty((*raster.shape, values.shape[2] + 1))
        counted[..., :-1], counted[..., -1] = values, finite
        counted[~finite] = 0.0
        self._sums = summed(counted).reshape(-1, counted.shape[2])

    def without(self, taken: Sequence[Box]) -> "ChannelMap":
        """Returns the picture of the bare wall, well off all boxes."""
        return ChannelMap(self.values, self.raster, self._known & _free(self.raster, taken))

    def steps(self, x: Float, z: Float, form: OpeningForm) -> Float:
        """Returns the steps (n, 4, c) inwards on the left, bottom, right and top of a form; NaN = not known.

        Its lower left corner is at x, z (n,) m.
        """
        g, (cx, cz) = self.raster.cell, self.raster.corner
        c, r = (np.rint((v - o) / g).astype(np.int64)[:, None] for v, o in ((x, cx), (z, cz)))
        w, h, straight = (max(round(v / g), 1) for v in (form.width, form.height, form.height - form.rise))
        first, last, drop = _pieces(form, w, g)
        head = r + h + drop
        gap, far = int(np.ceil(_CLEAR / g)), int(np.ceil(_CLEAR / g)) + max(round(_STRIP / g), 2)

        def step(rows: tuple[Int, Int] | None, columns: tuple[Int, Int] | None, at: Int, way: int) -> Float:
            """From the strip before the border `at` to that behind it, in the direction `way`."""
            strips = []
            for near, away in ((gap, far), (-far, -gap)):
                a, b = at + way * near, at + way * away
                across = (np.minimum(a, b), np.maximum(a, b))
                strips.append(self._mean(rows or across, columns or across))
            return strips[0] - strips[1]

        return np.stack(
            [
                step((r, r + straight), None, c, 1),
                step(None, (c, c + w), r, 1),
                step((r, r + straight), None, c + w, -1),
                step(None, (c + first, c + last), head, -1),
            ],
            1,
        )

    def _mean(self, rows: tuple[Int, Int], columns: tuple[Int, Int]) -> Float:
        """Returns the means (n, c) of the values in boxes of cells (n, k), the k of a row together."""
        h, w = self.values.shape[:2]
        r0, r1 = (np.minimum(np.maximum(v, 0), h) for v in rows)
        c0, c1 = (np.minimum(np.maximum(v, 0), w) for v in columns)
        upper, lower = (self._sums[r * (w + 1) + c1] - self._sums[r * (w + 1) + c0] for r in (r1, r0))
        total = (upper - lower).sum(1)
        area = ((rows[1] - rows[0]) * (columns[1] - columns[0])).sum(1)
        number = total[:, -1:]
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(number >= _FULL * area[:, None], total[:, :-1] / number, np.nan)


def _pieces(form: OpeningForm, w: int, cell: float) -> tuple[Int, Int, Int]:
    """Returns the head of a form `w` cells wide as level pieces (k,): first and next column, drop."""
    j = np.arange(w)
    u = (j + 0.5) / w - 0.5
    j, u = j[np.abs(u) <= HEAD / 2.0], u[np.abs(u) <= HEAD / 2.0]
    drop = np.rint(form.drop(u * form.width) / cell).astype(np.int64)
    first = np.flatnonzero(np.diff(drop, prepend=1) != 0)
    return j[first], np.append(j[first[1:]], j[-1] + 1), drop[first]


def wall_steps(bare: ChannelMap, form: OpeningForm, tails: bool = True) -> Float:
    """Returns the covariance (4, c, c) of the steps that a bare wall shows across the sides of a form.

    The form is moved over all of the wall that holds points: the scatter of its steps is what courses, stains
    and noise do to means of that size, however few of their points are independent. Without its `tails` only
    the middle of the scatter counts, channel by channel: for walls that may hold openings not yet known.
    """
    h, w = bare.values.shape[:2]
    g, (cx, cz) = bare.raster.cell, bare.raster.corner
    stride = max(int(np.sqrt(h * w / _MANY)), 1)
    r, c = (v.ravel() for v in np.mgrid[0:h:stride, 0:w:stride])
    steps = bare.steps(cx + c * g, cz + r * g, form)
    pairs = [_spread(steps[:, sides].reshape(-1, steps.shape[2]), tails) for sides in ([0, 2], [1, 3])]
    upright, level = (a if np.isfinite(a).all() else b for a, b in (pairs, pairs[::-1]))
    return np.array([upright, level, upright, level])


def _spread(steps: Float, tails: bool) -> Float:
    """Returns the covariance (c, c) of steps (n, c); NaN for few.

    The scales are those of their middle or of their tails, whichever are wider; the correlations are those of
    the bounded steps.
    """
    steps = steps[np.isfinite(steps).all(1)]
    if len(steps) < _PLACES:
        return np.full((steps.shape[1],) * 2, np.nan)
    size = np.abs(steps)
    middle = np.maximum(1.4826 * np.median(size, 0), _LEAST)
    if not tails:
        return np.diag(middle**2)
    scale = np.maximum(middle, np.quantile(size, 0.95, 0) / 1.96)
    bounded = np.clip(steps / scale, -_BOUND, _BOUND)
    like = bounded.T @ bounded / len(steps)
    like /= np.sqrt(np.outer(np.diag(like), np.diag(like))) + _LEAST**2
    return np.asarray(np.outer(scale, scale) * like + _LEAST**2 * np.eye(len(scale)))


def _free(raster: WallRaster, taken: Sequence[Box]) -> Bool:
    """Returns the cells (h, w) well off all boxes."""
    g, (cx, cz) = raster.cell, raster.corner
    free = np.ones(raster.shape, np.bool_)
    for x0, z0, x1, z1 in taken:
        rows = slice(max(int((z0 - _AWAY - cz) / g), 0), max(int((z1 + _AWAY - cz) / g) + 1, 0))
        columns = slice(max(int((x0 - _AWAY - cx) / g), 0), max(int((x1 + _AWAY - cx) / g) + 1, 0))
        free[rows, columns] = False
    return free
