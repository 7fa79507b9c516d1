"""Strips of wall between two openings that are narrower than any pier of brick.

Bars that are level with the wall belong to joinery that is level with it. Where the frames on both sides lie
behind a strip that is level with the wall, it is part of the wall: a mullion of stone or concrete.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Float, rising
from frontage.model.masonry import MASONRY
from frontage.openings.boxes import Box
from frontage.openings.layout.joinery import (
    FULL,
    JoineryPlane,
    beside,
    due_in,
    joinery_planes,
    points_within,
    post_borders,
)
from frontage.openings.layout.posts import Post
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.evidence import BEAMS_TO_DECIDE, Evidence

_LONG = 0.3  # m: openings are at least as high and wide, and so are the strips between them
_NARROW = 0.05  # m: cover strips and bars of grilles are narrower
_PROUD = 0.04  # m that cover strips stand out from the joinery behind them at most
_FRAME = 0.04  # m beside a strip that the frame behind it fills
_NONE = np.empty((2, 0))


def find_strips(beams: Beams, evidence: Evidence) -> tuple[Post, ...]:
    """Finds the upright and lying strips of wall between openings, as posts that are level with the wall.

    Only known lines of sight tell strips from what stands before an opening.
    """
    if not beams.rays:
        return ()
    frames = [p for p in joinery_planes(beams, evidence, _NONE) if p.depth > _PROUD]
    return tuple(
        Post(*strip, beams.depth_at(*_middle(strip)).item(), level=True)
        for lying in (False, True)
        for strip in _strips(beams, evidence, frames, lying=lying)
    )


def _middle(box: Box) -> tuple[Float, Float]:
    """Returns the place (1,), (1,) m of the middle of a box."""
    return np.array([(box[0] + box[2]) / 2.0]), np.array([(box[1] + box[3]) / 2.0])


def _strips(
    beams: Beams, evidence: Evidence, frames: Sequence[JoineryPlane], *, lying: bool
) -> Iterator[Box]:
    """Yields the strips x0, z0, x1, z1 m of one direction. For lying ones x and z change places."""
    open_ = evidence.is_open.T if lying else evidence.is_open
    turn = slice(None, None, -1 if lying else 1)
    through = beams.open.T[turn]
    order = rising(through[0])
    through, depth = through[:, order], beams.open_depth[order]
    wall = JoineryPlane(_sorted(beams.solid.T[turn]), _NONE, _NONE, through, 0.0, 0.0)
    joinery = [_sorted(plane.own[turn]) for plane in frames]
    cell, corner = evidence.raster.cell, np.tile(evidence.raster.corner[turn], 2)
    between = (
        ndimage.binary_closing(open_, np.ones((1, int(MASONRY.half_brick / cell) + 1), np.bool_)) & ~open_
    )
    for rows, columns in ndimage.find_objects(ndimage.label(between)[0]):
        if (rows.stop - rows.start) * cell < _LONG:
            continue
        x0, z0, x1, z1 = (
            corner + np.array([columns.start, rows.start, columns.stop, rows.stop]) * cell
        ).tolist()
        due = due_in(evidence, (z0, x0, z1, x1) if lying else (x0, z0, x1, z1))
        across = post_borders(wall, (x0, z0, x1, z1), cell, due)
        if across is None or not _NARROW <= across[1] - across[0] <= MASONRY.half_brick + cell:
            continue
        x0, x1 = across
        deep = all(_depth(through, depth, (a, z0, b, z1)) > _PROUD for a, b in beside(x0, x1))
        sides = [(x0 - _FRAME, z0, x0, z1), (x1, z0, x1 + _FRAME, z1)]
        held = max(points_within(own, side).shape[1] for own in joinery for side in sides) if joinery else 0
        if deep and held > FULL * due * _FRAME * (z1 - z0):
            yield (z0, x0, z1, x1) if lying else (x0, z0, x1, z1)


def _sorted(places: Float) -> Float:
    """Returns places (2, n) in the order of the first axis."""
    return places[:, rising(places[0])]


def _depth(through: Float, depth: Float, pane: Box) -> float:
    """Returns the median depth m of the points whose beams cross a pane; zero if they are few.

    The beams cross the wall at the places `through` (2, n), sorted along the first axis.
    """
    a, b = np.searchsorted(through[0], [pane[0], pane[2]])
    own = depth[a:b][(through[1, a:b] >= pane[1]) & (through[1, a:b] < pane[3])]
    return float(np.median(own)) if len(own) >= BEAMS_TO_DECIDE else 0.0
