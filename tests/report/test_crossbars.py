"""The contact sheet of window bars: pictures with the layout where it is, words, pages, and its size."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from frontage.crossbars import WindowEvidence
from frontage.geometry.arrays import Array
from frontage.model import Elements, Glazing
from frontage.report import WindowView
from frontage.report.crossbars import bars_sheet
from frontage.report.drawing import opening_picture
from frontage.report.layouts import layout_words
from frontage.report.openings import outlines, rows
from frontage.report.windows import WindowTile, fitted, window_tile
from opening_fakes import elements, opening, round_door
from report.test_openings import EXTENT, wall
from report.test_page import Tags, page_of, view


class _Tags(Tags):
    """The outlines of openings have titles in them."""

    VOID = (Tags.VOID | {"br"}) - {"polygon"}


AROUND = (-3.2, -0.8, -1.8, 1.0)
"""m, of the pictures of the window of `opening`."""


def glazing() -> Glazing:
    found = opening().glazing
    assert found is not None
    return found


def evidence(views: int = 2, scan: bool = True, chosen: Glazing | None = None) -> WindowEvidence:
    """Grey pictures of a window, at 5 mm."""
    shown = tuple((f"IMG_{k}.jpg", np.full((360, 280, 3), 90 + 20 * k, np.uint8)) for k in range(views))
    seen = np.full((180, 140), 30, np.uint8) if scan else None
    return WindowEvidence("B01/F1/W1-1", AROUND, shown, seen, chosen or glazing())


def image_of(tile: WindowTile) -> Array:
    return np.asarray(cv2.imdecode(np.frombuffer(tile.jpeg, np.uint8), cv2.IMREAD_COLOR), np.int64)


def test_the_layout_is_drawn_where_the_bars_are() -> None:
    tile = window_tile(evidence(), opening().ring)
    assert tile is not None and tile.file == "bars/W1-1.jpg"
    assert tile.panels == ("layout on IMG_0.jpg", "IMG_0.jpg", "IMG_1.jpg", "evidence")
    image = image_of(tile)
    assert image.shape[0] == pytest.approx(364, abs=4)
    scale = 360 / 1.8  # px per m: the window is higher than wide

    def at(x: float, z: float) -> Array:
        column, row = int((x - AROUND[0]) * scale), int((AROUND[3] - z) * scale)
        return np.asarray(image[row - 1 : row + 2, column - 1 : column + 2].mean((0, 1)))

    b, g, r = at(-2.5, 0.0)  # the measured mullion: green
    assert g > r + 25 and g > b + 8
    b, g, r = at(-2.8, 0.3)  # the pooled transom: blue
    assert b > r + 25
    assert np.abs(at(-2.8, 0.0) - 90).max() < 12  # glass
    b, _, r = at(-3.1, 0.0)  # the outline: yellow
    assert r > b + 25
    b, _, r = at(-3.03, 0.0)  # the inner border of the frame
    assert r > b + 25


def test_the_evidence_of_the_scan_alone_is_enough_and_nothing_is_too_little() -> None:
    tile = window_tile(evidence(views=0), opening().ring)
    assert tile is not None and tile.panels == ("layout on evidence", "evidence")
    assert window_tile(evidence(views=0, scan=False), opening().ring) is None
    lost = window_tile(evidence(chosen=Glazing(False, note="too dark")), opening().ring)
    assert lost is not None and lost.panels[0] == "not resolved on IMG_0.jpg"
    many = window_tile(evidence(views=7), opening().ring)
    assert many is not None and len(many.panels) == 5  # the layout, the three finest views, the evidence


def test_a_picture_has_the_bytes_that_it_may_have() -> None:
    noise = np.random.default_rng(0).integers(0, 255, (400, 560, 3)).astype(np.uint8)
    jpeg = cv2.imencode(".jpg", noise)[1].tobytes()
    assert fitted(jpeg, len(jpeg)) == jpeg
    small = fitted(jpeg, 30_000)
    assert 5_000 < len(small) <= 30_000
    shape = cv2.imdecode(np.frombuffer(small, np.uint8), cv2.IMREAD_COLOR).shape
    assert shape[1] / shape[0] == pytest.approx(1.4, rel=0.03)
    assert fitted(jpeg, 500) == b""


def test_layouts_in_words() -> None:
    bars = glazing().bars
    assert layout_words(glazing()) == "1 mullion, 1 transom"
    assert layout_words(Glazing(True, bars=(bars[0], bars[0]))) == "2 mullions"
    assert layout_words(Glazing(True)) == "one pane"
    assert layout_words(Glazing(False)) == "not resolved"


def windows(count: int, unresolved: int = 0) -> Elements:
    """Windows of one floor, the first ones of which are not resolved."""
    found = [replace(opening(f"B01/F1/W1-{k + 1}"), bay=k + 1) for k in range(count)]
    lost = [
        replace(o, glazing=Glazing(False, note=f"reason {k % 2}")) for k, o in enumerate(found[:unresolved])
    ]
    return Elements("B01/F1", (*lost, *found[unresolved:], round_door()))


def shots(found: Elements, jpeg: bytes = b"\xff\xd8a jpeg") -> tuple[WindowView, ...]:
    return tuple(
        WindowView(o.id, jpeg, f"bars/{o.id.rpartition('/')[2]}.jpg", ("layout", "<b>IMG"))
        for o in found.openings
        if o.glazing is not None
    )


def test_a_sheet_folds_its_pages_and_names_what_was_not_resolved() -> None:
    found = windows(60, unresolved=5)
    sheet = bars_sheet(replace(view(), elements=found, windows=shots(found)))
    assert sheet is not None and sheet.summary == "Window bars: 55 of 60 windows decided, 110 bars"
    assert [len(page.windows) for page in sheet.pages] == [24, 24, 12]
    assert sheet.pages[1].title == "W1-25 to W1-48"
    assert sheet.unresolved == [("3 × reason 0", "W1-1, W1-3, W1-5"), ("2 × reason 1", "W1-2, W1-4")]
    first, last = sheet.pages[0].windows[0], sheet.pages[2].windows[-1]
    assert (first.layout, first.css, first.numbers) == ("not resolved: reason 0", "unresolved", "")
    assert last.layout == "1 mullion, 1 transom" and last.file == "facades/B01_F1/bars/W1-60.jpg"
    assert last.numbers == "confidence 0.88, σ not known, 1 photo, scan"


def test_the_page_holds_the_sheet_well_formed_and_escaped() -> None:
    found = windows(60, unresolved=5)
    text = page_of(replace(view(), elements=found, windows=shots(found)))
    tags = _Tags()
    tags.feed(text)
    assert tags.open == [] and text.count('src="data:image/jpeg') == 60
    assert "&lt;b&gt;IMG" in text and "<b>IMG" not in text
    assert 'href="facades/B01_F1/bars/W1-7.jpg"' in text
    crowded = page_of(replace(view(), elements=found, windows=shots(found, b"")))
    assert '<a href="facades/B01_F1/bars/W1-7.jpg">picture</a>' in crowded


def test_windows_without_a_picture_are_named_all_the_same() -> None:
    found = windows(3, unresolved=3)
    text = page_of(replace(view(), elements=found))
    assert "Window bars: 0 of 3 windows decided, 0 bars" in text and "2 × reason 0" in text
    assert bars_sheet(replace(view(), elements=Elements("B01/F1", (round_door(),)))) is None


def test_bars_are_drawn_on_the_facade() -> None:
    bare = replace(elements(), openings=tuple(replace(o, glazing=None) for o in elements().openings))
    a, b = (opening_picture(wall(), e).image.astype(int) for e in (elements(), bare))
    row, column = np.nonzero(np.abs(a - b).max(2) > 30)
    x, z = EXTENT[0] + (column + 0.5) * 0.02, EXTENT[3] - (row + 0.5) * 0.02
    on = (np.abs(x + 2.5) < 0.07) | (np.abs(z - 0.3) < 0.07)
    assert len(x) > 200 and on.all()
    drawn = outlines(elements(), lambda ring: (ring - (-5.5, 3.5)) * (50, -50))
    assert drawn[1].bars.count("M") == 2 and "M148.5,210.0" in drawn[1].bars
    by_id = {r.id: r for r in rows(elements())}
    assert by_id["B01/F1/W1-1"].bars == "1 mullion, 1 transom" and by_id["B01/F1/D0-1"].bars == "–"
