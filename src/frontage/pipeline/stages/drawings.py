"""The stage `drawings`: every facade with its openings and their bars drawn, `openings.png`.

The ortho-image may change without anything being looked for again.
"""

from dataclasses import dataclass

from frontage.model import Elements, Failed
from frontage.pipeline.pictures import drawing_ground, save_picture
from frontage.pipeline.stage import After, Job, Stage, attempt, gather, per_building, warned
from frontage.pipeline.store.results import ItemResult, StageWarning
from frontage.report.drawing import opening_picture
from frontage.report.evidence import Picture


@dataclass(frozen=True, eq=False)
class KnownFacade:
    """What is known of a facade's openings, and the picture that they are drawn on."""

    elements: Elements
    ground: Picture | None


def load(job: Job) -> list[KnownFacade]:
    """Read what is known of the facades of a building."""
    store, pictures = job.store, job.store.openings_item(job.item).pictures
    known = []
    for name in store.facades_of(job.item, "crossbars"):
        elements = store.elements(name)
        assert elements is not None  # the stage `crossbars` has a result for it
        ground = drawing_ground(store, store.facade(name), pictures.get(name, ()))
        known.append(KnownFacade(elements, ground))
    return known


def work(job: Job, known: list[KnownFacade]) -> dict[str, Picture | Failed]:
    """Draw the facades that there is a picture of."""
    return {one.elements.facade: _drawn(one.ground, one.elements) for one in known if one.ground is not None}


def save(job: Job, drawn: dict[str, Picture | Failed]) -> ItemResult:
    """Write the drawings."""
    warnings, made = list[StageWarning](), list[str]()
    for name, picture in drawn.items():
        warnings += warned(name, picture)
        if isinstance(picture, Picture):
            save_picture(job.store, name, picture)
            made.append(name)
    return ItemResult(facades=tuple(made), warnings=tuple(warnings))


def _drawn(ground: Picture, elements: Elements) -> Picture | Failed:
    return attempt(elements.facade, lambda: opening_picture(ground, elements))


STAGE = Stage(
    name="drawings",
    after=("openings", "crossbars", After("ortho", optional=True)),
    tasks=per_building,
    load=load,
    work=work,
    save=save,
    join=gather,
    part=ItemResult,
    commands=("openings", "crossbars"),
    rooms=("report", "exports"),
)
