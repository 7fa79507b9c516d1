"""The stage `views`: which photos show every opening, and the facade with its openings drawn.

It writes `openings.json`, what users script against: what the stage `openings` found with everything that
later stages know of it. Photos and ortho-images may change without the openings being looked for again.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from frontage.catalog.sightlines import ScannedSurfaces, photo_views, scanned_surfaces
from frontage.errors import FrontageError
from frontage.model import Elements, Facade, Failed, Photo
from frontage.pipeline.pictures import drawing_ground, save_picture
from frontage.pipeline.stage import After, Job, Stage, attempt, gather, per_building, warned
from frontage.pipeline.store.results import ItemResult, StageResult, StageWarning
from frontage.report.drawing import opening_picture
from frontage.report.evidence import Picture


@dataclass(frozen=True)
class Photos:
    """The photos of a run, or why they could not be read."""

    photos: tuple[Photo, ...] = ()
    note: str = ""


@dataclass(frozen=True, eq=False)
class JudgedFacade:
    """A facade with what was found on it, and the picture that it is drawn on."""

    facade: Facade
    elements: Elements
    ground: Picture | None


@dataclass(frozen=True, eq=False)
class JudgedBuilding:
    """The judged facades of a building, and the surfaces that may hide them from the photos."""

    facades: tuple[JudgedFacade, ...]
    scanned: ScannedSurfaces | None


@dataclass(frozen=True, eq=False)
class Shown:
    """A facade whose openings know their photos, and its drawing, or why it could not be made."""

    facade: Facade
    elements: Elements
    drawing: Picture | Failed | None


def tasks(job: Job) -> dict[str, Photos]:
    """Return every building with the photos of the run."""
    source, photos = job.project.photos, Photos()
    if source is not None:
        try:
            photos = Photos(job.store.photos_of(source).photos)
        except FrontageError as error:
            photos = Photos(note=f"the photos could not be read: {error}")
    return dict.fromkeys(per_building(job), photos)


def load(job: Job) -> JudgedBuilding:
    """Read what was found on the facades of a building, and what may hide it from the photos."""
    store, pictures = job.store, job.store.openings_item(job.item).pictures
    facades = []
    for name in store.facades_of(job.item, "openings"):
        facade = store.facade(name)
        ground = drawing_ground(store, facade, pictures.get(name, ()))
        facades.append(JudgedFacade(facade, store.found_elements(name), ground))
    hidden = job.payload.photos and any(one.elements.openings for one in facades)
    surroundings = store.surroundings() if hidden else None
    return JudgedBuilding(
        tuple(facades), None if surroundings is None else scanned_surfaces(surroundings.xyz)
    )


def work(job: Job, judged: JudgedBuilding) -> list[Shown]:
    """Tell which photos show the openings, and draw them."""
    photos: Photos = job.payload
    return [_shown(one, photos.photos, judged.scanned) for one in judged.facades]


def save(job: Job, shown: list[Shown]) -> ItemResult:
    """Write `openings.json` and the drawing of every facade."""
    warnings = list[StageWarning]()
    for one in shown:
        job.store.save_elements(one.facade, one.elements)
        warnings += warned(one.facade.id, one.drawing)
        if isinstance(one.drawing, Picture):
            save_picture(job.store, one.facade.id, one.drawing)
    return ItemResult(facades=tuple(one.facade.id for one in shown), warnings=tuple(warnings))


def join(job: Job, parts: list[ItemResult]) -> StageResult:
    """Count the facades; repeat why the photos could not be read."""
    notes = dict.fromkeys(photos.note for photos in job.payload.values() if photos.note)
    return replace(gather(job, parts), notes=tuple(notes))


def _shown(one: JudgedFacade, photos: Sequence[Photo], scanned: ScannedSurfaces | None) -> Shown:
    name = one.facade.id
    elements = attempt(name, lambda: _seen(one.facade, one.elements, photos, scanned))
    if isinstance(elements, Failed):
        return Shown(one.facade, one.elements, elements)
    if one.ground is None:
        return Shown(one.facade, elements, None)
    ground = one.ground
    return Shown(one.facade, elements, attempt(name, lambda: opening_picture(ground, elements)))


def _seen(
    facade: Facade, elements: Elements, photos: Sequence[Photo], scanned: ScannedSurfaces | None
) -> Elements:
    """Return the elements with the names of the photos that show each opening."""
    outlines = [(o.ring, elements.wall_y(o)) for o in elements.openings]
    views = photo_views(facade, outlines, photos, scanned)
    names = (tuple(view.photo for view in own) for own in views)
    openings = (replace(o, photos=own) for o, own in zip(elements.openings, names, strict=True))
    return replace(elements, openings=tuple(openings))


STAGE = Stage(
    name="views",
    after=("openings", After("orient"), After("ortho", optional=True)),
    tasks=tasks,
    load=load,
    work=work,
    save=save,
    join=join,
    part=ItemResult,
    command="openings",
    rooms=("catalog", "report", "exports"),
    inputs=("photos",),
    options=("photos",),
)
