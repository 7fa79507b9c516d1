"""The datum: which of the seven freedoms of a block its control does not fix, and the constraints for them.

Image observations do not change when the whole block is shifted, turned or scaled. Freedoms that neither
priors nor point observations fix are removed by inner constraints on the poses: the result is the solution
whose poses change least from their approximate values (rotations weighted with the size of the block). It
also has the smallest sum of the variances of the poses.
"""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float
from frontage.orientation.adjustment.layout import Layout
from frontage.orientation.adjustment.linearise import Linearised
from frontage.orientation.adjustment.network import Network
from frontage.orientation.adjustment.state import State

_RANK = 1e-10  # of the derivatives of a prior: what changes it less is not fixed by it
_NOISE = (
    3.0  # standard errors of the point observations: what moves the block by its size, but them no farther
)
_SAME_PLACE_M = 1e-9  # m


@dataclass(frozen=True, eq=False)
class Datum:
    """The freedoms (u, d) of bodies and mounts that nothing fixes, and the constraints (u, d) on them."""

    freedoms: Float
    constraints: Float

    @property
    def defect(self) -> int:
        """The number d of freedoms."""
        return int(self.freedoms.shape[1])


def datum_of(network: Network, state: State, layout: Layout, rows: Linearised) -> Datum:
    """Finds the freedoms that the priors and point observations leave."""
    surfaces = network.surfaces.take(layout.surface_rows)
    miss = np.einsum("ki,ki->k", surfaces.direction, state.points[surfaces.point] - surfaces.at)
    # Where the observations are, not where the points are: their noise must not pass for information.
    places = state.points[surfaces.point] - miss[:, None] * surfaces.direction
    bodies, mounts, at_places, size = _moves(network, state, layout, places)
    free = _not_seen(np.einsum("ki,kij->kj", rows.surface, at_places), _NOISE * np.sqrt(len(places)) / size)
    for body, prior in enumerate(rows.priors):
        if prior is not None:
            strength = prior[0] @ bodies[body] @ free
            free = free @ _not_seen(strength, _RANK * float(np.abs(prior[0]).max()))
    free = free @ _not_seen(rows.mounts @ mounts @ free, _RANK * float(np.abs(rows.mounts).max(initial=0.0)))
    freedoms = np.zeros((layout.columns, free.shape[1]))
    freedoms[: 6 * layout.bodies] = bodies.reshape(6 * layout.bodies, -1) @ free
    freedoms[layout.all_mounts] = mounts @ free
    metric = np.ones(layout.columns)
    metric[: 6 * layout.bodies] = np.tile([1.0, 1.0, 1.0, size**2, size**2, size**2], layout.bodies)
    metric[layout.all_mounts] = 0.0  # the poses of the bodies alone are to change least
    return Datum(freedoms, freedoms * metric[:, None])


def _not_seen(seen: Float, least: float) -> Float:
    """The directions (f, d) in which rows (r, f) are not stronger than `least`."""
    width = seen.shape[1]
    _, strength, directions = np.linalg.svd(np.vstack([seen, np.zeros((width, width))]), full_matrices=False)
    return np.asarray(directions[strength <= least].T, np.float64)


def _moves(
    network: Network, state: State, layout: Layout, places: Float
) -> tuple[Float, Float, Float, float]:
    """How bodies (b, 6, f), columns of mounts (v, f) and places (k, 3, f) move, and the size in m.

    They are moved by shifts, turns and scale. Turns and scale are about the centre of the block, by as much
    as moves its edge by a metre. There is no freedom of scale where a rig has cameras at known distances.
    """
    everything = np.vstack([state.positions, state.points[layout.points]])
    centre = np.median(everything, axis=0)
    size = max(float(np.median(np.linalg.norm(everything - centre, axis=1))), 1e-9)
    bodies = np.zeros((layout.bodies, 6, 7))
    bodies[:, :3] = _shifts_turns_scale((state.positions - centre) / size)
    bodies[:, 3:, 3:6] = np.eye(3) / size
    # The scale acts on the projection centres; a body follows its cameras, or these move on the body.
    arms, carried, fixed = _scaled_arms(network, state, layout)
    bodies[:, :3, 6] += np.einsum("bij,bj->bi", state.rotations, carried) / size
    mounts = np.zeros((layout.columns - layout.all_mounts.start, 7))
    moved = [arms[i, free[free < 3]] for i, free in enumerate(layout.mounted)]
    turned = [np.zeros((free >= 3).sum()) for free in layout.mounted]
    mounts[:, 6] = np.concatenate([np.concatenate(pair) for pair in zip(moved, turned, strict=True)]) / size
    count = 6 if fixed else 7
    at_places = _shifts_turns_scale((places - centre) / size)
    return bodies[:, :, :count], mounts[:, :count], at_places[:, :, :count], size


def _scaled_arms(network: Network, state: State, layout: Layout) -> tuple[Float, Float, bool]:
    """How mounts (q, 3) and bodies (b, 3), in their own axes, move when all distances of cameras grow alike.

    The last value tells that mounts which are held do not let them. Only differences within a body count:
    ``change(mount) - mean = arm(mount) - mean`` over its photos, solved for the mounts that are estimated.
    """
    body, mount = network.photos.body, network.photos.mount
    at = np.zeros((layout.bodies, len(state.arms)))
    np.add.at(at, (body, mount), 1.0)
    at /= np.maximum(at.sum(axis=1, keepdims=True), 1.0)
    apart = np.eye(len(state.arms))[mount] - at[body]
    arms = np.zeros_like(state.arms)
    for axis in range(3):
        free = [i for i, f in enumerate(layout.mounted) if axis in f]
        arms[free, axis] = np.linalg.lstsq(apart[:, free], apart @ state.arms[:, axis], rcond=None)[0]
    left = apart @ (state.arms - arms)
    return arms, at @ (state.arms - arms), bool((np.abs(left) > _SAME_PLACE_M).any())


def _shifts_turns_scale(places: Float) -> Float:
    """The moves (n, 3, 7) of places (n, 3): three shifts, three turns, the scale."""
    moves = np.zeros((len(places), 3, 7))
    moves[:, :, :3] = np.eye(3)
    for axis in range(3):
        moves[:, :, 3 + axis] = np.cross(np.eye(3)[axis], places)
    moves[:, :, 6] = places
    return moves
