"""The steps of the published method: edge points, segments, matches, 3-D edges, templates, neighbours."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from crossbars.painted import EYES, HOLE, Box, bar, view, window
from frontage.crossbars.paper.derive import derive_edges
from frontage.crossbars.paper.edges import straight_edges
from frontage.crossbars.paper.matching import match
from frontage.crossbars.paper.neighbours import neighbours
from frontage.crossbars.paper.plane import frame_plane, image_region
from frontage.crossbars.paper.seen import Sight, seen_edges
from frontage.crossbars.paper.templates import Line, divide, joined, support
from frontage.crossbars.paper.triangulate import NO_EDGES, Edges3D, plausible, triangulate
from frontage.geometry.ring import rectangle

MULLION = bar("vertical", 0.02, HOLE[1], HOLE[3])


def picture(*corners: tuple[float, float], size: int = 80) -> np.ndarray:
    """A bright polygon on dark ground, antialiased by a factor of 16."""
    big = np.zeros((16 * size, 16 * size), np.float32)
    cv2.fillPoly(big, [np.round(np.array(corners) * 16).astype(np.int32)], 100.0)
    return cv2.resize(big, (size, size), interpolation=cv2.INTER_AREA)


def test_edges_are_straight_and_exact_to_a_tenth_of_a_pixel() -> None:
    grey = picture((20.3, 10), (60, 10), (60, 70), (20.3, 70))
    grey += np.random.default_rng(1).normal(0, 1, grey.shape).astype(np.float32)
    found = straight_edges(grey, np.ones(grey.shape, bool))
    left = [k for k, e in enumerate(found.ends) if abs(e[:, 0] - 20.3).max() < 2 and np.ptp(e[:, 1]) > 40]
    assert len(left) == 1
    assert found.ends[left[0]][:, 0] == pytest.approx(20.3, abs=0.12)
    assert 0.05 < found.sigma[left[0]] < 0.3


def test_a_bent_chain_is_split_into_straight_pieces() -> None:
    grey = picture((5, 40), (40, 33), (75, 40), (75, 75), (5, 75))
    found = straight_edges(grey, np.ones(grey.shape, bool))
    top = found.ends[found.ends[:, :, 1].max(1) < 42]
    assert len(top) == 2
    assert np.abs(np.diff(top[:, :, 1])) == pytest.approx(7, abs=1.5)


def test_nothing_is_looked_for_outside_the_region() -> None:
    grey = picture((20, 10), (60, 10), (60, 70), (20, 70))
    region = np.zeros(grey.shape, bool)
    region[:, 40:] = True
    found = straight_edges(grey, region)
    assert len(found) == 3
    assert found.ends[..., 0].min() > 39
    assert len(straight_edges(grey, np.zeros(grey.shape, bool))) == 0


def test_the_region_of_a_window_leaves_out_what_its_sill_hides() -> None:
    v = view((0.0, -4.0, 0.5), [])
    w = window([v])
    rows = np.flatnonzero(image_region(v, w, frame_plane(w)).any(1))
    sill, head = v.project(w.frame, np.array([[0.0, 0.0, HOLE[1]], [0.0, 0.15, HOLE[3]]]))[:, 1]
    assert 2 < sill - rows.max() < 10  # the front edge of the sill, not the frame behind it
    assert 2 < rows.min() - head < 10


def test_wrong_matches_lead_to_edges_that_are_rejected() -> None:
    bars = [bar("vertical", x, HOLE[1], HOLE[3]) for x in (-0.2, 0.02, 0.24)]
    w = window([view(eye, bars) for eye in (EYES[0], EYES[2])])
    plane = frame_plane(w)
    a, b = (seen_edges(Sight.of(v, w, plane), plane.y, 0, 0.005, 0.06) for v in w.views)
    matches = match(a, b, plane)
    edges = triangulate(a, b, matches, plane, 0)
    kept = edges.kept(plausible(edges, w.ring, 0))
    assert len(edges) >= len(kept) + 4  # of a bar with its neighbour, half a metre before or behind
    true = np.array([x + side for x in (-0.2, 0.02, 0.24) for side in (-0.02, 0.02)] + [-0.44, 0.44])
    assert np.abs(kept.across[:, None] - true).min(1).max() < 0.006
    assert np.abs(kept.behind).max() < 0.02


def test_an_oblique_edge_is_not_a_bar() -> None:
    straight = derive_edges(window([view(eye, [MULLION]) for eye in EYES]), 0.12).upright
    leaning = replace(straight, oblique=straight.oblique + np.array([0.15, 0.0]))
    assert plausible(straight, window([]).ring, 0).all()
    assert not plausible(leaning, window([]).ring, 0).any()


def edges(*places: tuple[float, float, float]) -> Edges3D:
    """3-D edges at `across`, from where to where along."""
    p = np.array(places).reshape(-1, 3)
    n = len(p)
    two = np.full((n, 2), 0.002)
    one = np.zeros(n)
    return Edges3D(
        p[:, 0], p[:, 1:], one, two, two * 0, two, one, np.where(np.arange(n) % 2, -50.0, 50.0), one
    )


def layout(upright: Edges3D, level: Edges3D, least: float = 0.12) -> list[Line]:
    box: Box = (-0.5, -0.8, 0.5, 0.8)
    by = tuple(support([e], rectangle(*box), axis, 0.04) for axis, e in enumerate((upright, level)))
    return joined(divide(box, (by[0], by[1]), least, 0.04).lines, 0.08)


def test_both_edges_of_a_bar_make_one_dividing_line() -> None:
    (line,) = layout(edges((-0.02, -0.7, 0.7), (0.02, -0.7, 0.7)), NO_EDGES)
    assert line.axis == 0
    assert line.position == pytest.approx(0.0, abs=0.011)
    assert line.support == pytest.approx(1.4 / 1.6, abs=0.03)


def test_two_lines_divide_into_three_parts() -> None:
    lines = layout(edges((-0.15, -0.8, 0.8), (0.15, -0.8, 0.8)), NO_EDGES)
    assert sorted(line.position for line in lines) == pytest.approx([-0.15, 0.15], abs=0.04)


def test_the_recursion_stops_at_the_least_pane_in_both_directions() -> None:
    close = edges((-0.1, -0.8, 0.8), (0.1, -0.8, 0.8))
    assert len(layout(close, NO_EDGES, 0.1)) == 2
    assert len(layout(close, NO_EDGES, 0.3)) == 1
    assert len(layout(NO_EDGES, close, 0.1)) == 2
    assert len(layout(NO_EDGES, close, 0.3)) == 1


def test_a_line_that_half_its_length_does_not_carry_is_refused() -> None:
    assert layout(edges((0.0, -0.8, -0.1)), NO_EDGES) == []
    assert len(layout(edges((0.0, -0.8, 0.1)), NO_EDGES)) == 1


def test_bars_go_on_across_the_bars_that_cross_them() -> None:
    upright = edges((0.0, -0.8, 0.28), (0.0, 0.32, 0.8))
    level = edges((0.3, -0.5, -0.02), (0.3, 0.02, 0.5))
    lines = layout(upright, level)
    assert sorted((line.axis, round(line.extent[0], 2)) for line in lines) == [(0, -0.8), (1, -0.5)]


def test_groups_are_windows_of_one_size_in_a_row_or_column() -> None:
    def at(x: float, z: float, wide: float = 1.0) -> Box:
        return (x, z, x + wide, z + 1.6)

    boxes = [at(0, 2), at(2, 2), at(2, 5), at(4, 2, 1.2), at(7.3, 8.1)]
    groups = neighbours([window([], box) for box in boxes])
    assert sorted(map(tuple, groups)) == [(0, 1, 2), (3,), (4,)]
    assert neighbours([]) == []
