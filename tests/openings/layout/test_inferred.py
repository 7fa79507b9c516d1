"""Openings behind what hides the wall: predicted by rows and columns, never where the wall was seen."""

from dataclasses import fields

import numpy as np
import pytest

from frontage.openings.layout.inferred import infer
from frontage.openings.layout.pooling import pool
from frontage.openings.wall.evidence import Evidence
from frontage.openings.wall.raster import WallRaster
from openings.fronts import SIZE, front

CELL = 0.05


def evidence(boxes, hidden=(), size=(14.0, 14.0)):
    """Evidence of a front whose openings are `boxes`, nothing known within the boxes `hidden`."""
    shape = (int(size[1] / CELL), int(size[0] / CELL))
    raster = WallRaster((-1.0, 0.0), CELL, shape)
    x = raster.corner[0] + (np.arange(shape[1]) + 0.5) * CELL
    z = raster.corner[1] + (np.arange(shape[0]) + 0.5) * CELL

    def within(boxes):
        out = np.zeros(shape, bool)
        for x0, z0, x1, z1 in boxes:
            out |= ((z > z0) & (z < z1))[:, None] & ((x > x0) & (x < x1))[None, :]
        return out

    opened, stopped = within(boxes), within(hidden)
    due = np.full(shape, 4.0)
    seen = ~stopped
    llr = np.where(stopped, 0.0, np.where(opened, 5.0, -4.0))
    told = {
        "raster": raster,
        "llr": llr,
        "expected_free": due,
        "expected": due * seen,
        "solid": due * (seen & ~opened),
        "open": due * (seen & opened),
        "seen": seen,
        "inside": np.ones(shape, bool),
        "rays": True,
    }
    return Evidence(**{f.name: np.zeros(shape) for f in fields(Evidence)} | told)


def hide(truth, gone):
    return [tuple(truth[k] + (-0.5, -0.5, 0.5, 0.5)) for k in gone]


@pytest.mark.parametrize("gone", [(7,), (0,), (19,), (7, 8), (12, 18)])
def test_hidden_windows_of_a_grid_are_inferred(gone):
    found, truth = front(1, sigma=0.004)
    left = pool([o for k, o in enumerate(found) if k not in gone])
    inferred = infer(left, evidence(np.delete(truth, gone, axis=0), hide(truth, gone)))
    assert len(inferred) == len(gone)
    for i, k in zip(sorted(inferred, key=lambda i: i.outline.place[1::-1]), gone, strict=True):
        assert np.abs(i.outline.place - truth[k]).max() < 0.01
        assert np.ptp(i.outline.ring[0], axis=0) == pytest.approx(SIZE, abs=0.01)
        assert 0.9 <= i.confidence < 1.0
        assert i.outline.depth is not None and i.outline.depth.provenance == "inferred"


def test_sigmas_of_inferred_windows_are_honest():
    normalised = []
    for seed in range(12):
        found, truth = front(seed, sigma=0.004, jitter=0.01)
        left = pool([o for k, o in enumerate(found) if k != 7])
        (one,) = infer(left, evidence(np.delete(truth, 7, axis=0), hide(truth, (7,))))
        sigma = np.sqrt(np.diag(one.outline.covariance))[[0, 2, 1, 3]]
        normalised.append((one.outline.place - truth[7]) / sigma)
    assert 0.5 < np.sqrt(np.mean(np.square(normalised))) < 1.4


def test_none_where_the_wall_was_seen():
    found, truth = front(1, sigma=0.004)
    left = pool([o for k, o in enumerate(found) if k != 7])
    assert infer(left, evidence(np.delete(truth, 7, axis=0))) == []


def test_none_where_the_grid_has_gaps():
    found, truth = front(1, sigma=0.004)
    gaps, hidden = (1, 6, 8, 13), (17,)
    gone = (*gaps, *hidden)
    left = pool([o for k, o in enumerate(found) if k not in gone])
    assert infer(left, evidence(np.delete(truth, gone, axis=0), hide(truth, hidden))) == []


def test_none_that_overlaps_another_or_leaves_the_facade():
    found, truth = front(1, sigma=0.004)
    left = pool([o for k, o in enumerate(found) if k != 19])
    boxes = np.delete(truth, 19, axis=0)
    assert infer(left, evidence(boxes, hide(truth, (19,)), size=(11.5, 14.0))) == []
    door = (*(truth[19][:2] + 0.3), *(truth[19][2:] + 0.9))
    wide = [*left, type(left[0])("rectangle", door, 0.0, np.eye(5) * 1e-5, (), None, 0.0)]
    assert infer(wide, evidence(boxes, hide(truth, (19,)))) == []


def test_few_openings_tell_nothing():
    found, truth = front(1, rows=1, columns=3)
    assert infer(pool(found), evidence(truth)) == []
    assert infer([], evidence(truth)) == []
