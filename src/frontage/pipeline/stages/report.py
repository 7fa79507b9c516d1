"""The stage `report`: `report.html`, one page with pictures and numbers that needs no network."""

from dataclasses import replace

from frontage.pipeline.reportdata import report_data
from frontage.pipeline.stage import After, Job, Stage
from frontage.pipeline.store.results import StageResult
from frontage.report import ReportData, render_report

_SHOWN = (
    "register",
    "orient",
    "buildings",
    "facades",
    "ortho",
    "openings",
    "crossbars",
    "drawings",
    "model",
    "export",
)


def load(job: Job) -> ReportData:
    """Gather what the page shows. The page does not tell of its own making."""
    manifest = job.store.manifest()
    stages = {name: stage for name, stage in manifest.stages.items() if name != "report"}
    return report_data(job.store, replace(manifest, stages=stages))


def work(job: Job, data: ReportData) -> str:
    """Render the page."""
    return render_report(data)


def save(job: Job, page: str) -> None:
    """Write the page."""
    job.store.put(job.store.out / "report.html", page.encode())


def join(job: Job, parts: list[None]) -> StageResult:
    """Count one page."""
    return StageResult(items=len(parts))


STAGE = Stage(
    name="report",
    after=("scans", *(After(stage, optional=True) for stage in _SHOWN)),
    load=load,
    work=work,
    save=save,
    join=join,
    rooms=("report",),
)
