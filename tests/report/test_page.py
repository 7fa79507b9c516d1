"""The report: everything inline, everything escaped, the grid where the metres are."""

import os
import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from facade_fakes import GSD, facade, jpeg, ortho
from frontage.report import BuildingView, FacadeView, OrthoView, ReportData, render_report
from frontage.report.figures import building_figure, facade_ends, ortho_figure
from frontage.report.numbers import facade_facts, lean_of

EVIL = '<script>alert("x")</script>'


def view(name: str = "B01/F1") -> FacadeView:
    image = ortho(name)
    seen = OrthoView(jpeg(image), GSD, image.size, image.corner, ("IMG_1.jpg", EVIL))
    return FacadeView(image.facade, seen, "facades/" + name.replace("/", "_"))


def page(address: str = "13 rue Soufflot") -> str:
    return page_of(view(), address)


def page_of(shown: FacadeView, address: str = "13 rue Soufflot", model: bytes = b"") -> str:
    """The page of one building with one facade."""
    warning = {"stage": "facades", "item": "B01", "code": "F103", "message": EVIL, "hint": ""}
    counts = {"items": 1, "key": "k", "warnings": [], "notes": []}
    manifest = {
        "frontage": "0.1.0", "seed": 0, "versions": {"python": "3.11"}, "warnings": [warning],
        "notes": ["a note"],
        "world": {"crs": "EPSG:25832", "origin": [678_000, 5_403_000, 400]}, "stages": {"scans": counts},
        "inputs": {"scans": [{"path": EVIL, "size": 1, "sha256": "0" * 64}]},
    }  # fmt: skip
    record = {"id": "B01", "address": address, "points": 1234, "ground_z": 12.0, "cuts": [], "notes": [EVIL]}
    plan = np.random.default_rng(0).uniform(0, 10, (50, 2)) + np.array([60, 868])
    building = BuildingView(record, plan, (shown,), (warning,), model)
    files = ("model/lod3.glb",) if model else ()
    return render_report(ReportData(manifest, (building,), plan, np.zeros(50, np.int64), files=files))


class Tags(HTMLParser):
    """Counts start and end tags, collects every address."""

    VOID = frozenset({"meta", "img"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.links += [v or "" for k, v in attrs if k in ("href", "src")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.links += [v or "" for k, v in attrs if k in ("href", "src")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_is_one_well_formed_file_without_network() -> None:
    text = page()
    assert text.startswith("<!doctype html>")
    tags = Tags()
    tags.feed(text)
    assert tags.open == [] and len(tags.links) > 3
    assert all(
        re.match(r"data:image/(jpeg|png);base64,|#|buildings/|facades/|model/", link) for link in tags.links
    )
    assert not re.search(r"https?://|@import|url\((?!#)", text)


def test_the_model_is_shown_where_there_is_one() -> None:
    assert "<img" not in page()
    text = page_of(view(), model=b"a picture")
    assert text.count('<img src="data:image/png;base64,') == 1 and 'href="model/lod3.glb"' in text
    tags = Tags()
    tags.feed(text)
    assert tags.open == []


def test_names_from_files_are_escaped() -> None:
    text = page(address=EVIL)
    assert "<script" not in text
    assert text.count("&lt;script&gt;") >= 5


def test_the_same_data_gives_the_same_text_in_another_process() -> None:
    """The order of sets and of hashes, which changes from process to process, must not show."""
    code = "import sys; from report.test_page import page; sys.stdout.buffer.write(page().encode())"
    tests = Path(__file__).resolve().parents[1]
    path = os.pathsep.join([str(tests), *filter(None, sys.path)])
    told = {**os.environ, "PYTHONPATH": path, "PYTHONHASHSEED": "7"}
    done = subprocess.run([sys.executable, "-c", code], env=told, capture_output=True, check=True)
    assert done.stdout.decode() == page()


def test_grid_lines_lie_on_whole_metres_of_the_facade_frame() -> None:
    figure = ortho_figure(view())
    assert figure is not None
    scale = figure.width / (550 * GSD)
    assert figure.height == pytest.approx(350 * GSD * scale)
    labelled = {t.label: t.at for t in figure.vertical if t.label}
    assert labelled["0"] == pytest.approx(5.5 * scale) and labelled["5"] == pytest.approx(10.5 * scale)
    heights = {t.label: t.at for t in figure.horizontal if t.label}
    assert heights["0"] == pytest.approx(3.5 * scale) and heights["3"] == pytest.approx(0.5 * scale)
    assert len(figure.vertical) == 11  # -5 ... 5


def test_the_arrow_in_plan_points_to_the_street() -> None:
    shown = view()
    ends = facade_ends(shown)
    figure = building_figure(np.vstack([ends, ends + 3]), (shown,))
    assert figure is not None
    (s,) = figure.segments
    middle = np.array([(s.x1 + s.x2) / 2, (s.y1 + s.y2) / 2])
    arrow = (np.array([s.tip_x, s.tip_y]) - middle) * (1, -1)  # the figure's y runs down
    outward = -shown.facade.frame.R[:2, 1]
    assert arrow @ outward / np.linalg.norm(arrow) == pytest.approx(1.0, abs=1e-3)


def test_lean_has_sign_sigma_and_t() -> None:
    to_street = facade(lean=0.004)
    assert lean_of(to_street) == pytest.approx(0.004)
    assert to_street.frame.R[:, 2] @ -to_street.frame.R[:, 1] == pytest.approx(0)
    top = to_street.frame.apply(np.array([[0, 0, 5.0]]))[0] - to_street.frame.t
    assert top[:2] @ -to_street.frame.R[:2, 1] > 0  # the top really is nearer to the street
    fact = next(f for f in facade_facts(view()) if f.name == "Lean")
    assert fact.value.startswith("+0.2292°") and "t = +40.0: to the street" in fact.error


def test_unknown_errors_are_said_not_invented() -> None:
    shown = replace(view(), ortho=None)
    facts = {f.name: f for f in facade_facts(shown)}
    assert "not known" in facts["Bend"].error
    assert "Ortho-image" not in facts
