"""Openings in the report and on pictures: where they are, what they are, how well they are known."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
import shapely

from facade_fakes import facade
from frontage.geometry.ring import box_sigmas, rectangle, ring_area, ring_area_sigma
from frontage.model import Elements, Provenance
from frontage.report import PictureView
from frontage.report.drawing import error_band, opening_picture
from frontage.report.evidence import Picture
from frontage.report.openings import opening_facts, outlines, rows, window_share
from opening_fakes import balcony, elements, on_balcony, opening, round_door
from report.test_page import page_of, view

EXTENT = (-5.5, -3.5, 5.5, 3.5)


def wall() -> Picture:
    """Grey, 2 cm a pixel."""
    return Picture("wall", "", np.full((350, 550, 4), 128, np.uint8), EXTENT)


def test_outlines_lie_where_the_openings_are() -> None:
    drawn = outlines(elements(), lambda ring: (ring - (-5.5, 3.5)) * (50, -50))
    assert [o.css for o in drawn] == ["protrusion", "measured", "inferred", "measured"]
    xy = np.array([[float(v) for v in pair.split(",")] for pair in drawn[1].points.split()])
    np.testing.assert_allclose(xy / (50, -50) + (-5.5, 3.5), opening().ring, atol=1e-9)
    assert drawn[1].title == "B01/F1/W1-1: window, 1.20 × 1.60 m, measured" and drawn[1].label == "W1-1"
    assert drawn[1].band.count("M") == 2


def test_the_band_holds_the_border_by_two_sigmas_on_each_side() -> None:
    o = opening()
    outer, inner = error_band(o)
    grown = np.concatenate([o.ring.min(0) - outer.min(0), outer.max(0) - o.ring.max(0)])
    np.testing.assert_allclose(grown, 1.96 * np.array([3, 4, 5, 6]) * 1e-3, rtol=1e-9)
    np.testing.assert_allclose(o.ring.min(0) - outer.min(0), inner.min(0) - o.ring.min(0))
    door = replace(round_door(), ring_covariance=np.eye(30) * 9.0)  # 3 m: more than it is wide
    outer, inner = error_band(door)
    np.testing.assert_allclose(np.ptp(outer, axis=0), 1.5 * np.ptp(door.ring, axis=0))
    np.testing.assert_allclose(np.ptp(inner, axis=0), 0.5 * np.ptp(door.ring, axis=0))
    unknown = replace(o, ring_covariance=np.diag(np.full(8, np.inf)))
    np.testing.assert_allclose(error_band(unknown)[0], o.ring)


def test_sigmas_of_sides_and_area_follow_the_covariance() -> None:
    o = opening()
    assert box_sigmas(o.ring, o.ring_covariance) == pytest.approx((0.003, 0.004, 0.005, 0.006))
    shifts = np.random.default_rng(0).multivariate_normal(np.zeros(8), o.ring_covariance, 4000)
    areas = [ring_area(o.ring + shift.reshape(4, 2)) for shift in shifts]
    assert ring_area_sigma(o.ring, o.ring_covariance) == pytest.approx(np.std(areas), rel=0.05)


def test_rows_say_size_depth_and_errors() -> None:
    by_id = {r.id: r for r in rows(elements())}
    assert list(by_id) == ["B01/F1/D0-1", "B01/F1/W0-2", "B01/F1/W1-1", "B01/F1/P1"]
    window, door = by_id["B01/F1/W1-1"], by_id["B01/F1/D0-1"]
    assert (window.size, window.depth) == ("1.20 × 1.60 m", "0.120 m ± 7 mm")
    assert window.sigma == "3 · 4 · 5 · 6 mm" and window.place == "1, 1"
    assert (door.depth, door.sigma, door.provenance) == ("–", "30 mm", "inferred")
    assert door.kind == "door, round"
    assert by_id["B01/F1/W0-2"].provenance == "measured, on P1"
    assert by_id["B01/F1/P1"].depth == "-0.900 m ± ?"


def test_the_share_of_windows_leaves_doors_out_and_has_an_error() -> None:
    f = facade()
    found = window_share(f, elements())
    assert found is not None
    share, sigma, area = found
    assert area == pytest.approx(1.2 * 1.6 + 1.0 * 0.8)
    assert share == pytest.approx(area / shapely.Polygon(f.outline).area)
    one = ring_area_sigma(opening().ring, opening().ring_covariance)
    other = ring_area_sigma(on_balcony().ring, on_balcony().ring_covariance)
    assert sigma * area / share == pytest.approx(np.hypot(one, other))
    pooled = [replace(opening(), provenance=Provenance.POOLED)] * 2
    _, alike, _ = window_share(f, Elements(f.id, tuple(pooled))) or (0, 0, 0)
    assert alike * area / share == pytest.approx(2 * one)  # they err together
    facts = {fact.name: fact for fact in opening_facts(f, elements())}
    assert (
        facts["Openings"].value == "2 × window, 1 × door" and "1 of them inferred" in facts["Openings"].error
    )
    assert opening_facts(f, Elements(f.id, ()))[0].value == "none found"


def test_the_picture_shows_each_opening_in_the_colour_of_its_provenance() -> None:
    drawn = opening_picture(wall(), elements())
    assert (wall().image == 128).all() and drawn.image.shape == wall().image.shape

    def colour(x: float, z: float) -> tuple[int, ...]:
        column, row = int((x + 5.5) * 50), int((3.5 - z) * 50)
        around = drawn.image[row - 1 : row + 2, column - 1 : column + 2, :3].reshape(-1, 3).astype(int)
        return tuple(around[np.ptp(around, axis=1).argmax()][::-1].tolist())

    r, g, b = colour(-3.1, 0.1)
    assert g > r + 50 and g > b + 30  # measured: green
    r, g, b = colour(1.4, -2.2)
    assert r > b + 50  # inferred: orange
    r, g, b = colour(-3.3, -1.3)
    assert r > g + 50 and b > g  # protrusion: pink
    assert colour(4.0, 2.0) == (128, 128, 128)
    decoded = cv2.imdecode(np.frombuffer(drawn.png, np.uint8), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(decoded, drawn.image)


def test_the_page_shows_outlines_table_and_evidence() -> None:
    plain = page_of(view())
    assert "Openings and protrusions" not in plain and "What they were found from" not in plain
    picture = PictureView(wall().png, EXTENT, "beams <b>")
    shown = replace(
        view(), elements=elements(), evidence=(picture,), files=("openings.json",), notes=("dim",)
    )
    text = page_of(shown)
    assert text.count('<polygon class="opening"') == 2 * 4  # on the ortho-image and on the evidence
    assert "B01/F1/W1-1: window, 1.20 × 1.60 m, measured</title>" in text
    assert "<td>3 · 4 · 5 · 6 mm</td>" in text and "Windows in wall" in text and ">dim<" in text
    assert "beams &lt;b&gt;" in text and 'href="facades/B01_F1/openings.json"' in text
    assert balcony().id in text
    rectangles = Elements("B01/F1", (replace(opening(), ring=rectangle(-1.0, -1.0, 0.0, 0.0)),))
    assert page_of(replace(shown, elements=rectangles)) != text
