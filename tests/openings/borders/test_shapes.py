"""Heads of openings: told apart, measured without bias, and rings that follow their parameters."""

import numpy as np
import pytest

from frontage.geometry.ring import ring_area, ring_contains
from frontage.openings.borders.circles import find_circle
from frontage.openings.borders.fan import Fan, outward
from frontage.openings.borders.shapes import Head, find_head, ring_of, strays

BOX = (1.0, 2.0, 2.2, 4.0)
HEADS = [
    ("rectangle", 0.0),
    ("segmental", 0.2),
    ("round", 0.6),
    ("pointed", 0.6 * 3**0.5),
    ("triangular", 0.4),
]


def fan_about(ring, count=6000, seed=3, returned=1.0):
    p = np.random.default_rng(seed).uniform((0.5, 1.5), (2.7, 4.5), (count, 2))
    inside = ring_contains(ring, p)
    kept = ~inside | (np.arange(count) % 10 < 10 * returned)
    density = count / 6.6
    return Fan(p[kept, 0], p[kept, 1], ~inside[kept], density * (1.0 - returned))


@pytest.mark.parametrize(("shape", "rise"), HEADS)
@pytest.mark.parametrize("returned", [1.0, 0.0])
def test_heads_are_told_apart_and_measured(shape, rise, returned):
    head = find_head(fan_about(ring_of(shape, BOX, rise)[0], returned=returned), BOX, 0.002)
    assert head.shape == shape
    if shape != "rectangle":
        assert abs(head.top - 4.0) < 0.012 and abs(head.rise - rise) < 0.04
        assert 0.0 < np.sqrt(head.covariance[0]) < 0.01


@pytest.mark.parametrize(("place", "half"), [(1.6, 0.12), (1.6, 0.3), (1.6, 0.4), (1.8, 0.4), (1.4, 0.5)])
def test_the_shadow_of_a_post_above_a_window_is_no_curved_head(place, half):
    fan = fan_about(ring_of("rectangle", (1.0, 2.0, 2.2, 3.4), 0.0)[0], returned=0.1)
    shade = (np.abs(fan.x - place) < half) & fan.solid  # crosses the window and the wall above it
    seen = Fan(fan.x[~shade], fan.z[~shade], fan.solid[~shade], fan.missing)
    head = find_head(seen, (1.0, 2.0, 2.2, 3.6), 0.002)
    assert head.shape == "rectangle" and abs(head.top - 3.4) < 0.02


@pytest.mark.parametrize(("shape", "rise"), HEADS[1:])
def test_tops_are_unbiased_and_their_sigmas_honest(shape, rise):
    ring = ring_of(shape, BOX, rise)[0]
    found = [find_head(fan_about(ring, 3000, seed), BOX, 0.002) for seed in range(12)]
    error = np.array([h.top - 4.0 for h in found])
    sigma = np.sqrt([h.covariance[0] for h in found])
    assert abs(error.mean()) < 0.003
    assert 0.3 < np.sqrt(np.mean((error / np.maximum(sigma, 5e-4)) ** 2)) < 2.0


def test_a_circle_is_no_square():
    p = np.random.default_rng(4).uniform((0.5, 1.5), (2.5, 3.5), (6000, 2))
    box = (1.0, 2.0, 2.0, 3.0)
    inside = ring_contains(ring_of("circle", box, 0.0)[0], p)
    found = find_circle(Fan(p[:, 0], p[:, 1], ~inside, 0.0), box, 0.002)
    assert found is not None
    assert found.gain > 10 and abs(found.radius - 0.5) < 0.01 and 0 < found.sigma < 0.01
    square = np.abs(p - (1.5, 2.5)).max(1) < 0.5
    found = find_circle(Fan(p[:, 0], p[:, 1], ~square, 0.0), box, 0.002)
    assert found is not None and found.gain < 0
    assert find_circle(Fan(p[:, 0], p[:, 1], ~square, 0.0), (1.0, 2.0, 2.0, 4.0), 0.002) is None


