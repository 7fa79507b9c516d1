"""The stage `tables`: what was measured as GeoPackage, GeoParquet, CSV, and a schedule of openings."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path

from frontage.exports.survey import Survey
from frontage.exports.tables import Schedule, opening_pictures, schedule, survey_tables
from frontage.io.tables.csvfile import write_csv
from frontage.io.tables.frame import write_geoparquet
from frontage.io.tables.geopackage import write_geopackage
from frontage.io.tables.table import Table, find
from frontage.io.tables.workbook import Sheet, write_workbook
from frontage.pipeline.pictures import facade_picture
from frontage.pipeline.products import optional, untold
from frontage.pipeline.stage import After, Job, Stage
from frontage.pipeline.store.results import StageResult
from frontage.pipeline.survey import gather_survey, heights_of


@dataclass(frozen=True, eq=False)
class Gathered:
    """What was measured, and a small picture of every opening."""

    survey: Survey
    pictures: dict[str, bytes]


@dataclass(frozen=True, eq=False)
class MadeTables:
    """The layers of a run, its schedule of openings, and what is to be said of them."""

    tables: tuple[Table, ...]
    schedule: Schedule
    notes: tuple[str, ...]


def load(job: Job) -> Gathered:
    """Gather what was measured; of every ortho-image only the pictures of its openings are kept."""
    survey, pictures = gather_survey(job.store), dict[str, bytes]()
    for building in survey.buildings:
        for facade, elements in building.fronts:
            picture = facade_picture(job.store, facade)
            if picture is not None and elements is not None:
                pictures |= opening_pictures(picture, elements)
    return Gathered(survey, pictures)


def work(job: Job, found: Gathered) -> MadeTables:
    """Make the tables."""
    survey, tables = found.survey, survey_tables(found.survey)
    rows = schedule(survey, tables, found.pictures, heights_of(survey.world))
    return MadeTables(tables, rows, untold(survey))


def save(job: Job, made: MadeTables) -> tuple[MadeTables, tuple[str, ...]]:
    """Write the tables; what an extra is missing for is told, and its older file is removed."""
    store, crs = job.store, job.store.world().crs
    folder = store.products_folder
    write_geopackage(folder / "frontage.gpkg", made.tables, crs)
    write_csv(folder / "openings.csv", find(made.tables, "opening_outlines"))
    store.wrote(folder / "frontage.gpkg", folder / "openings.csv")
    facades, rows = find(made.tables, "facades"), made.schedule
    sheets = (
        Sheet("Openings", rows.columns, rows.rows, rows.pictures),
        Sheet("Facades", facades.columns, facades.rows),
    )
    workbook = folder / "openings.xlsx"
    parquet = [folder / "geoparquet" / f"{table.name}.parquet" for table in made.tables]
    notes = (
        optional(store, [workbook], partial(write_workbook, workbook, "Openings", sheets, rows.about)),
        optional(store, parquet, partial(_write_parquet, parquet, made.tables, crs)),
    )
    return made, (*made.notes, *(note for note in notes if note))


def join(job: Job, parts: list[tuple[MadeTables, tuple[str, ...]]]) -> StageResult:
    """Count the layers, and tell what is left out."""
    ((made, notes),) = parts
    return StageResult(items=len(made.tables), notes=notes)


def _write_parquet(paths: list[Path], tables: tuple[Table, ...], crs: str | None) -> None:
    for path, table in zip(paths, tables, strict=True):
        write_geoparquet(path, table, crs)


STAGE = Stage(
    name="tables",
    after=(
        "openings",
        "crossbars",
        After("ortho", optional=True),
        After("orient", optional=True),
        After("model", optional=True),
    ),
    load=load,
    work=work,
    save=save,
    join=join,
    commands=("export",),
    rooms=("exports", "catalog"),
    inputs=("photos",),
    options=("photos", "addresses"),
)
