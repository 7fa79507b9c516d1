"""The stage `bim`: the measured facades as a building information model, `products/frontage.ifc`."""

from dataclasses import dataclass, replace
from functools import partial

from frontage.exports.bim import bim_buildings
from frontage.exports.survey import Survey
from frontage.io.bim.ifc import write_ifc
from frontage.io.bim.parts import BimBuilding
from frontage.pipeline.gaps import gaps
from frontage.pipeline.products import optional, without
from frontage.pipeline.stage import Job, Stage
from frontage.pipeline.store.results import StageResult
from frontage.pipeline.survey import gather_survey

_SHOWN = ("buildings", "facades", "openings", "crossbars")  # stages whose results are in the model


@dataclass(frozen=True, eq=False)
class MadeModel:
    """The buildings of the model, and what is to be said of the file."""

    buildings: tuple[BimBuilding, ...]
    notes: tuple[str, ...] = ()


def load(job: Job) -> Survey:
    """Gather what was measured."""
    return gather_survey(job.store)


def work(job: Job, survey: Survey) -> MadeModel:
    """Make walls, openings, windows and doors of the facades."""
    buildings = bim_buildings(survey)
    bare = [b.id for b in buildings if not b.parts]
    return MadeModel(buildings, without(bare, "Without a facade, and so without a wall"))


def save(job: Job, made: MadeModel) -> MadeModel:
    """Write the model; without the extra it is told what is missing."""
    path = job.store.products_folder / "frontage.ifc"
    left_out = gaps(job.store, _SHOWN)
    write = partial(write_ifc, path, made.buildings, job.store.world(), "Frontage", left_out)
    note = optional(job.store, [path], write)
    return replace(made, notes=(*made.notes, *((note,) if note else ())))


def join(job: Job, parts: list[MadeModel]) -> StageResult:
    """Count the buildings, and tell what is left out."""
    (made,) = parts
    return StageResult(items=len(made.buildings), notes=made.notes)


STAGE = Stage(
    name="bim",
    after=("openings", "crossbars"),
    load=load,
    work=work,
    save=save,
    join=join,
    commands=("export",),
    rooms=("exports", "catalog"),
    options=("addresses",),
)
