"""The stage `qgis`: a project that shows the run in QGIS, `products/frontage.qgz`."""

from dataclasses import dataclass

from frontage.exports.gisproject import gis_project
from frontage.exports.survey import Survey
from frontage.exports.tables import survey_tables
from frontage.io.qgis.project import QgisProject
from frontage.io.qgis.write import write_qgis
from frontage.pipeline.stage import After, Job, Stage
from frontage.pipeline.store.results import StageResult
from frontage.pipeline.survey import gather_survey, heights_of


@dataclass(frozen=True, eq=False)
class Gathered:
    """What was measured, and the facades with ortho-images: whether these have relief."""

    survey: Survey
    pictures: dict[str, bool]


def load(job: Job) -> Gathered:
    """Gather what was measured, and which rasters the stage `export` wrote."""
    store = job.store
    sidecars = {name: store.sidecar(name) for name in store.facade_ids("ortho")}
    return Gathered(gather_survey(store), {k: v.relief for k, v in sidecars.items() if v is not None})


def work(job: Job, found: Gathered) -> QgisProject:
    """Make the project."""
    survey = found.survey
    return gis_project(survey, survey_tables(survey), found.pictures, heights_of(survey.world))


def save(job: Job, project: QgisProject) -> QgisProject:
    """Write the project beside the tables and rasters that it shows."""
    path = job.store.products_folder / "frontage.qgz"
    write_qgis(path, project)
    job.store.wrote(path)
    return project


def join(job: Job, parts: list[QgisProject]) -> StageResult:
    """Count the sheets."""
    (project,) = parts
    return StageResult(items=len(project.plates))


STAGE = Stage(
    name="qgis",
    after=("tables", After("export", optional=True), After("ortho", optional=True)),
    load=load,
    work=work,
    save=save,
    join=join,
    commands=("export",),
    rooms=("exports", "catalog"),
    options=("addresses",),
)
