"""The better estimator on painted photos whose bars are known."""

from collections.abc import Sequence

import numpy as np
import pytest

from crossbars.painted import BAR, DEPTH, DIVISIONS, EYES, MULLION, TRANSOM, Box, centres, view, window
from frontage.crossbars.evidence import bars_by_evidence
from frontage.crossbars.options import CrossbarOptions
from frontage.model import Glazing, Provenance

OPTIONS = CrossbarOptions()
CROSS = (MULLION, TRANSOM)


def find(bars: Sequence[Box], eyes: Sequence[tuple[float, float, float]] = EYES, **how: object) -> Glazing:
    return bars_by_evidence([window([view(eye, bars, **how) for eye in eyes])], OPTIONS)[0].glazing


@pytest.mark.parametrize("bars", [[], *DIVISIONS.values()], ids=["none", *DIVISIONS])
def test_layouts_are_exact(bars: list[Box]) -> None:
    found = find(bars)
    assert found.resolved and found.confidence > 0.5
    for axis, upright in (("vertical", True), ("horizontal", False)):
        own = [b for b in found.bars if b.axis == axis]
        assert [b.position for b in own] == pytest.approx(centres(bars, upright), abs=0.008)
        assert [b.width for b in own] == pytest.approx([BAR] * len(own), abs=0.012)
        assert all(0.0005 < b.sigma < 0.02 for b in own)


def test_a_striped_curtain_behind_the_glass_is_no_bar() -> None:
    found = find([MULLION], curtain=True)
    assert [(b.axis, round(b.position, 2)) for b in found.bars] == [("vertical", 0.02)]


def test_the_depth_of_the_frame_comes_from_the_photos() -> None:
    views = [view(eye, CROSS) for eye in EYES]
    found = bars_by_evidence([window(views, depth=None)], OPTIONS)[0].glazing
    assert found.depth is not None
    assert found.depth.value == pytest.approx(DEPTH, abs=0.015)
    assert 0.001 < float(found.depth.sigma[0]) < 0.1


def test_one_photo_is_enough_and_flagged() -> None:
    found = find(CROSS, EYES[1:2])
    assert found.counts == (1, 1)
    assert "one photo" in found.note


def test_coarse_photos_decide_nothing_and_say_why() -> None:
    found = find(CROSS, gsd=0.045)
    assert not found.resolved and not found.bars
    assert "mm do not resolve bars" in found.note


def test_no_photo_decides_nothing() -> None:
    found = bars_by_evidence([window([])], OPTIONS)[0].glazing
    assert not found.resolved and found.note


def test_a_window_that_shows_little_takes_over_the_layout_of_its_type() -> None:
    shown = [view(eye, CROSS) for eye in EYES]
    hidden = [view(EYES[1], CROSS, gsd=0.016)]
    windows = [window(shown, name=f"B01/F1/W1-{k}") for k in (1, 2, 3)] + [window(hidden, name="B01/F1/W1-4")]
    found = [one.glazing for one in bars_by_evidence(windows, OPTIONS)]
    assert [g.counts for g in found] == [(1, 1)] * 4


def test_a_window_that_differs_keeps_its_layout() -> None:
    alike = [view(eye, CROSS) for eye in EYES]
    other = [view(eye, [TRANSOM]) for eye in EYES]
    windows = [window(alike, name=f"B01/F1/W1-{k}") for k in (1, 2, 3)] + [window(other, name="B01/F1/W1-4")]
    found = [one.glazing for one in bars_by_evidence(windows, OPTIONS)]
    assert [g.counts for g in found] == [(1, 1)] * 3 + [(0, 1)]
    assert all(b.provenance == Provenance.MEASURED for b in found[3].bars)


def test_the_result_does_not_depend_on_the_order_of_the_views() -> None:
    views = [view(eye, CROSS) for eye in EYES]
    first, second = (bars_by_evidence([window(v)], OPTIONS)[0].glazing for v in (views, views[::-1]))
    assert [b.position for b in first.bars] == pytest.approx([b.position for b in second.bars], abs=1e-3)


def test_pictures_show_every_view_and_the_evidence() -> None:
    found = bars_by_evidence([window([view(eye, CROSS) for eye in EYES])], OPTIONS)[0]
    assert len(found.views) == len(EYES)
    assert found.evidence is not None and found.evidence.shape == found.views[0][1].shape[:2]
    rows, columns = found.evidence.shape
    x0, _, x1, _ = found.extent
    at = int((MULLION[0] + BAR / 2 - x0) / (x1 - x0) * columns)
    middle = found.evidence[int(0.6 * rows), :].astype(float)
    assert middle[at - 4 : at + 5].max() > 3 * np.median(middle) + 10
