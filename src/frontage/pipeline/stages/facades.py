"""The stage `facades`: plane, frame, outline and layers of every main facade (paper A, section 2.2)."""

from frontage.facades import find_facades
from frontage.model import Building, Facade, Failed, Scan
from frontage.pipeline.stage import Job, Stage, attempt, gather, per_building
from frontage.pipeline.store.results import ItemResult, StageWarning

Found = tuple[Facade | Failed, ...]


def load(job: Job) -> tuple[Scan, Building]:
    """Read the working cloud of a building and which of its points are its own."""
    return job.store.surveyed(job.item)


def work(job: Job, loaded: tuple[Scan, Building]) -> Found:
    """Find the facades."""
    scan, building = loaded
    options, seed = job.project.facades, job.project.project.seed
    found = attempt(job.item, lambda: find_facades(scan, building, options, seed))
    return (found,) if isinstance(found, Failed) else found


def save(job: Job, found: Found) -> ItemResult:
    """Write the facades."""
    facades = [f for f in found if isinstance(f, Facade)]
    for facade in facades:
        job.store.save_facade(facade)
    warnings = (StageWarning.of(job.item, f) for f in found if isinstance(f, Failed))
    return ItemResult(facades=tuple(f.id for f in facades), warnings=tuple(warnings))


STAGE = Stage(
    name="facades",
    after=("buildings",),
    tasks=per_building,
    load=load,
    work=work,
    save=save,
    join=gather,
    part=ItemResult,
    rooms=("facades",),
    options=("project.seed", "facades"),
)
