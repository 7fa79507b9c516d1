"""Where closed openings may be: at the crossings of rows and columns, then anywhere along either."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int
from frontage.openings.borders.outline import Outline
from frontage.openings.boxes import Box
from frontage.openings.closed.steps import OpeningForm
from frontage.openings.layout.groups import like_groups
from frontage.openings.layout.inferred import CLEAR, SEEN, WITHIN, OpeningGrid, state_of
from frontage.openings.wall.evidence import Evidence
from frontage.openings.wall.raster import WallRaster, summed

SIZE = 0.01
"""m, one sigma between the sizes, sills and middles of like openings where few determine it."""


@dataclass(frozen=True, eq=False)
class CandidatePlaces:
    """Places where an opening of a form may be.

    form        its shape and size
    x, z        (n,) m, lower left corners
    like        number of an opening of that form
    covariance  (5, 5) m2 of left, right, bottom, top and rise of what stands at any of them
    node        whether a row and a column cross there
    """

    form: OpeningForm
    x: Float
    z: Float
    like: int
    covariance: Float
    node: bool

    def box(self, k: int) -> Box:
        """Returns the bounding box at place number k, m."""
        x, z = float(self.x[k]), float(self.z[k])
        return x, z, x + self.form.width, z + self.form.height


def at_crossings(outlines: Sequence[Outline], evidence: Evidence) -> list[CandidatePlaces]:
    """Returns the places where a row and a column of two openings or more cross, and beams came back."""
    found = []
    for node in OpeningGrid(outlines).nodes():
        like = outlines[node.like]
        if like.shape == "circle" or state_of(node.place, outlines, evidence) not in SEEN:
            continue
        x0, z0, x1, z1 = node.place
        form = OpeningForm(like.shape, x1 - x0, z1 - z0, like.rise)
        found.append(CandidatePlaces(form, np.array([x0]), np.array([z0]), node.like, node.covariance, True))
    return found


def along_lines(outlines: Sequence[Outline], evidence: Evidence, cell: float) -> Iterator[CandidatePlaces]:
    """Yields places every `cell` m along the row and the column of every opening, where another has room."""
    room = _Room(evidence, [o.place for o in outlines])
    x0, z0 = evidence.raster.corner
    high, wide = (n * evidence.raster.cell for n in evidence.raster.shape)
    own = np.array([o.place for o in outlines]).reshape(-1, 4)
    grouped = like_groups(outlines)
    single = [(k,) for k in range(len(outlines)) if not any(k in g for g in grouped)]
    for group in [*grouped, *single]:
        form = _form([outlines[k] for k in group])
        if form.shape == "circle" or min(form.width, form.height - form.rise) < cell:
            continue
        sills = _apart(own[list(group), 1], cell)
        left = _apart((own[list(group), 0] + own[list(group), 2] - form.width) / 2.0, cell)
        along, up = np.arange(x0, x0 + wide - form.width, cell), np.arange(z0, z0 + high - form.height, cell)
        rise = float(outlines[group[0]].covariance[4, 4])
        for x, z, free in (
            (np.tile(along, len(sills)), np.repeat(sills, len(along)), (cell, SIZE)),
            (np.repeat(left, len(up)), np.tile(up, len(left)), (SIZE, cell)),
        ):
            clear = room.at(x, z, form)
            if clear.any():
                yield CandidatePlaces(form, x[clear], z[clear], group[0], _scatter(*free, rise), False)


class _Room:
    """Where a form lies on the facade, clear of all openings, to within a cell."""

    def __init__(self, evidence: Evidence, taken: Sequence[Box]) -> None:
        raster = evidence.raster
        blocked = np.zeros(raster.shape)
        for x0, z0, x1, z1 in taken:
            c, r = _cell(raster, np.array([x0, x1]), np.array([z0, z1]))
            off = max(int(CLEAR / raster.cell) - 1, 0)
            blocked[max(r[0] - off, 0) : r[1] + off, max(c[0] - off, 0) : c[1] + off] = 1.0
        self._raster = raster
        self._inside, self._blocked = summed(evidence.inside.astype(np.float64)), summed(blocked)

    def at(self, x: Float, z: Float, form: OpeningForm) -> Bool:
        """Returns whether it does with its lower left corner at x, z (n,) m."""
        (c0, r0), (c1, r1) = (
            _cell(self._raster, x, z),
            _cell(self._raster, x + form.width, z + form.height),
        )
        h, w = self._raster.shape
        on = (r0 >= 0) & (c0 >= 0) & (r1 <= h) & (c1 <= w)
        r0, r1, c0, c1 = (np.where(on, v, 0) for v in (r0, r1, c0, c1))
        inside, blocked = (
            m[r1, c1] - m[r0, c1] - m[r1, c0] + m[r0, c0] for m in (self._inside, self._blocked)
        )
        return on & (inside >= WITHIN * (r1 - r0) * (c1 - c0)) & (blocked < 0.5)


def _cell(raster: WallRaster, x: Float, z: Float) -> tuple[Int, Int]:
    """Returns the columns and rows of the cell corners nearest to places (n,) m."""
    return tuple(
        np.rint((v - o) / raster.cell).astype(np.int64) for v, o in zip((x, z), raster.corner, strict=True)
    )  # type: ignore[return-value]


def _form(like: Sequence[Outline]) -> OpeningForm:
    """Returns the mean form of like openings."""
    sizes = [(o.place[2] - o.place[0], o.place[3] - o.place[1], o.rise) for o in like]
    width, height, rise = np.mean(sizes, axis=0)
    return OpeningForm(like[0].shape, float(width), float(height), float(rise))


def _scatter(across: float, up: float, rise: float) -> Float:
    """Returns the covariance (5, 5) m2 of an opening of known size whose place is known to so many m.

    across, up  m, one sigma of its place
    rise        m2, variance of its rise
    """
    covariance: Float = np.diag([0.0, 0.0, 0.0, 0.0, rise])
    covariance[:2, :2], covariance[2:4, 2:4] = across**2, up**2
    covariance[:4, :4] += np.eye(4) * SIZE**2 / 2.0
    return covariance


def _apart(values: Float, least: float) -> Float:
    """Returns the sorted values (n,), of those nearer than `least` to one another only the first."""
    v = np.sort(values)
    kept = [0] if len(v) else []
    for k in range(1, len(v)):
        if v[k] - v[kept[-1]] >= least:
            kept.append(k)
    return v[kept]
