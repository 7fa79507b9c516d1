"""Thinned clouds do not depend on the order of the points."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from frontage.pipeline.clouds import Neighbourhoods, thin


def test_every_voxel_keeps_the_same_point_in_whatever_order_they_come():
    rng = np.random.default_rng(1)
    xyz = rng.uniform(0.0, 1.0, (5000, 3))
    kept = thin(xyz, 0.2)
    order = rng.permutation(len(xyz))
    assert len(kept) == 125
    assert np.array_equal(np.sort(order[thin(xyz[order], 0.2)]), kept)
    assert len(thin(xyz[:0], 0.2)) == 0


@pytest.mark.parametrize(
    "spread", [1.0, 1e4]
)  # keys that fit into one number with their rows, and that do not
@pytest.mark.parametrize("step", [0.001, 0.02])  # of the coordinates, so that several are least in x
def test_a_voxel_keeps_the_point_least_in_x_then_y_then_z(spread, step):
    rng = np.random.default_rng(2)
    voxels = rng.integers(0, 5, (3000, 3)) * (spread / 0.1)
    xyz = np.vstack(
        [np.zeros(3), 0.1 * voxels + rng.integers(0, round(0.09 / step), (3000, 3)) * step + 0.005]
    )
    kept = thin(xyz, 0.1)
    best = {}
    for row, point in enumerate(xyz.tolist()):
        cell = tuple(np.floor(np.array(point) / 0.1).astype(int).tolist())
        best[cell] = min(best.get(cell, (point, row)), (point, row))
    assert kept.tolist() == sorted(row for _, row in best.values())


def test_surroundings_are_the_points_in_cells_within_reach_ascending():
    rng = np.random.default_rng(3)
    xyz = rng.uniform(-40.0, 40.0, (4000, 3))
    own = np.flatnonzero(np.abs(xyz[:, :2]).max(1) < 2.0)
    near = Neighbourhoods(xyz).around(own, reach=5.0)
    away = np.linalg.norm(xyz[:, None, :2] - xyz[own, :2], axis=2).min(1)
    assert np.all(np.diff(near) > 0)
    assert set(np.flatnonzero(away < 3.0)) <= set(near) <= set(np.flatnonzero(away < 8.0))


def test_what_remains_of_the_surroundings_depends_on_no_order_and_leaves_no_voxel_empty(monkeypatch):
    monkeypatch.setattr("frontage.pipeline.clouds._MANY", 2000)
    rng = np.random.default_rng(0)
    xyz = rng.uniform(0.0, (6.0, 6.0, 0.5), (40_000, 3))
    kept = Neighbourhoods(xyz).thinned(np.arange(len(xyz)))
    turn = rng.permutation(len(xyz))
    again = turn[Neighbourhoods(xyz[turn]).thinned(np.arange(len(xyz)))]
    assert np.array_equal(np.sort(again), kept)
    assert len(kept) < 0.9 * len(xyz)
    assert cKDTree(xyz[kept]).query(xyz)[0].max() < 0.05 * np.sqrt(3.0)
