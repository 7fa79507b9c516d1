"""The stage `openings`: openings and protrusions of every facade (paper B, sections 3.1 and 3.2)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.catalog import number_building
from frontage.model import Building, Elements, Facade, Failed, OrthoImage, Scan
from frontage.openings import FoundOpenings, OpeningOptions, find_openings
from frontage.openings.duplicates import without_duplicates
from frontage.pipeline.notes import shared_notes
from frontage.pipeline.pictures import evidence_pictures, save_picture
from frontage.pipeline.project import Project
from frontage.pipeline.stage import After, Job, Stage, attempt, per_building, warned
from frontage.pipeline.store.elements import check_elements
from frontage.pipeline.store.results import EvidencePicture, OpeningsItemResult, StageResult, StageWarning
from frontage.pipeline.store.store import Store
from frontage.report.evidence import Picture


@dataclass(frozen=True, kw_only=True)
class OpeningsResult(StageResult):
    """What was found in the whole run; `items` counts openings."""

    protrusions: int


@dataclass(frozen=True, eq=False)
class Walls:
    """The facades of a building, its points, and ortho-images where the scans hold no colour."""

    building: Building
    scan: Scan
    facades: tuple[Facade, ...]
    orthos: tuple[OrthoImage | None, ...]


@dataclass(frozen=True, eq=False)
class SearchedFacade:
    """What was found on one facade, with pictures of the evidence, or why nothing could be."""

    facade: Facade
    elements: Elements | Failed
    evidence: tuple[Picture, ...] | Failed = ()


def colourless(store: Store, project: Project) -> bool:
    """Tell whether only photos show what walls look like: the scans hold neither intensity nor colour."""
    return project.photos is not None and store.markers.read("scans") is not None and not store.scans().looks


def load(job: Job) -> Walls | None:
    """Read the facades of a building, and their ortho-images where they are needed."""
    names = job.store.facades_of(job.item)
    if not names:
        return None
    pictured = colourless(job.store, job.project)
    cloud, building = job.store.surveyed(job.item)
    return Walls(
        building,
        cloud,
        tuple(job.store.facade(name) for name in names),
        tuple(job.store.ortho(name) if pictured else None for name in names),
    )


def work(job: Job, walls: Walls | None) -> list[SearchedFacade]:
    """Find openings facade by facade, drop those that two facades show, and number the rest."""
    if walls is None:
        return []
    options = job.project.openings
    judged = [_judged(f, walls, options, o) for f, o in zip(walls.facades, walls.orthos, strict=True)]
    found = [(one.facade, one.elements) for one in judged if isinstance(one.elements, Elements)]
    numbered = _numbered(without_duplicates(found, walls.scan), walls.building, options)
    elements = {facade.id: named for facade, named in numbered}
    return [replace(one, elements=elements.get(one.facade.id, one.elements)) for one in judged]


def save(job: Job, judged: list[SearchedFacade]) -> OpeningsItemResult:
    """Write what was found, and the pictures of the evidence."""
    warnings, pictures = list[StageWarning](), dict[str, tuple[EvidencePicture, ...]]()
    found = list[Elements]()
    for one in judged:
        name = one.facade.id
        if isinstance(one.elements, Failed):
            warnings += warned(name, one.elements)
            continue
        job.store.save_found_elements(one.facade, one.elements)
        found.append(one.elements)
        warnings += warned(name, one.evidence)
        if not isinstance(one.evidence, Failed):
            pictures[name] = tuple(save_picture(job.store, name, picture) for picture in one.evidence)
    return OpeningsItemResult(
        facades=tuple(e.facade for e in found),
        warnings=tuple(warnings),
        openings=tuple(o.id for e in found for o in e.openings),
        protrusions=tuple(p.id for e in found for p in e.protrusions),
        notes={e.facade: tuple(e.notes) for e in found},
        pictures=pictures,
    )


def join(job: Job, parts: list[OpeningsItemResult]) -> OpeningsResult:
    """Count what was found; repeat what reading the photos had to say."""
    return OpeningsResult(
        items=sum(len(part.openings) for part in parts),
        protrusions=sum(len(part.protrusions) for part in parts),
        warnings=tuple(w for part in parts for w in part.warnings),
        notes=tuple(shared_notes(parts)),
    )


def options_at(facade: Facade, building: Building, options: OpeningOptions) -> OpeningOptions:
    """Return the options with the height of the building's ground, if that is known and none was given.

    The height is a z of the facade's frame: that of its z axis at the ground, because x is horizontal.
    """
    if options.ground_z is not None or not np.isfinite(building.ground_z):
        return options
    rise = float(facade.frame.R[2, 2])
    return options.model_copy(update={"ground_z": (building.ground_z - float(facade.frame.t[2])) / rise})


def _judged(
    facade: Facade, walls: Walls, options: OpeningOptions, ortho: OrthoImage | None
) -> SearchedFacade:
    """Find the openings of a facade, and draw the evidence at once, so that it need not be kept."""
    own = options_at(facade, walls.building, options)

    def find() -> FoundOpenings | Failed:
        found = find_openings(facade, walls.scan, own, ortho)
        if not isinstance(found, Failed):
            check_elements(found.elements)
        return found

    found = attempt(facade.id, find)
    if isinstance(found, Failed):
        return SearchedFacade(facade, found)
    evidence = found.evidence
    return SearchedFacade(facade, found.elements, attempt(facade.id, lambda: evidence_pictures(evidence)))


def _numbered(
    judged: Sequence[tuple[Facade, Elements]], building: Building, options: OpeningOptions
) -> list[tuple[Facade, Elements]]:
    """Give the openings floors, bays and ids; floors agree between the facades of a building."""
    facades = [facade for facade, _ in judged]
    ground = building.ground_z
    if facades and options.ground_z is not None:
        frame = facades[0].frame
        ground = float(frame.t[2] + frame.R[2, 2] * options.ground_z)
    return list(zip(facades, number_building(facades, [e for _, e in judged], ground), strict=True))


STAGE = Stage(
    name="openings",
    after=("facades", After("ortho", when=colourless)),
    tasks=per_building,
    load=load,
    work=work,
    save=save,
    join=join,
    part=OpeningsItemResult,
    result=OpeningsResult,
    rooms=("openings", "catalog", "report"),
    options=("openings",),
)
