"""The inner face of a wall whose rooms were scanned: where it shows, there is masonry before it.

Without known lines of sight, a room that was scanned from inside fills the place behind a wall with points.
What stands behind an opening can be seen from the street; what stands right behind masonry cannot. A surface
that shows behind masonry and is missing behind openings is therefore the inner face of the wall.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from frontage.geometry.arrays import Array, Bool, Float, Int, distinct
from frontage.model.facade import Facade
from frontage.model.masonry import MASONRY
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.evidence import (
    BEAMS_TO_DECIDE,
    SHADED,
    WALL,
    Evidence,
    local_rate,
    log_likelihood_ratio,
)
from frontage.openings.wall.expected import expected_beams
from frontage.openings.wall.raster import WallRaster
from frontage.openings.wall.surface import value_at

_THICKEST = 0.8  # m: walls of houses are at most three bricks thick
_LAYER = 0.02  # m, least thickness of the layers in which an inner face is looked for
_AROUND = 0.8  # m, one sigma of the surroundings that tell its depth: a pier and the openings beside it
_ROUNDS = 3  # rounds of face and masonry, for each tells of the other


@dataclass(frozen=True, eq=False)
class InnerFace:
    """The inner face of a wall.

    facade  the facade, whose support leaves out the points of the inner face
    places  (n, 2) x, z m of these points
    """

    facade: Facade
    places: Float


@dataclass(frozen=True, eq=False)
class _Tiles:
    """The tiles of a wall, and the tile (n,) that each cell of its evidence lies in, -1 outside."""

    raster: WallRaster
    of_cell: Int

    @classmethod
    def over(cls, cells: WallRaster, tiles: WallRaster) -> "_Tiles":
        """Finds the tile of every cell."""
        return cls(tiles, tiles.flat(*cells.middles(np.ones(cells.shape, np.bool_)).T))


def find_inner_face(facade: Facade, beams: Beams, evidence: Evidence) -> InnerFace | None:
    """Returns the inner face of the wall; None where the lines of sight are known or no face shows.

    In each tile of the wall, the layer that shows behind most of the masonry around is an inner face if it
    shows behind more of it than clutter does, and behind twice as much of it as behind the openings around.
    """
    if beams.rays:
        return None
    x, y, z = beams.points.T
    behind = y - beams.depth_at(x, z)
    some = np.flatnonzero((behind > max(MASONRY.half_brick, beams.least)) & (behind < _THICKEST))
    layer, place = max(beams.least, _LAYER), np.column_stack([x, z])[some]
    face, known = np.zeros(len(some), np.bool_), evidence
    tiles = _Tiles.over(evidence.raster, beams.raster)
    for _ in range(_ROUNDS):  # where a face shows, there is masonry, which tells of the face beside it
        depth = _depths(place, behind[some], tiles, known, layer)
        face = np.abs(behind[some] - value_at(depth, beams.raster, *place.T)) <= layer
        face[face] = _is_dense(place[face], evidence.raster)
        if not face.any():
            return None
        known = with_inner_face(evidence, place[face])
    kept = np.delete(facade.support, some[face])
    return InnerFace(replace(facade, support=kept), place[face])


def with_inner_face(evidence: Evidence, places: Float) -> Evidence:
    """Returns the evidence with the cells before an inner face, with points at `places` (n, 2) m, as masonry.

    Where none of its points are, nothing follows: furniture hides an inner face as trees hide an outer one.
    """
    held = evidence.raster.count(*places.T)
    shown = ndimage.binary_dilation(held > 0.0, np.ones((3, 3), np.bool_)) & evidence.inside
    solid = np.where(shown, np.maximum(evidence.solid, np.maximum(evidence.expected, held)), evidence.solid)
    against = log_likelihood_ratio(0.0 * held, held, 0.0 * held)
    llr = np.where(held > 0.0, np.minimum(evidence.llr, against), evidence.llr)
    return replace(evidence, llr=np.where(evidence.inside, llr, 0.0), solid=solid)


def _is_dense(places: Float, raster: WallRaster) -> Bool:
    """Returns which points of a layer, at `places` (n, 2) m, are as dense as a face; frames are not."""
    due = expected_beams(places, raster)
    dense = local_rate(raster.count(*places.T), due, 1.0) >= WALL
    at = raster.flat(*places.T)
    return np.asarray((at >= 0) & dense.ravel()[at])


def _depths(place: Float, behind: Float, tiles: _Tiles, evidence: Evidence, layer: float) -> Float:
    """Returns the depth (h, w) m of the inner face behind the wall in each tile; NaN where none shows.

    The points lie at `place` (n, 2) x, z m, `behind` (n,) m behind the wall. Area is counted in cells of the
    evidence.
    """
    hits = local_rate(evidence.solid, evidence.expected, 1.0)
    watched = evidence.inside & (evidence.expected > 0.0)
    kinds = watched & (hits >= WALL), watched & (hits <= SHADED)
    share = [_shares(place, behind, tiles, evidence.raster, layer, kind) for kind in kinds]
    best = share[0].argmax(2)[..., None]
    wall, open_ = (np.take_along_axis(s, best, 2)[..., 0] for s in share)
    depth = (best[..., 0] + 1.0) * layer
    return np.where((wall > SHADED) & (open_ < wall / 2.0), depth, np.nan)


def _shares(place: Float, behind: Float, tiles: _Tiles, cells: WallRaster, layer: float, kind: Bool) -> Array:
    """Returns the share (h, w, layers) of the cells of a `kind` (rows, columns) that hold points of a layer.

    It is that of the surroundings of each tile, 0 where they have too few such cells to tell. A layer is as
    thick as two steps, so that a surface between two layers is in one of them as a whole.
    """
    count = int(_THICKEST / layer) + 2
    at = cells.flat(*place.T)
    kept = (at >= 0) & kind.ravel()[at]
    own = (behind[kept] / layer).astype(np.int64)
    both = np.concatenate([at[kept] * count + own, at[kept] * count + np.maximum(own - 1, 0)])
    cell, number = np.divmod(distinct(both), count)
    shape, size = tiles.raster.shape, tiles.raster.shape[0] * tiles.raster.shape[1]
    tile = tiles.of_cell[cell]
    inside = tile >= 0
    held = np.bincount(tile[inside] * count + number[inside], minlength=size * count)
    every = tiles.of_cell[(tiles.of_cell >= 0) & kind.ravel()]
    total = np.bincount(every, minlength=size).astype(np.float32).reshape(shape)
    wide = _AROUND / tiles.raster.cell
    shown = held.reshape(*shape, count).astype(np.float32)
    shown = ndimage.gaussian_filter(shown, (wide, wide, 0.0), mode="constant", truncate=3.0)
    total = ndimage.gaussian_filter(total, wide, mode="constant", truncate=3.0)
    enough = 2.0 * np.pi * wide**2 * total >= BEAMS_TO_DECIDE
    return np.asarray(np.where(enough, 1.0 / np.maximum(total, 1e-3), 0.0)[..., None] * shown)
