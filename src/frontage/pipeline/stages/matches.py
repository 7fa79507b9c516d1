"""The stage `matches`: photos matched with one another, pair by pair (paper B, section 2.2.1)."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from frontage.model import Photo
from frontage.orientation import KeyPoints, PairMatches
from frontage.orientation.ties import candidate_pairs, match_pair
from frontage.pipeline.stage import Job, Stage
from frontage.pipeline.stages.keypoints import free_photos, given_photos, item_of, tie_options
from frontage.pipeline.store.results import StageResult


@dataclass(frozen=True)
class MatchedPhoto:
    """With how many later photos a photo was matched."""

    photo: str
    pairs: int


@dataclass(frozen=True, eq=False)
class _Task:
    """A photo, and the later ones that it may have something in common with."""

    photos: tuple[Photo, ...]
    partners: tuple[int, ...]


def tasks(job: Job) -> dict[str, _Task]:
    """Return every photo with the later ones that it is to be matched with."""
    photos = given_photos(job).photos
    points = [job.store.key_points(k) for k in range(len(photos))]
    partners = defaultdict[int, list[int]](list)
    for first, second in candidate_pairs(photos, points):
        partners[first].append(second)
    return {item_of(k): _Task(photos, tuple(partners[k])) for k in range(len(photos))}


def load(job: Job) -> list[KeyPoints]:
    """Read the key points of a photo and of its partners."""
    return [job.store.key_points(k) for k in (int(job.item), *job.payload.partners)]


def work(job: Job, points: Sequence[KeyPoints]) -> list[PairMatches]:
    """Match the photo with its partners."""
    task: _Task = job.payload
    first, options = int(job.item), tie_options(job.project)
    found = []
    for second, theirs in zip(task.partners, points[1:], strict=True):
        cameras = task.photos[first].camera, task.photos[second].camera
        pair = match_pair(points[0], theirs, *cameras, first=first, second=second, options=options)
        if pair is not None:
            found.append(pair)
    return found


def save(job: Job, pairs: list[PairMatches]) -> MatchedPhoto:
    """Write the matches."""
    job.store.save_matches(int(job.item), pairs)
    return MatchedPhoto(job.payload.photos[int(job.item)].id, len(pairs))


def join(job: Job, parts: list[Any]) -> StageResult:
    """Count the pairs."""
    return StageResult(items=sum(part.pairs for part in parts))


STAGE = Stage(
    name="matches",
    after=("keypoints",),
    tasks=tasks,
    load=load,
    work=work,
    save=save,
    join=join,
    part=MatchedPhoto,
    commands=("orient",),
    table="orientation",
    applies=free_photos,
    rooms=("orientation",),
    inputs=("photos",),
    options=("photos", "orientation.key_points", "project.seed"),
)
