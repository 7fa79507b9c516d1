"""Blind windows and sunk panels: niches that are closed by the material of the wall.

A closed shutter and a bricked-up window are both one even surface a hand's breadth behind the wall. How they
look tells them apart: masonry and plaster have the colour of the wall around them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Bool, Float
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY
from frontage.model.scan import Scan
from frontage.openings.boxes import Box, grown
from frontage.openings.closed.channels import WallSamples, looks_of, wall_points, within
from frontage.openings.layout.rasters import shared_areas
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.evidence import Evidence
from frontage.openings.wall.panels import as_wall, full_and_even

_DEEPEST = 0.25  # m behind the wall: a leaf of one brick, the depth of a reveal
_RECTANGLE = 0.8  # share of its box that a niche fills
_MOST = 0.5  # share of a box that counts as most of it
_BORDER = 0.1  # m at the border of a niche, where cells show its sides and the wall beside it as well
_AROUND = 0.6  # m around a niche, in which the wall tells how it looks
_TILE = 0.25  # m, side of the tiles of which the means are compared
_FEWEST = 5  # least number of points in a tile, and of tiles of a surface, from which a mean is told
_ALIKE = 2.0  # standard deviations of the wall's own tiles by which the means of a niche may differ
_EVEN = 0.05  # least such standard deviation, in logarithms of intensity and colour: niches are darker
_GREY = 0.1  # by which the logarithms of red and blue over green of a coloured wall differ from grey


@dataclass(frozen=True)
class BlindNiche:
    """A niche that is wall: its box m, and its depth m behind the wall around it."""

    box: Box
    depth: float

    def fills(self, box: Box) -> bool:
        """Returns whether the niche covers most of a box."""
        shared = shared_areas(np.array([box]), np.array([self.box])).item()
        return bool(shared > _MOST * (box[2] - box[0]) * (box[3] - box[1]))

    def holds(self, xz: Float, depth: Float, least: float) -> Bool:
        """Returns which places (n, 2) m with points (n,) m behind the wall show the back of this niche."""
        return within(xz, self.box) & (np.abs(depth - self.depth) <= 2.0 * least)


def find_blind_niches(
    beams: Beams, evidence: Evidence, facade: Facade, scan: Scan, ground: float
) -> tuple[BlindNiche, ...]:
    """Returns the blind niches of a wall.

    Scans without colours give none, because intensity alone tells too little. A niche that reaches down to
    the ground, at the height `ground` z m, may be a door and is left out.
    """
    if scan.rgb is None:
        return ()
    highest = ground + MASONRY.threshold - _BORDER  # of the foot of a door
    niches = [n for n in _closed_niches(beams, evidence) if n.box[1] > highest]
    if not niches:
        return ()
    surface = wall_points(facade, scan, beams, (0.0, _DEEPEST + 2.0 * beams.least))
    looks = looks_of(surface, facade, scan)
    return tuple(n for n in niches if _looks_like_the_wall(n, surface, looks, beams))


def without_blind_niches(evidence: Evidence, beams: Beams, niches: Sequence[BlindNiche]) -> Evidence:
    """Returns the evidence with the backs of niches as wall."""
    on = np.zeros(len(beams.open), np.bool_)
    for niche in niches:
        on |= niche.holds(beams.open, beams.open_depth, beams.least)
    if not on.any():
        return evidence
    back = np.zeros(evidence.llr.shape, np.bool_)
    for niche in niches:
        back[evidence.raster.cells(niche.box)] = True
    return as_wall(evidence, np.where(back, evidence.raster.count(*beams.open[on].T), 0.0), back)


def _closed_niches(beams: Beams, evidence: Evidence) -> list[BlindNiche]:
    """Returns the niches that one even surface closes, deeper than panels."""
    deep = (beams.open_depth > MASONRY.panel) & (beams.open_depth <= _DEEPEST)
    place, depth = beams.open[deep], beams.open_depth[deep]
    full = full_and_even(evidence, place, depth, beams.least)
    labels, _ = ndimage.label(full)
    found = []
    for number, (rows, columns) in enumerate(ndimage.find_objects(labels), 1):
        box = evidence.raster.box(rows.start, columns.start, rows.stop, columns.stop)
        own = within(place, box)
        if (labels[rows, columns] == number).mean() >= _RECTANGLE and own.any():
            found.append(BlindNiche(grown(box, _BORDER), float(np.median(depth[own]))))
    return found


def _looks_like_the_wall(niche: BlindNiche, surface: WallSamples, looks: Float, beams: Beams) -> bool:
    """Decides whether the back of a niche has the colour of the wall around it.

    looks (n, c): relief, intensity if there is one, lightness, red over green, blue over green. On a grey
    wall the intensity must be the same as well, because shutters are white and grey, too.
    """
    near = surface.within(grown(niche.box, _AROUND))
    xz, depth, looks = surface.xz[near], surface.depth[near], looks[near, 1:]
    back, wall = niche.holds(xz, depth, beams.least), np.abs(depth) <= beams.least
    own, other = (_tile_means(xz[some], looks[some]) for some in (back, wall))
    if min(len(own), len(other)) < _FEWEST:
        return False
    centre = np.median(other, axis=0)
    spread = np.maximum(1.4826 * np.median(np.abs(other - centre), axis=0), _EVEN)
    alike = np.abs(np.median(own, axis=0) - centre) <= _ALIKE * spread
    coloured = np.abs(centre[-2:]).max() > _GREY
    return bool(alike[-3:].all() and (coloured or (len(alike) > 3 and alike[0])))


def _tile_means(xz: Float, looks: Float) -> Float:
    """Returns the means (k, c) of values (n, c) in tiles; tiles with few places (n, 2) m are left out."""
    key = np.floor(xz / _TILE).astype(np.int64)
    _, tile, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    sums = [np.bincount(tile.ravel(), v, len(count)) for v in looks.T]
    return (np.column_stack(sums) / count[:, None])[count >= _FEWEST]
