"""The street's elevation: facades stand where they are, at one scale, the right way round."""

from dataclasses import replace

import numpy as np
import pytest

from facade_fakes import GSD, facade, jpeg, ortho
from frontage.geometry.rigid import Rigid3
from frontage.model import Elements, Estimate, Facade
from frontage.report import FacadeView, OrthoView
from frontage.report.street import StreetRow, street_rows
from opening_fakes import opening


def moved(name: str, right: float, up: float = 0.0, turn: float = 0.0) -> FacadeView:
    """The fake facade, shifted along itself and turned about the vertical (degrees)."""
    image = ortho(name)
    own, a = facade(name, lean=0.0), np.radians(turn)
    about = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1.0]])
    at = own.frame.apply(np.array([[right, 0.0, up]]))[0]
    pose = Estimate(Rigid3("local", "facade", about @ own.frame.R, at), np.eye(6) * 1e-8, 9.0)
    shown: Facade = replace(own, local_from_facade=pose)
    picture = OrthoView(jpeg(image), GSD, image.size, image.corner, ())
    return FacadeView(shown, picture, "facades/x", elements=Elements(name, (opening(f"{name}/W1-1"),)))


def named(row: StreetRow) -> list[str]:
    return [f.id for f in row.facades]


def test_facades_stand_in_their_order_at_one_scale() -> None:
    views = [moved("B02/F1", 12.0, up=1.0), moved("B01/F1", 0.0), moved("B03/F1", 25.0, turn=10.0)]
    (row,) = street_rows(views)
    assert named(row) == ["B01/F1", "B02/F1", "B03/F1"]
    a, b, _ = row.facades
    scale = a.width / (ortho().size[0] * GSD)
    assert all(f.width == pytest.approx(a.width) and f.height == pytest.approx(a.height) for f in row.facades)
    assert b.x - a.x == pytest.approx(12.0 * scale) and a.y - b.y == pytest.approx(1.0 * scale)
    outline = np.array([p.split(",") for p in a.outline.split()], float)
    assert np.ptp(outline, axis=0) == pytest.approx(np.array([10.0, 6.0]) * scale, abs=0.1)
    window = np.array([p.split(",") for p in a.openings[0].split()], float)
    ring = views[1].elements.openings[0].ring
    x, z = ring.T
    zero = a.x - ortho().corner[0] * scale, a.y + ortho().corner[1] * scale
    np.testing.assert_allclose(window, np.column_stack([zero[0] + x * scale, zero[1] - z * scale]), atol=0.1)
    heights = [float(t.label) for t in row.levels]
    assert heights == sorted(heights) and len(heights) >= 3
    assert row.levels[0].at > row.levels[-1].at


def test_other_sides_and_hidden_facades_have_rows_of_their_own() -> None:
    opposite, behind = moved("B02/F1", 0.0, turn=180.0), moved("B03/F1", 3.0)
    rows = street_rows([moved("B01/F1", 0.0), opposite, behind])
    assert sorted(map(named, rows)) == [["B01/F1"], ["B02/F1"], ["B03/F1"]]
    assert len({round(f.width, 6) for row in rows for f in row.facades}) == 1
    assert street_rows([]) == ()


def test_a_facade_without_a_picture_shows_its_outline() -> None:
    (row,) = street_rows([replace(moved("B01/F1", 0.0), ortho=None, elements=None)])
    (only,) = row.facades
    assert only.href == "" and only.openings == () and only.outline
