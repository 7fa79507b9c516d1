"""The stage `orient`: photos oriented against each other and against the scan (paper B, section 2.2)."""

from dataclasses import dataclass

from frontage.errors import InputError
from frontage.geometry.arrays import Float
from frontage.io.photos.photoset import PhotoSet
from frontage.model import Scan
from frontage.orientation import KeyPoints, Orientation, PairMatches, orient_photos
from frontage.orientation.ties import build_blocks
from frontage.pipeline.stage import After, Job, Stage
from frontage.pipeline.stages.keypoints import free_photos, given_photos, tie_options
from frontage.pipeline.stages.scans import approximate
from frontage.pipeline.store.results import StageResult, StageWarning

_FREE_SIGMA = 1e6  # of camera parameters that nothing is known of
_HINT = "see the section on photos in report.html"


@dataclass(frozen=True, eq=False)
class Matched:
    """The photos with what is known of them, their key points and matches, and the cloud in place."""

    photos: PhotoSet
    points: list[KeyPoints]
    pairs: list[PairMatches]
    scan: Scan


@dataclass(frozen=True, eq=False)
class Oriented:
    """The photos as given, and what orienting them found."""

    given: PhotoSet
    found: Orientation


def load(job: Job) -> Matched:
    """Read the cloud of all scans and what the photos have in common."""
    photos = given_photos(job)
    numbers = range(len(photos.photos))
    points = [job.store.key_points(k) for k in numbers]
    pairs = [pair for k in numbers for pair in job.store.matches(k)]
    return Matched(photos, points, pairs, job.store.cloud(registered=approximate(job.project)))


def work(job: Job, matched: Matched) -> Oriented:
    """Form blocks of photos, and take them into the frame of the scan."""
    photos, project = matched.photos, job.project
    sigmas = camera_sigmas(photos, project.orientation.calibration)
    ties = tie_options(project).model_copy(update={"self_calibrate": bool(sigmas)})
    job.progress.begin("orient", 4 * len(photos.photos))
    blocks = build_blocks(photos.photos, matched.points, matched.pairs, ties)
    try:
        found = orient_photos(
            photos.photos,
            blocks,
            matched.scan,
            photos.image,
            options=project.orientation,
            camera_sigmas=sigmas,
            rigs=photos.rigs,
            seed=project.project.seed,
            tell=lambda _: job.progress.advance("orient"),
        )
    except ValueError as error:
        raise InputError(f"{error}; choose another [orientation] source", code="O106") from None
    return Oriented(photos, found)


def camera_sigmas(photos: PhotoSet, calibration: str) -> list[Float]:
    """Return the standard errors of every photo's camera parameters; empty where all are held fixed."""
    if calibration == "fixed" or (calibration == "auto" and not photos.camera_sigmas):
        return []
    return [photos.camera_sigmas.get(p.id, p.camera.params * 0.0 + _FREE_SIGMA) for p in photos.photos]


def save(job: Job, oriented: Oriented) -> Oriented:
    """Write the report and a COLMAP model."""
    job.store.save_orientation(oriented.found, oriented.given, job.store.world())
    return oriented


def join(job: Job, parts: list[Oriented]) -> StageResult:
    """Count the oriented photos; name the others."""
    (oriented,) = parts
    found = oriented.found
    warnings = tuple(
        StageWarning(u.photo, u.code, f"{u.photo} was not oriented: {u.reason}", _HINT)
        for u in found.unoriented
    )
    notes = (*oriented.given.notes, *found.notes)
    return StageResult(items=len(found.photos), warnings=warnings, notes=notes)


STAGE = Stage(
    name="orient",
    after=("scans", After("register"), "matches"),
    load=load,
    work=work,
    save=save,
    join=join,
    table="orientation",
    applies=free_photos,
    rooms=("orientation",),
    inputs=("photos",),
    options=("photos", "orientation", "project.seed"),
)
