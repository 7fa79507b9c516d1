"""The charts of standard errors: every border and depth is in the right column, or told as unknown."""

from dataclasses import replace

import numpy as np
import pytest

from frontage.geometry.ring import box_sigmas
from frontage.model import Elements
from frontage.report.quality import quality_charts
from opening_fakes import opening, round_door


def test_every_border_and_depth_counts_once() -> None:
    known, door = opening(), round_door()  # borders of 3 to 6 mm and a pooled depth of 7 mm; 30 mm, no depth
    sigmas = np.concatenate([box_sigmas(o.ring, o.ring_covariance) for o in (known, door)]) * 1000
    borders, depths = quality_charts([Elements("B01/F1", (known, door))])
    assert borders.title == "Borders" and "8 values" in borders.words and "without" not in borders.words
    assert f"half are known to {np.median(sigmas):.1f} mm" in borders.words
    ends = [0.0, *(float(label) for _, label in borders.ticks), np.inf]
    step = borders.width / (len(ends) - 1)
    for bar in borders.bars:
        k = round(bar.x / step)
        own = ((sigmas >= ends[k]) & (sigmas < ends[k + 1])).sum()
        same = [b for b in borders.bars if round(b.x / step) == k]
        assert sum(int(b.title.split()[0]) for b in same) == own
    assert sum(int(b.title.split()[0]) for b in borders.bars) == 8
    assert {b.css for b in borders.bars} == {"measured", "inferred"}
    tallest = max(borders.bars, key=lambda b: b.height)
    assert tallest.y >= -1e-9 and tallest.y + tallest.height == pytest.approx(borders.height)
    (only,) = depths.bars
    assert only.css == "pooled" and "1 without a value or error" in depths.words
    assert depths.median is not None and only.x <= depths.median <= only.x + only.width + 2


def test_unknown_errors_are_told_and_without_openings_there_is_no_chart() -> None:
    vague = replace(opening(), ring_covariance=np.diag(np.full(8, np.inf)), depth=None)
    borders, depths = quality_charts([Elements("B01/F1", (vague,))])
    assert borders.bars == depths.bars == () and borders.median is depths.median is None
    assert "none is known; 4 without" in borders.words and "none is known; 1 without" in depths.words
    assert quality_charts([Elements("B01/F1", ())]) == quality_charts([]) == ()
