"""Window bars from points alone: what a scanner in the street sees of a frame behind its sill."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from crossbars.painted import BAR, DEPTH, EYES, FRAME, HOLE, MULLION, TRANSOM, Box, bar, view, window
from frontage.crossbars.border import scanned_sides
from frontage.crossbars.evidence import bars_by_evidence
from frontage.crossbars.exposure import exposed_box
from frontage.crossbars.options import CrossbarOptions
from frontage.crossbars.scanbars import _CELL_M, _pane_density
from frontage.crossbars.window import Window
from frontage.geometry.arrays import Float
from frontage.model import Glazing

X0, Z0, X1, Z1 = HOLE
SIDES: list[Box] = [
    (X0, Z0, X0 + FRAME, Z1),
    (X1 - FRAME, Z0, X1, Z1),
    (X0, Z0, X1, Z0 + FRAME),
    (X0, Z1 - FRAME, X1, Z1),
]


def points(bars: Sequence[Box], spacing: float, sill: float, depth: float = DEPTH, seed: int = 0) -> Float:
    """Returns points (n, 3) of the frame and bars, as dense everywhere, above what the sill hides."""
    rng = np.random.default_rng(seed)
    n = round((X1 - X0) * (Z1 - Z0) / spacing**2)
    xz = rng.uniform([X0, Z0], [X1, Z1], (n, 2))
    on = np.any([((xz > b[:2]) & (xz < b[2:])).all(1) for b in [*SIDES, *bars]], axis=0)
    xz = xz[on & (xz[:, 1] > Z0 + sill)]
    return np.column_stack([xz[:, 0], depth + rng.normal(0, 0.004, len(xz)), xz[:, 1]])


def scanned(bars: Sequence[Box], spacing: float = 0.02, sill: float = 0.2, seed: int = 0) -> Window:
    return replace(window([]), points=points(bars, spacing, sill, seed=seed), spacing=spacing)


def find(one: Window) -> Glazing:
    return bars_by_evidence([one], CrossbarOptions())[0].glazing


@pytest.mark.parametrize("spacing", [0.01, 0.02, 0.035])
@pytest.mark.parametrize("bars", [[], [MULLION], [MULLION, TRANSOM]], ids=["none", "mullion", "cross"])
def test_bars_are_found_whole_though_the_sill_hides_their_lower_ends(bars: list[Box], spacing: float) -> None:
    found = find(scanned(bars, spacing))
    assert found.resolved, found.note
    assert found.counts == (MULLION in bars, TRANSOM in bars)
    for one in found.bars:
        true = 0.02 if one.axis == "vertical" else 2.8
        assert one.position == pytest.approx(true, abs=0.012)
        assert one.width == pytest.approx(BAR, abs=0.025)
        low, high = (Z0, Z1) if one.axis == "vertical" else (X0, X1)
        assert one.extent == pytest.approx((low, high), abs=FRAME + 0.02)


def test_a_frame_is_exposed_above_what_its_sill_hides() -> None:
    box = exposed_box(window([]).ring, points([MULLION], 0.02, 0.25), 2500.0)
    assert box == pytest.approx((X0, Z0 + 0.25, X1, Z1), abs=0.025)


def test_sides_of_the_frame_are_measured_where_beams_reach_them() -> None:
    ring = window([]).ring
    seen = points([MULLION, TRANSOM], 0.02, 0.25)
    box, width = scanned_sides(ring, np.array(exposed_box(ring, seen, 2500.0)), seen, 2500.0)
    assert box[0] == pytest.approx(X0 + FRAME, abs=0.015)
    assert box[3] == pytest.approx(Z1 - FRAME, abs=0.015)
    assert box[1] < Z0 + 0.05  # nothing shows the lower one
    assert width is not None and width.value == pytest.approx(FRAME, abs=0.015)


def test_a_blind_close_behind_the_glass_leaves_nothing_to_decide() -> None:
    rng = np.random.default_rng(1)
    blind = rng.uniform([X0 + FRAME, 0.16, Z0 + 0.2], [X1 - FRAME, 0.17, Z1 - FRAME], (2300, 3))
    one = scanned([MULLION])
    found = find(replace(one, points=np.concatenate([one.points, blind])))
    assert not found.resolved
    assert "panes from bars" in found.note


def test_a_sparse_scan_decides_nothing_and_says_why() -> None:
    found = find(scanned([MULLION], spacing=0.07))
    assert not found.resolved and not found.bars
    assert "too sparse" in found.note


def test_a_window_that_is_mostly_hidden_is_left_undecided() -> None:
    found = find(scanned([MULLION], sill=0.7))
    assert not found.resolved
    assert "the scanner sees" in found.note


def test_a_window_may_have_one_bar_elsewhere_than_others_of_its_type() -> None:
    lower = bar("horizontal", 2.7, X0, X1)
    windows = [scanned([MULLION, TRANSOM], 0.03, seed=k) for k in range(3)]
    windows.append(scanned([MULLION, lower], 0.03, seed=3))
    found = [one.glazing for one in bars_by_evidence(windows, CrossbarOptions())]
    level = [next(b for b in one.bars if b.axis == "horizontal").position for one in found]
    assert level == pytest.approx([2.8, 2.8, 2.8, 2.7], abs=0.02)


def test_coupled_windows_have_a_layout_on_each_side() -> None:
    left, right = bar("vertical", -0.2, Z0, Z1), bar("vertical", 0.2, Z0, Z1)
    windows = [scanned([(left, right)[k % 2], TRANSOM], 0.03, seed=k) for k in range(6)]
    found = [one.glazing for one in bars_by_evidence(windows, CrossbarOptions())]
    upright = [[b.position for b in one.bars if b.axis == "vertical"] for one in found]
    assert [len(one) for one in upright] == [1] * 6
    assert [x[0] for x in upright] == pytest.approx([-0.2, 0.2] * 3, abs=0.02)


def test_windows_of_one_type_decide_together_what_each_shows_in_part() -> None:
    """A sparse scan leaves each of them undecided on its own."""
    windows = [scanned([MULLION, TRANSOM], 0.045, seed=k) for k in range(8)]
    alone = [find(one).resolved for one in windows]
    found = [one.glazing for one in bars_by_evidence(windows, CrossbarOptions())]
    assert sum(one.resolved for one in found) > sum(alone)
    assert all(one.counts == (1, 1) for one in found if one.resolved)


@pytest.mark.parametrize("spacing", [0.01, 0.014, 0.02])
def test_the_curved_head_of_a_frame_is_no_bar(spacing: float) -> None:
    radius, middle = (X1 - X0) / 2, np.array([(X0 + X1) / 2, Z1 - (X1 - X0) / 2])
    turn = np.linspace(0.0, np.pi, 25)
    head = middle + radius * np.column_stack([np.cos(turn), np.sin(turn)])
    ring = np.vstack([[[X0, Z0], [X1, Z0]], head])
    one = scanned([MULLION, (X0, Z0, X1, Z1)], spacing)
    x, z = one.points[:, 0], one.points[:, 2]
    away = np.hypot(*(one.points[:, ::2] - middle).T)
    curved = (away < radius) & (away > radius - FRAME) & (z > middle[1])
    straight = (np.abs(x) > radius - FRAME) & (z < middle[1]) & (z > Z0 + 0.2)
    own = curved | straight | ((np.abs(x - 0.02) < BAR / 2) & (away < radius)) | (z < Z0 + FRAME)
    opening = replace(one.opening, ring=ring, ring_covariance=np.eye(2 * len(ring)) * 1e-6, shape="round")
    found = find(replace(one, opening=opening, points=one.points[own]))
    assert found.resolved, found.note
    assert found.counts == (1, 0)


def test_a_window_that_only_the_scan_shows_takes_the_layout_of_those_that_photos_show() -> None:
    photographed = [replace(window([view(e, [MULLION]) for e in EYES]), spacing=0.03) for _ in range(3)]
    hidden = scanned([MULLION], 0.03)
    for order in ([hidden, *photographed], [*photographed, hidden]):
        found = [one.glazing for one in bars_by_evidence(order, CrossbarOptions())]
        assert all(one.resolved and one.counts == (1, 0) for one in found)


def test_panes_of_a_dense_scan_have_a_density_without_overflow() -> None:
    count = np.zeros((40, 40))
    count[::8] = count[:, ::8] = 400.0  # points of bars in cells of one density
    bars = 300.0 / _CELL_M**2
    assert _pane_density(count, bars)[2, 2] < 0.1 * bars
