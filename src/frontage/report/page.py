"""report.html: one file, no network, everything inline, everything escaped."""

from dataclasses import dataclass
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from frontage.report.crossbars import BarsSheet, bars_sheet
from frontage.report.data import BuildingView, FacadeView, ReportData
from frontage.report.figures import (
    Figure,
    building_figure,
    data_uri,
    evidence_figure,
    ortho_figure,
    street_figure,
)
from frontage.report.model import model_facts, model_remarks
from frontage.report.numbers import Fact, facade_facts
from frontage.report.openings import Row, opening_facts, rows
from frontage.report.orientation import orientation_section
from frontage.report.quality import quality_charts
from frontage.report.registration import registration_figure, registration_rows
from frontage.report.street import street_rows


@dataclass(frozen=True)
class _FacadeSection:
    id: str
    folder: str
    figure: Figure | None
    facts: list[Fact]
    notes: tuple[str, ...]
    warnings: tuple[dict[str, str], ...]
    judged: bool
    rows: list[Row]
    evidence: list[tuple[Figure, str]]
    bars: BarsSheet | None
    files: tuple[str, ...]


@dataclass(frozen=True)
class _BuildingSection:
    record: dict[str, Any]
    figure: Figure | None
    facades: list[_FacadeSection]
    warnings: tuple[dict[str, str], ...]
    model: str
    model_facts: list[Fact]
    model_remarks: list[str]


def render_report(data: ReportData) -> str:
    """The page as HTML text. Names from files are escaped; the same data gives the same text."""
    environment = Environment(
        loader=PackageLoader("frontage.report", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["grouped"] = lambda number: f"{number:,}"
    views = [f for b in data.buildings for f in b.facades]
    text = environment.get_template("page.html").render(
        manifest=data.manifest,
        stages=data.manifest.get("stages", {}),
        name=_title(data.manifest),
        totals=_totals(data.manifest.get("stages", {})),
        world=data.manifest.get("world") or {},
        warnings=data.manifest.get("warnings", []),
        notes=data.manifest.get("notes", []),
        inputs=[entry for group in data.manifest.get("inputs", {}).values() for entry in group],
        street=street_figure(data),
        rows=street_rows(views),
        charts=quality_charts([v.elements for v in views if v.elements is not None]),
        registration=registration_figure(data.registration) if data.registration else None,
        registered=registration_rows(data.registration.record) if data.registration else [],
        orientation=orientation_section(data),
        files=data.files,
        buildings=[_building(view) for view in data.buildings],
    )
    return text.lstrip()


def _title(manifest: dict[str, Any]) -> str | None:
    """The name that the project file gives the run; a manifest may have no project file at all."""
    project = manifest.get("project") or {}
    name = project.get("project", {}).get("name")
    return None if name is None else str(name)


def _totals(stages: dict[str, Any]) -> list[tuple[str, str]]:
    """What was made, for the head of the page; a dash for stages that did not run."""
    names = {"scans": "points", "buildings": "buildings", "facades": "facades", "ortho": "ortho-images",
             "openings": "openings", "model": "models"}  # fmt: skip
    return [(text, f"{stages[name]['items']:,}" if name in stages else "–") for name, text in names.items()]


def _building(view: BuildingView) -> _BuildingSection:
    figure = building_figure(view.plan, view.facades)
    model = data_uri(view.model, "png") if view.model else ""
    about = view.about_model
    return _BuildingSection(
        view.record,
        figure,
        [_facade(f) for f in view.facades],
        view.warnings,
        model,
        model_facts(about) if about else [],
        model_remarks(about) if about else [],
    )


def _facade(view: FacadeView) -> _FacadeSection:
    facts = facade_facts(view)
    if view.elements is not None:
        facts += opening_facts(view.facade, view.elements)
    return _FacadeSection(
        view.facade.id,
        view.folder,
        ortho_figure(view),
        facts,
        view.facade.notes + view.notes,
        view.warnings,
        view.elements is not None,
        rows(view.elements) if view.elements else [],
        [(evidence_figure(view, picture), picture.caption) for picture in view.evidence],
        bars_sheet(view),
        view.files,
    )