def test_the_centre_of_a_circle_need_not_be_that_of_its_box_and_its_foot_may_be_hidden():
    p = np.random.default_rng(5).uniform((0.5, 1.5), (2.5, 3.5), (8000, 2))
    box = (1.0, 2.0, 2.0, 3.0)
    inside = ring_contains(ring_of("circle", box, 0.0)[0], p)
    seen = p[:, 1] > 2.06  # a sill hides the rest
    fan = Fan(p[seen, 0], p[seen, 1], ~inside[seen], 0.0)
    for guess in ((1.03, 2.07, 1.96, 2.98), (0.99, 2.05, 1.98, 3.03)):
        found = find_circle(fan, guess, 0.002)
        assert found is not None and found.gain > 10
        assert np.allclose(found.box, box, atol=0.012)


def test_where_the_scan_ends_across_a_window_nothing_is_round():
    p = np.random.default_rng(6).uniform((0.5, 1.5), (2.5, 3.5), (6000, 2))
    box = (1.0, 2.0, 2.0, 3.0)
    square = np.abs(p - (1.5, 2.5)).max(1) < 0.5
    for way in (1.0, -1.0):  # of the end, upwards to the right or to the left
        seen = p[:, 1] - 2.5 < 0.1 + way * (p[:, 0] - 1.5)
        assert find_circle(Fan(p[seen, 0], p[seen, 1], ~square[seen], 0.0), box, 0.002) is None


def test_an_arch_over_a_square_is_no_circle():
    box = (1.0, 2.0, 2.0, 3.1)
    arch, circle = ring_of("round", box, 0.5)[0], ring_of("circle", (1.0, 2.05, 2.0, 3.05), 0.0)[0]
    fan = fan_about(arch)
    assert strays(fan, arch) < strays(fan, circle)
    assert find_head(fan, box, 0.002).shape == "round"


@pytest.mark.parametrize(("shape", "rise"), [*HEADS, ("circle", 0.0)])
def test_borders_look_outwards_at_right_angles(shape, rise):
    box = (1.0, 2.0, 2.2, 3.2) if shape == "circle" else BOX
    ring = ring_of(shape, box, rise)[0]
    ends = np.roll(ring, -1, axis=0)
    along = (ends - ring) / np.linalg.norm(ends - ring, axis=1, keepdims=True)
    middle = (ring + ends) / 2
    # what is below the springing looks sideways; a straight head is looked at from the opening's middle
    some = np.abs(along[:, 1]) > 1e-6 if shape == "rectangle" else middle[:, 1] > box[1] + 0.01
    looks = outward(shape, rise, box, middle[some].T).T
    looks = looks / np.linalg.norm(looks, axis=1, keepdims=True)
    normals = np.column_stack([along[:, 1], -along[:, 0]])[some]
    assert ((looks * normals).sum(1) > (0.5 if shape == "rectangle" else 0.99)).all()


def test_a_known_head_is_looked_for_at_any_rise():
    ring = ring_of("triangular", BOX, 0.9)[0]
    head = find_head(fan_about(ring), BOX, 0.002, Head("triangular", 4.0, 0.5, 0.0))
    assert abs(head.top - 4.0) < 0.012 and abs(head.rise - 0.9) < 0.04


@pytest.mark.parametrize(("shape", "rise"), [*HEADS, ("circle", 0.0)])
def test_rings_follow_their_parameters(shape, rise):
    box = (1.0, 2.0, 2.2, 3.2) if shape == "circle" else BOX
    ring, weights = ring_of(shape, box, rise)
    assert ring_area(ring) > 0
    assert np.allclose(np.r_[ring.min(0), ring.max(0)], box, atol=2e-3)
    shift = np.array([0.003, -0.002, 0.001, 0.004, 0.002 if rise else 0.0])
    moved = (box[0] + shift[0], box[1] + shift[2], box[2] + shift[1], box[3] + shift[3])
    other, _ = ring_of(shape, moved, rise + shift[4])
    assert np.allclose(ring.ravel() + weights @ shift, other.ravel(), atol=2e-4)
