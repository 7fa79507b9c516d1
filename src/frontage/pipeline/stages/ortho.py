"""The stage `ortho`: the ortho-image of every facade, from photos or scan (paper A, section 2.3)."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from frontage.geometry.arrays import Array
from frontage.io.photos.photoset import PhotoSet
from frontage.model import Facade, Failed, OrthoImage, Scan
from frontage.ortho import make_ortho
from frontage.pipeline.stage import After, Job, Stage, attempt, gather, per_building
from frontage.pipeline.store.results import ItemResult, StageResult, StageWarning


@dataclass(frozen=True, eq=False)
class Seen:
    """The facades of a building, its working cloud, and the thinned street that may hide it from photos."""

    facades: tuple[Facade, ...]
    scan: Scan | None
    surroundings: Scan | None


Made = Iterator[tuple[str, OrthoImage | Failed]]


def tasks(job: Job) -> dict[str, PhotoSet | None]:
    """Return every building with the photos of the run."""
    source = job.project.photos
    photos = job.store.photos_of(source) if source is not None else None
    return dict.fromkeys(per_building(job), photos)


def load(job: Job) -> Seen:
    """Read the facades of a building and what can hide them."""
    facades = tuple(job.store.facade(name) for name in job.store.facades_of(job.item))
    if not facades:
        return Seen((), None, None)
    surroundings = job.store.surroundings() if job.payload is not None else None
    return Seen(facades, job.store.working_cloud(job.item), surroundings)


def work(job: Job, seen: Seen) -> Made:
    """Make one picture after the other, in one look, so that memory holds one at a time."""
    photos: PhotoSet | None = job.payload
    light: dict[str, Array] = {}
    for facade in seen.facades:
        ortho = attempt(facade.id, lambda f=facade, known=light: _picture(job, seen, f, photos, known))  # type: ignore[misc]
        if isinstance(ortho, OrthoImage):
            light = {**ortho.light, **light}  # the first facade that a photo shows sets its look
        yield facade.id, ortho


def save(job: Job, made: Made) -> ItemResult:
    """Write the pictures."""
    facades, warnings = list[str](), list[StageWarning]()
    for name, ortho in made:
        if isinstance(ortho, Failed):
            warnings.append(StageWarning.of(name, ortho))
        else:
            job.store.save_ortho(ortho)
            facades.append(name)
            warnings.extend(ortho_warnings(name, ortho))
    return ItemResult(facades=tuple(facades), warnings=tuple(warnings))


def join(job: Job, parts: list[ItemResult]) -> StageResult:
    """Count the pictures, and repeat what reading the photos had to say."""
    photos: PhotoSet | None = next(iter(job.payload.values()), None)
    return replace(gather(job, parts), notes=tuple(photos.notes) if photos else ())


def ortho_warnings(name: str, ortho: OrthoImage) -> list[StageWarning]:
    """Return what was found about the photos, such as another depth of the facade than that of the scan."""
    warnings = [StageWarning(name, r.code, r.message, r.hint) for r in ortho.remarks]
    found = ortho.photo_offset
    if found is None or not found.applied:
        return warnings
    side = "behind" if found.value > 0 else "in front of"
    text = (
        f"the photos see the facade {abs(found.value) * 1000:.1f} mm {side} the scan "
        f"(standard error {found.sigma * 1000:.1f} mm); its picture is drawn where the photos see it"
    )
    hint = "one of the two is shifted: check the scan's georeference and the poses"
    return [*warnings, StageWarning(name, "F303", text, hint)]


def _picture(
    job: Job, seen: Seen, facade: Facade, photos: PhotoSet | None, light: dict[str, Array]
) -> OrthoImage | Failed:
    assert seen.scan is not None
    images = photos.image if photos else None
    poses = photos.photos if photos else ()
    return make_ortho(
        facade,
        seen.scan,
        poses,
        images,
        surroundings=seen.surroundings,
        options=job.project.ortho,
        turns=photos.turns if photos else None,
        light=light,
    )


STAGE = Stage(
    name="ortho",
    after=("facades", After("orient")),
    tasks=tasks,
    load=load,
    work=work,
    save=save,
    join=join,
    part=ItemResult,
    rooms=("ortho",),
    inputs=("photos",),
    options=("ortho", "photos"),
)
