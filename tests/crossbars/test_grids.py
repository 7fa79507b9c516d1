"""Bars that cross are described once, however faint their pieces are; cames are told by their width."""

from types import SimpleNamespace

import numpy as np
import pytest

from frontage.crossbars.division import Line, joined
from frontage.crossbars.extent import within_frame
from frontage.crossbars.layout import best_layout
from frontage.crossbars.leaded import are_cames
from frontage.crossbars.lines import Bars

PX, STRIP, WIDTH = 0.005, 0.05, 8
BOX = (0.0, 0.0, 1.0, 1.6)


def evidence(axis, places, *, nats, known=lambda along: True):
    """Bars across an axis at places m, with some nats per strip wherever `known`; all else speaks against."""
    n, strips = round(BOX[2 + axis] / PX), round(BOX[3 - axis] / STRIP)
    seen = np.array([known((k + 0.5) * STRIP) for k in range(strips)])
    one = np.full((strips, n + 1), -2.0)
    for place in places:
        lower = round(place / PX) - WIDTH // 2
        one[:, lower - 1 : lower + 2] = nats
    one *= seen[:, None]
    total = np.zeros((strips + 1, n + 1, 1), np.float32)
    total[1:, :, 0] = np.cumsum(one, axis=0)
    return Bars(axis, 0.0, PX, 0.0, STRIP, np.array([WIDTH]), total, np.arange(strips + 1, dtype=float))


@pytest.mark.parametrize("hidden", [0.0, 0.35])
def test_a_grid_of_faint_bars_is_found_whole(hidden):
    upright = evidence(0, (0.33, 0.67), nats=1.5, known=lambda z: z > hidden)
    level = evidence(1, (0.4, 0.8, 1.2), nats=1.5)
    found = joined(best_layout(BOX, (upright, level), (0.14, 0.14)).lines)
    assert sorted((line.axis, round(line.position, 2)) for line in found) == [
        (0, 0.33),
        (0, 0.67),
        (1, 0.4),
        (1, 0.8),
        (1, 1.2),
    ]
    ends = [line.extent for line in found]
    assert all(
        np.isclose(low, 0.0) and np.isclose(high, 1.6 - 0.6 * (line.axis == 1))
        for line, (low, high) in zip(found, ends, strict=True)
    )


def test_bars_end_at_a_transom_where_nothing_continues_them():
    upright = evidence(0, (0.33, 0.67), nats=1.5)
    below = round(0.75 / STRIP)
    upright.total[1:, :, :] -= np.minimum(np.arange(1, len(upright.total)), below)[:, None, None] * 3.0
    found = joined(best_layout(BOX, (upright, evidence(1, (0.8,), nats=1.5)), (0.14, 0.14)).lines)
    assert sorted((line.axis, round(line.extent[0], 1)) for line in found) == [(0, 0.8), (0, 0.8), (1, 0.0)]


def test_bars_as_thin_as_lead_are_cames():
    assert are_cames([0.010, 0.012, 0.011, 0.013, 0.10])
    assert not are_cames([0.018, 0.022, 0.020, 0.013])
    assert not are_cames([0.010, 0.012, 0.10])


def test_bars_end_at_the_frame_of_a_pointed_window():
    ring = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 2.0], [0.0, 1.0]])
    opening = SimpleNamespace(shape="pointed")
    window = SimpleNamespace(ring=ring, opening=opening)
    seen = SimpleNamespace(sight=SimpleNamespace(window=window), box=(0.05, 0.05, 0.95, 1.95))
    upright, level = Line(0, 0.25, (0.05, 1.95), 0.03, 1.0), Line(1, 1.5, (0.05, 0.95), 0.03, 1.0)
    cut = within_frame(seen, [upright, level])
    slope = 0.05 * np.sqrt(5.0)  # of the frame, measured upright
    assert np.allclose(cut[0].extent, (0.05, 1.5 - slope))
    assert np.allclose(cut[1].extent, (0.25 + slope / 2, 0.75 - slope / 2))
    opening.shape = "rectangle"
    assert within_frame(seen, [upright]) == [upright]
