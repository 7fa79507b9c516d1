"""The published method on painted photos whose bars are known."""

from collections.abc import Sequence

import numpy as np
import pytest

from crossbars.painted import (
    BAR,
    DEPTH,
    DIVISIONS,
    EYES,
    MULLION,
    TRANSOM,
    X0,
    X1,
    Z0,
    Z1,
    Box,
    bar,
    centres,
    view,
    window,
)
from frontage.crossbars.options import CrossbarOptions
from frontage.crossbars.paper.find import bars_by_edges
from frontage.model import Glazing, Provenance

OPTIONS = CrossbarOptions(method="paper")


def find(bars: Sequence[Box], eyes: Sequence[tuple[float, float, float]] = EYES, **how: object) -> Glazing:
    return bars_by_edges([window([view(eye, bars, **how) for eye in eyes])], OPTIONS)[0]


@pytest.mark.parametrize("bars", DIVISIONS.values(), ids=DIVISIONS)
def test_layouts_are_exact(bars: list[Box]) -> None:
    found = find(bars)
    assert found.resolved
    for axis, upright in (("vertical", True), ("horizontal", False)):
        own = [b for b in found.bars if b.axis == axis]
        assert [b.position for b in own] == pytest.approx(centres(bars, upright), abs=0.005)
        assert [b.width for b in own] == pytest.approx([BAR] * len(own), abs=0.008)
        assert all(0.0 < b.sigma < 0.02 and b.provenance == Provenance.MEASURED for b in own)
    assert 0.5 < found.confidence <= 1.0
    assert found.sources == tuple(sorted(view(eye, gsd=0.05).photo.id for eye in EYES))


def test_a_mullion_below_a_transom_ends_there() -> None:
    upright, level = find([TRANSOM, bar("vertical", 0.0, Z0, 2.8)]).bars
    assert upright.extent == pytest.approx((Z0 + 0.07, 2.8), abs=0.04)
    assert level.extent == pytest.approx((X0 + 0.07, X1 - 0.07), abs=0.01)


def test_two_photos_suffice_as_in_the_paper() -> None:
    found = find([MULLION, TRANSOM], EYES[:2])
    assert found.counts == (1, 1)
    assert [b.position for b in found.bars] == pytest.approx([0.02, 2.8], abs=0.006)


def test_no_bars_are_an_answer() -> None:
    found = find([])
    assert found.resolved
    assert found.bars == ()
    assert found.confidence > 0.5


def test_a_striped_curtain_behind_the_glass_is_not_a_row_of_mullions() -> None:
    found = find([MULLION], curtain=True)
    assert found.counts == (1, 0)
    assert found.bars[0].position == pytest.approx(0.02, abs=0.006)


def test_depth_comes_from_the_edges_and_not_from_the_scan() -> None:
    views = [view(eye, [MULLION]) for eye in EYES]
    for given in (None, DEPTH + 0.02):
        depth = bars_by_edges([window(views, depth=given)], OPTIONS)[0].depth
        assert depth is not None
        assert float(depth.value) == pytest.approx(DEPTH, abs=0.006)
        assert 0.0 < float(depth.sigma[0]) < 0.01


def test_a_shift_between_scan_and_photos_moves_no_bar() -> None:
    views = [view(eye, [MULLION, TRANSOM]) for eye in EYES]
    shifted = (X0 + 0.03, Z0 + 0.02, X1 + 0.03, Z1 + 0.02)
    found = bars_by_edges([window(views, shifted, sigma=0.03)], OPTIONS)[0]
    assert found.counts == (1, 1)
    assert [b.position for b in found.bars] == pytest.approx([0.02, 2.8], abs=0.005)


def test_dark_bars_before_a_bright_room_are_measured_too() -> None:
    views = [view(eye, [MULLION]) for eye in EYES]
    dark = [type(v)(v.photo, 255 - v.pixels, v.corner, v.visible, v.gsd, v.cosine) for v in views]
    found = bars_by_edges([window(dark)], OPTIONS)[0]
    assert found.counts == (1, 0)
    assert found.bars[0].position == pytest.approx(0.02, abs=0.004)
    assert found.bars[0].width == pytest.approx(BAR, abs=0.008)


def test_transoms_in_photos_from_one_height_lie_on_the_plane_of_the_mullions() -> None:
    views = [view((x, -6.0, 0.0), [MULLION, TRANSOM]) for x in (-1.5, 0.0, 1.5)]
    found = bars_by_edges([window(views, depth=DEPTH + 0.02)], OPTIONS)[0]
    assert found.counts == (1, 1)
    assert found.bars[1].position == pytest.approx(2.8, abs=0.003)  # by the scan's depth 9 mm too high
    assert 0.0005 < found.bars[1].sigma < 0.005


@pytest.mark.parametrize(
    ("eyes", "how", "why"),
    [
        (EYES[:1], {}, "only one photo"),
        ([EYES[0], (-2.49, -6.0, 1.6)], {}, "too close together"),
        (EYES, {"sigma_pose": 0.3}, "of the 3 photos that show it 0 can be used"),
        (EYES, {"gsd": 0.015}, "too coarse"),
    ],
)
def test_what_cannot_be_decided_is_not_resolved(
    eyes: Sequence[tuple[float, float, float]], how: dict[str, float], why: str
) -> None:
    found = find([], eyes, **how)
    assert not found.resolved
    assert found.bars == ()
    assert why in found.note


def test_a_window_without_photos_is_not_resolved() -> None:
    found = bars_by_edges([window([])], OPTIONS)[0]
    assert not found.resolved
    assert found.note == "no photo shows it"


def test_neighbours_of_the_same_size_lend_their_bars() -> None:
    clear = window([view(eye, [MULLION, TRANSOM]) for eye in EYES])
    beside = (X0 + 2, Z0, X1 + 2, Z1)
    single = window([view(EYES[0], [], beside)], beside, "B01/F1/W1-2")
    other = window([view(EYES[0], [], (4.0, 2.0, 4.8, 3.6))], (4.0, 2.0, 4.8, 3.6), "B01/F1/W1-3")
    _, lent, none = bars_by_edges([clear, single, other], OPTIONS)
    assert [b.position for b in lent.bars] == pytest.approx([2.02, 2.8], abs=0.006)
    assert {b.provenance for b in lent.bars} == {Provenance.POOLED}
    assert "windows of the same kind" in lent.note
    assert not none.resolved


def test_the_order_of_windows_and_views_does_not_matter() -> None:
    views = [view(eye, [MULLION, TRANSOM]) for eye in EYES]
    a = bars_by_edges([window(views)], OPTIONS)[0]
    b = bars_by_edges([window(views[::-1])], OPTIONS)[0]
    assert np.allclose([x.position for x in a.bars], [x.position for x in b.bars], atol=1e-3)
    assert bars_by_edges([], OPTIONS) == []
