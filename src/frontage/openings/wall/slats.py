"""Louvres: slats level with the wall that part an opening into a stack of equal gaps."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float
from frontage.model.masonry import MASONRY
from frontage.openings.boxes import Box
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.evidence import Evidence
from frontage.openings.wall.raster import closed

_THICKEST = 2.0 * MASONRY.half_brick  # m, largest height of a slat; no lintel carries a wall with so little
_FEWEST = 3  # slats of a louvre at least: fewer are transoms and sills
_NARROWEST = 0.3  # m, least width of a slat
_ALIKE = 0.15  # share of their width by which the ends of neighbouring slats differ at most
_EVEN = 0.25  # share of the mean pitch by which a pitch differs from it at most
_FULL = 0.7  # share of its box that a slat fills, and of a gap that is open


@dataclass(frozen=True)
class _Slat:
    """The rows [r0, r1) and columns [c0, c1) of a slat."""

    r0: int
    r1: int
    c0: int
    c1: int

    @property
    def middle(self) -> float:
        """The row of its middle."""
        return (self.r0 + self.r1) / 2.0


def find_slats(evidence: Evidence) -> tuple[Box, ...]:
    """Finds the slats (m) of louvres: no thicker than a brick, equally wide, at equal distances.

    Nothing that carries a wall is so thin and repeats itself so near.
    """
    thick = int(_THICKEST / evidence.raster.cell)
    if thick < 2:  # cells are too large for slats
        return ()
    open_ = evidence.is_open & evidence.inside
    least = int(np.ceil(_NARROWEST / evidence.raster.cell))
    labels, _ = ndimage.label(_bars(open_, thick, least))
    slats = []
    for number, (rows, columns) in enumerate(ndimage.find_objects(labels), 1):
        slat = _slat(labels[rows, columns] == number, rows.start, columns.start)
        if slat is not None and slat.c1 - slat.c0 >= least and slat.r1 - slat.r0 <= thick:
            slats.append(slat)
    stacks = _stacks(sorted(slats, key=lambda s: (s.r0, s.c0)), open_)
    return tuple(evidence.raster.box(s.r0, s.c0, s.r1, s.c1) for stack in stacks for s in stack)


def _bars(open_: Bool, thick: int, least: int) -> Bool:
    """Returns the cells (h, w) of bars across openings that are at most `thick` cells high.

    What sits on a bar, such as a pigeon, makes it higher for less than `least` cells.
    """
    bars = closed(open_, (thick + 1, 1)) & ~open_
    occupied = closed(open_, (2 * thick + 1, 1)) & ~open_
    return np.asarray(bars | (closed(bars, (1, least)) & occupied))


def _slat(bar: Bool, row: int, column: int) -> _Slat | None:
    """Returns a bar (h, w) as a slat, or None if it is no rectangle.

    The bar's first cell has the given row and column. Rows and columns of which less than half belongs to the
    bar are its ragged edges, and are left out. A bar is no rectangle where much of the rest is empty, or much
    of the bar lies outside of it.
    """
    rows = np.flatnonzero(bar.sum(axis=1) >= 0.5 * bar.sum(axis=1).max())
    columns = np.flatnonzero(bar[rows].mean(axis=0) >= 0.5)
    if not len(columns):
        return None
    slat = _Slat(row + rows[0], row + rows[-1] + 1, column + columns[0], column + columns[-1] + 1)
    own = bar[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    is_rectangle = own.mean() >= _FULL and own.sum() >= _FULL * bar.sum()
    return slat if is_rectangle else None


def _stacks(slats: Sequence[_Slat], open_: Bool) -> list[list[_Slat]]:
    """Returns the stacks of slats above one another that are evenly apart, with open gaps between them."""
    stacks: list[list[_Slat]] = []
    for slat in slats:
        own = next((s for s in stacks if _is_next(s[-1], slat, open_)), None)
        if own is None:
            stacks.append([slat])
        else:
            own.append(slat)
    return [_continued(s, open_) for s in stacks if len(s) >= _FEWEST and _is_even(s)]


def _is_next(lower: _Slat, upper: _Slat, open_: Bool) -> bool:
    """Returns whether a slat is the next one above another: as wide, with nothing but a gap between."""
    width = max(lower.c1 - lower.c0, upper.c1 - upper.c0)
    off = max(abs(lower.c0 - upper.c0), abs(lower.c1 - upper.c1))
    if upper.r0 <= lower.r1 or off > max(_ALIKE * width, 2.0):
        return False
    gap = open_[lower.r1 : upper.r0, max(lower.c0, upper.c0) : min(lower.c1, upper.c1)]
    return gap.size > 0 and float(gap.mean()) >= _FULL


def _is_even(stack: Sequence[_Slat]) -> bool:
    """Returns whether slats follow one another at equal distances."""
    pitch = np.diff([s.middle for s in stack])
    return bool(np.abs(pitch - pitch.mean()).max() <= max(_EVEN * pitch.mean(), 1.0))


def _continued(stack: list[_Slat], open_: Bool) -> list[_Slat]:
    """Returns a stack with the slats that follow it at its pitch, where something hides a part of a gap."""
    pitch = round((stack[-1].r0 - stack[0].r0) / (len(stack) - 1))
    for step, end in ((pitch, -1), (-pitch, 0)):
        while True:
            last = stack[end]
            slat = replace(last, r0=last.r0 + step, r1=last.r1 + step)
            if not _is_between_gaps(slat, pitch, open_):
                break
            stack = [*stack, slat] if step > 0 else [slat, *stack]
    return stack


def _is_between_gaps(slat: _Slat, pitch: int, open_: Bool) -> bool:
    """Returns whether a place (cells) is closed as a slat is, and most of it open above and below."""
    gap = pitch - (slat.r1 - slat.r0)
    if gap < 1 or slat.r0 < gap or slat.r1 + gap > len(open_):
        return False
    own, below, above = (
        float(open_[a:b, slat.c0 : slat.c1].mean())
        for a, b in ((slat.r0, slat.r1), (slat.r0 - gap, slat.r0), (slat.r1, slat.r1 + gap))
    )
    return own <= 1.0 - _FULL and min(below, above) >= 0.5


def with_slats(beams: Beams, slats: Sequence[Box]) -> Beams:
    """Returns the beams with slats right behind the wall, as joinery is, instead of on it."""
    behind = 2.0 * beams.least

    def held(x: Float, z: Float) -> Bool:
        """Returns which of the places (n,) m lie on a slat."""
        return np.asarray(np.any([(x >= a) & (x <= c) & (z >= b) & (z <= d) for a, b, c, d in slats], axis=0))

    points, lines = beams.points.copy(), beams.lines
    depth = beams.depth_at(points[:, 0], points[:, 2])
    on = held(points[:, 0], points[:, 2]) & (np.abs(points[:, 1] - depth) <= beams.least)
    points[on, 1] = depth[on] + behind
    ended = held(*lines.place) & (np.abs(lines.y - lines.level) <= beams.least)
    some = held(*beams.solid.T)
    return replace(
        beams,
        solid=beams.solid[~some],
        solid_depth=beams.solid_depth[~some],
        open=np.vstack([beams.open, beams.solid[some]]),
        open_depth=np.append(beams.open_depth, np.full(int(some.sum()), behind)),
        points=points,
        lines=replace(lines, y=np.where(ended, lines.level + behind, lines.y)),
    )
