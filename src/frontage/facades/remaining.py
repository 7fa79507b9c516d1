"""Find the walls that remain when the first ones have been refined.

A sketch claims everything near its plane. Two things in it do not belong to its wall: what lies beyond a gap,
and what slants from its plane.
"""

from collections.abc import Sequence

import numpy as np

from frontage.facades.candidate import FacadeCandidate, some_inliers
from frontage.facades.cloud import columns
from frontage.facades.options import FacadeOptions
from frontage.facades.plane.connected import RELIEF_M
from frontage.facades.scene import FacadeScene
from frontage.facades.sequential import in_prism, is_no_layer, search_among
from frontage.geometry.arrays import Bool, Float
from frontage.model.masonry import MASONRY, TOLERANCES

_MOST = 0.5  # share of a wall that counts as most of it
_END = 0.1  # share of a wall's points at either end that do not tell how far it reaches
_COLUMN_M = 1.0  # m, width of the columns of a facade whose depths are compared


def search_remaining(
    sketches: Sequence[FacadeCandidate],
    refined: Sequence[FacadeCandidate],
    scene: FacadeScene,
    rng: np.random.Generator,
) -> list[FacadeCandidate]:
    """Finds the walls that were claimed by sketches but do not belong to the refined walls.

    A sketch may join walls on both sides of a gap, of which the refined wall is one. Where a front bends,
    planes on both sides of the bend may claim the part between them, although it slants from both.
    """
    thin = scene.cloud.thinned
    lost = are_claimed(thin, sketches, scene.options) & ~are_claimed(thin, refined, scene.options)
    found: list[FacadeCandidate] = []
    for own, is_new in ((lost, is_no_layer), (_in_bent_columns(thin, refined, scene), _slants)):
        if np.count_nonzero(own) * scene.cloud.cell**2 >= scene.options.min_area:
            found += search_among(thin, own, [*refined, *found], is_new, scene, rng)
    return found


def are_claimed(xyz: Float, facades: Sequence[FacadeCandidate], options: FacadeOptions) -> Bool:
    """Returns which points (n, 3) m local lie in the prism of any facade."""
    claimed = np.zeros(len(xyz), np.bool_)
    for facade in facades:
        claimed |= in_prism(facade.wall.coordinates(xyz), facade, options)
    return claimed


def without_doubles(walls: Sequence[FacadeCandidate], scene: FacadeScene) -> list[FacadeCandidate]:
    """Drops every wall that lies mostly on a larger one.

    Two parts of one plane are such walls if the gap between them was closed for only one of them.
    """
    kept: list[FacadeCandidate] = []
    for wall in sorted(walls, key=lambda wall: -wall.cells.area):
        own = some_inliers(wall, scene.cloud)
        if not any(_on_wall(larger, own).mean() > _MOST for larger in kept):
            kept.append(wall)
    return kept


def on_walls(xyz: Float, facades: Sequence[FacadeCandidate]) -> Bool:
    """Returns which points (n, 3) m local lie on the wall of any facade."""
    on = np.zeros(len(xyz), np.bool_)
    for facade in facades:
        on |= _on_wall(facade, xyz)
    return on


def _on_wall(facade: FacadeCandidate, xyz: Float) -> Bool:
    """Returns which points (n, 3) m local lie on a wall."""
    q = facade.wall.coordinates(xyz)
    on = (np.abs(q[:, 1]) < facade.wall.threshold) & facade.cells.within(q[:, 0], q[:, 2])
    return np.asarray(on, np.bool_)


def _in_bent_columns(thin: Float, facades: Sequence[FacadeCandidate], scene: FacadeScene) -> Bool:
    """Returns which points (n, 3) m stand where a facade shows more wall off its plane than on it.

    Points within its relief are counted, column by column, in layers as thick as its plane.
    """
    out = np.zeros(len(thin), np.bool_)
    thick = 2.0 * scene.cloud.threshold
    reach = int(RELIEF_M / thick) + 1
    for facade in facades:
        q = columns(thin - facade.wall.point, facade.wall.axes)
        near = np.flatnonzero((np.abs(q[:, 1]) < RELIEF_M) & facade.cells.within(q[:, 0], q[:, 2]))
        column = np.floor((q[near, 0] - q[near, 0].min(initial=0.0)) / _COLUMN_M).astype(np.int64)
        layer = np.rint(q[near, 1] / thick).astype(np.int64) + reach
        shape = column.max(initial=0) + 1, 2 * reach + 1
        area = np.bincount(column * shape[1] + layer, minlength=shape[0] * shape[1]).reshape(shape)
        is_off = np.abs(area.argmax(1) - reach) > 1
        out[near[is_off[column]]] = True
    return out


def _slants(candidate: FacadeCandidate, facades: Sequence[FacadeCandidate], scene: FacadeScene) -> bool:
    """Decides whether a wall slants from all facades that it is nearly parallel to, and leaves their relief.

    A parallel layer, such as the front of a balcony, belongs to the facade behind it, and so does what is no
    wider than an opening: the side of a bay, the end of a rounded corner.
    """
    own = some_inliers(candidate, scene.cloud)
    if _span(candidate.wall.coordinates(own)[:, 0]) <= (1.0 - 2.0 * _END) * MASONRY.largest_opening:
        return False
    for facade in facades:
        if abs(candidate.wall.normal @ facade.wall.normal) < TOLERANCES.parallel_cos:
            continue
        depth = facade.wall.coordinates(own)[:, 1]
        leaves = np.quantile(np.abs(depth), 1.0 - _END) > RELIEF_M
        if _span(depth) < MASONRY.step_out or not leaves:
            return False
    return True


def _span(values: Float) -> float:
    """Returns how far values (n,) spread without the tenths at both ends."""
    return float(np.ptp(np.quantile(values, (_END, 1.0 - _END))))
