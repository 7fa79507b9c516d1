"""Rays: the right triangle, distances exact to float64, and subsets of a mesh."""

import numpy as np
import pytest

from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import SceneMesh


def panes(offset: float = 0.0) -> SceneMesh:
    """Two squares of 4 m side facing -y, at y = 10 (surface 0) and y = 12 (surface 1), moved by `offset`."""
    square = np.array([[-2, 0, -2], [2, 0, -2], [2, 0, 2], [-2, 0, 2]], np.float64)
    vertices = np.vstack([np.add(square, [offset, y, 0]) for y in (10, 12)])
    corners = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]
    return SceneMesh(vertices, np.array(corners), np.array([0, 0, 1, 1]))


def fan(n: int = 500) -> np.ndarray:
    """Unit directions (n, 3) within 10 degrees of +y."""
    rng = np.random.default_rng(0)
    d = np.column_stack([rng.uniform(-0.15, 0.15, n), np.ones(n), rng.uniform(-0.15, 0.15, n)])
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def test_first_hit_is_the_nearest_and_exact_far_from_zero() -> None:
    shift = 4321.123
    tracer, d = Tracer(panes(shift)), fan()
    hits = tracer.first_hit(np.array([shift + 0.1, 0.2, 0.3]), d)
    assert set(hits.triangle) == {0, 1}
    np.testing.assert_allclose(hits.distance, 9.8 / d[:, 1], atol=1e-9)


def test_skip_starts_behind_a_surface() -> None:
    hits = Tracer(panes()).first_hit(np.array([0.0, 10.0, 0.0]), fan(), skip=1e-3)
    assert set(hits.triangle) == {2, 3}
    np.testing.assert_allclose(hits.distance, 2 / fan()[:, 1], atol=1e-9)


def test_rays_that_miss_have_no_triangle() -> None:
    hits = Tracer(panes()).first_hit(np.zeros(3), -fan(5))
    assert not hits.found.any() and np.isinf(hits.distance).all()


def test_hits_on_a_subset_index_the_whole_mesh() -> None:
    hits = Tracer(panes(), keep=np.array([False, False, True, True])).first_hit(np.zeros(3), fan())
    assert set(hits.triangle) == {2, 3}
    nothing = Tracer(panes(), keep=np.zeros(4, bool))
    assert not nothing.first_hit(np.zeros(3), fan()).found.any()
    assert not nothing.blocked(np.zeros(3), fan(), np.inf).any()
    with pytest.raises(ValueError, match="keep"):
        Tracer(panes(), keep=np.ones(3, bool))


def test_blocked_ignores_what_lies_beyond_the_reach() -> None:
    tracer, up = Tracer(panes()), np.array([[0.0, 1.0, 0.0]] * 3)
    assert tracer.blocked(np.zeros(3), up, np.array([9.9, 10.1, np.inf])).tolist() == [False, True, True]
    assert tracer.blocked(np.zeros(3), -up, np.inf).tolist() == [False] * 3


def test_rays_along_a_plane_stay_finite() -> None:
    edge_on = np.array([[1.0, 1e-9, 0.0]])
    hits = Tracer(panes()).first_hit(np.array([-5.0, 10.0, 0.0]), edge_on)
    assert not np.isnan(hits.distance).any()
