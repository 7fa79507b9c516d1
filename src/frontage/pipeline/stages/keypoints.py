"""The stage `keypoints`: the key points of every photo that has to be oriented (paper B, section 2.2.1)."""

from dataclasses import dataclass
from typing import Any

from frontage.geometry.arrays import Array
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.read import read_photos
from frontage.orientation import KeyPoints
from frontage.orientation.ties import TieOptions, key_points
from frontage.orientation.ties.colmap import require
from frontage.pipeline.project import Project
from frontage.pipeline.stage import Job, Stage
from frontage.pipeline.store.results import StageResult


@dataclass(frozen=True)
class PhotoResult:
    """How many key points a photo has."""

    photo: str
    count: int


def free_photos(project: Project) -> bool:
    """Tell whether the project has photos whose poses are not known exactly."""
    return project.photos is not None and project.photos.pose != "trusted"


def given_photos(job: Job) -> PhotoSet:
    """Read the photos with what is known of their poses, without pixels."""
    source = job.project.photos
    assert source is not None  # the stage does not apply otherwise
    return read_photos(source, job.store.world())


def item_of(number: int) -> str:
    """Return the item of a photo, by its number among the given ones."""
    return f"{number:04d}"


def tie_options(project: Project) -> TieOptions:
    """Return the options of the photos' orientation to one another."""
    asked = project.orientation
    return TieOptions(side=asked.picture_side, most=asked.key_points, seed=project.project.seed)


def tasks(job: Job) -> dict[str, tuple[str, PhotoSet]]:
    """Return every photo by its number. Raises MissingExtra early, before the long work."""
    require()
    photos = given_photos(job)
    return {item_of(k): (photo.id, photos) for k, photo in enumerate(photos.photos)}


def load(job: Job) -> Array:
    """Decode a photo."""
    name, photos = job.payload
    image: Array = photos.image(name)
    return image


def work(job: Job, image: Array) -> KeyPoints:
    """Find its key points."""
    return key_points(image, tie_options(job.project))


def save(job: Job, points: KeyPoints) -> PhotoResult:
    """Write them."""
    job.store.save_key_points(int(job.item), points)
    return PhotoResult(job.payload[0], len(points))


def join(job: Job, parts: list[Any]) -> StageResult:
    """Count the photos."""
    return StageResult(items=len(parts))


STAGE = Stage(
    name="keypoints",
    after=("scans",),
    tasks=tasks,
    load=load,
    work=work,
    save=save,
    join=join,
    part=PhotoResult,
    commands=("orient",),
    table="orientation",
    applies=free_photos,
    rooms=("orientation",),
    inputs=("photos",),
    options=("photos", "orientation.key_points", "orientation.picture_side", "project.seed"),
)
