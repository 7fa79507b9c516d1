"""Galleries that posts join: a balcony in every storey, and a wall behind them that keeps its openings."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from frontage.model.opening import ProtrusionKind
from frontage.openings import FoundOpenings, find_openings
from frontage.openings.protrusions.galleries import with_pilasters
from frontage.openings.protrusions.pieces import Piece
from frontage.openings.protrusions.resolution import Resolution
from openings.boxes import balcony, box, oriel, scanned
from openings.joinery import framed, wall

WINDOWS = [(x, 3.9, x + 1.2, 5.2) for x in (1.2, 4.8)]
POSTS = [box(x, x + 0.25, -1.2, -0.95, 0.0, 7.5) for x in (0.3, 3.875, 7.45)]


def found_with(before):
    joinery = [part for hole in WINDOWS for part in framed(hole, 0.12)]
    found = find_openings(*scanned(before, wall=[*wall(WINDOWS), *joinery]))
    assert isinstance(found, FoundOpenings)
    return found


@pytest.mark.parametrize("bars", [False, True])
def test_every_storey_has_a_balcony_and_the_wall_its_windows(bars):
    slabs = [part for z in (3.0, 6.0) for part in balcony(0.3, 7.7, z, -1.2, bars)]
    found = found_with([*slabs, *POSTS])
    fronts = [p for p in found.protrusions if p.kind is ProtrusionKind.BALCONY]
    assert [float(p.ring[:, 1].min()) for p in fronts] == pytest.approx([2.85, 5.85], abs=0.04)
    assert all(p.front.value == pytest.approx(-1.2, abs=0.01) for p in fronts)
    assert not any(p.kind.is_wall for p in found.protrusions)
    places = np.array([[*o.ring.min(0), *o.ring.max(0)] for o in found.openings])
    assert np.abs(places[:, [0, 2, 3]] - np.array(WINDOWS)[:, [0, 2, 3]]).max() < 0.01  # parapets hide feet


def test_an_oriel_of_two_storeys_stays_one():
    found = found_with(oriel(2.0, 6.0, 2.5, 7.5, -1.0, (2.6, 3.4, 5.4, 6.8), 0.15))
    assert [p.kind for p in found.protrusions] == [ProtrusionKind.ORIEL]


@dataclass(frozen=True)
class Places:
    """Points (n, 3) m before and on a wall, as beams that end there."""

    points: Any

    def at(self, _y, place, _margin):
        """Where the beams within a place x0, z0, x1, z1 m cross the wall, and how deep they end."""
        x, y, z = self.points.T
        inside = (x >= place[0]) & (x <= place[2]) & (z >= place[1]) & (z <= place[3])
        return self.points[inside][:, [0, 2]], y[inside]


def test_a_single_point_of_a_front_beside_a_pilaster_is_no_part_of_it():
    x, z = (v.ravel() for v in np.meshgrid(np.arange(0.0, 0.6, 0.02), np.arange(0.0, 2.4, 0.02)))
    pilaster = np.column_stack([x, np.full(x.size, -0.2), z])
    alone = np.array([[1.51, -0.2, 1.2]])
    x, z = (v.ravel() for v in np.meshgrid(np.arange(0.64, 1.4, 0.02), np.arange(0.0, 2.4, 0.02)))
    wall = np.column_stack([x, np.zeros(x.size), z])
    before = np.vstack([pilaster, alone])
    rows = np.arange(len(before))
    piece = Piece(rows, rows, (0.0, 0.0, 1.51, 2.4), -0.2)
    beams: Any = Places(np.vstack([before, wall]))
    resolution = Resolution(0.02, 0.003, 0.02, np.empty((0, 3)))
    parts = with_pilasters([piece], before, beams, resolution)
    assert [part.box for part in parts] == [pytest.approx((0.0, 0.0, 0.58, 2.38))]
