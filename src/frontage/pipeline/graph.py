"""When the results of a stage are current, and how it is performed: once, for all stages.

Results are kept as long as their key is unchanged. The key of a stage is a fingerprint of the code of its
rooms, its options, the contents of its input files, and the keys of the stages in `after`: everything that
the result follows from, and nothing else.
"""

import hashlib
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import BaseModel

import frontage
from frontage.errors import WorkspaceError
from frontage.pipeline.progress import Progress
from frontage.pipeline.project import Project
from frontage.pipeline.stage import Job, Stage
from frontage.pipeline.store.files import fingerprint
from frontage.pipeline.store.manifest import InputFile, Inputs
from frontage.pipeline.store.markers import Marker
from frontage.pipeline.store.results import StageResult, result_from_json, result_to_json
from frontage.pipeline.store.store import Store
from frontage.scale import Executor

BASE = ("geometry", "model", "solve", "raster", "io", "pipeline")
"""Packages whose code every stage depends on."""


@dataclass(frozen=True)
class Graph:
    """The stages of a run in their order, and the keys that their results must have."""

    stages: tuple[Stage, ...]
    store: Store
    project: Project
    inputs: Inputs

    def stage(self, name: str) -> Stage:
        """Return the stage of this name."""
        return next(stage for stage in self.stages if stage.name == name)

    def key(self, stage: Stage) -> str:
        """Return the fingerprint of everything that the results of a stage follow from."""
        before = {
            edge.stage: self.key(self.stage(edge.stage)) for edge in stage.follows(self.store, self.project)
        }
        read = {group: [_identity(file) for file in self.inputs.get(group, ())] for group in stage.inputs}
        options = {name: _option(self.project, name) for name in stage.options}
        if not stage.needed(self.project):
            return fingerprint(stage.name, before)
        return fingerprint(stage.name, before, code_hash((*BASE, *stage.rooms)), options, read)

    def downstream(self, name: str, *, required: bool = False) -> list[Stage]:
        """Return the stages whose results follow from those of `name`, in their order.

        required: only those that cannot do without.
        """
        reached = {name}
        for stage in self.stages:
            edges = stage.follows(self.store, self.project)
            if any(edge.stage in reached and not (required and edge.optional) for edge in edges):
                reached.add(stage.name)
        return [stage for stage in self.stages if stage.name in reached - {name}]

    def require_before(self, stage: Stage) -> None:
        """Raise WorkspaceError unless everything that `stage` reads is there and current."""
        for edge in stage.follows(self.store, self.project):
            before = self.stage(edge.stage)
            if edge.optional:
                continue
            if before.needed(self.project) and self.kept(before) is None:
                raise WorkspaceError(
                    f"{self.store.out}: stage {before.name!r} is not finished, or was made with other "
                    "options or another version; run `frontage run` first"
                )
            self.require_before(before)

    def kept(self, stage: Stage, *, thorough: bool = False) -> StageResult | None:
        """Return the result of a stage if it and its items are current and their files are in place."""
        key, markers = self.key(stage), self.store.markers
        marker = markers.current(stage.name, "", key, thorough=thorough)
        if marker is None:
            return None
        for item in marker.items:
            if markers.current(stage.name, item, _item_key(key, item), thorough=thorough) is None:
                return None
        try:
            return result_from_json(stage.result, marker.result)
        except ValueError:
            return None

    def perform(
        self,
        stage: Stage,
        executor: Executor,
        progress: Progress,
        *,
        redo: bool = False,
        thorough: bool = False,
    ) -> StageResult:
        """Do the work of a stage. Items that are current are kept unless `redo`.

        Earlier results stay in place until there are new ones: only then are they withdrawn, together with
        everything that follows from them.
        """
        job = Job(self.store, self.project, stage=stage.name, progress=progress)
        items: tuple[str, ...] = ()
        if stage.tasks is None:
            made = stage.work(job, stage.load(job))
            self._withdraw(stage)
            with self.store.recording() as written:
                result = stage.join(job, [stage.save(job, made)])
        else:
            payloads = stage.tasks(job)
            tasks = [self._task(stage, item, payload, redo, thorough) for item, payload in payloads.items()]
            if stage.part is not None:
                items = tuple(payloads)
                self._withdraw(stage)
            progress.begin(stage.name, len(tasks))
            parts = executor.map(_perform, tasks, lambda _: progress.advance(stage.name))
            if stage.part is None:
                self._withdraw(stage)
            with self.store.recording() as written:
                result = stage.join(replace(job, payload=payloads), parts)
        marker = Marker(self.key(stage), result_to_json(result), items=items)
        self.store.markers.finish(stage.name, "", marker, written)
        return result

    def _task(self, stage: Stage, item: str, payload: Any, redo: bool, thorough: bool) -> "_ItemTask":
        job = Job(self.store, self.project, item, payload, stage.name)
        after = tuple(later.name for later in self.downstream(stage.name))
        return _ItemTask(stage, job, _item_key(self.key(stage), item), after, redo, thorough)

    def _withdraw(self, stage: Stage) -> None:
        """Declare a stage and what follows from it out of date; items only where all of them are."""
        after = self.downstream(stage.name)
        for one in (stage, *after):
            self.store.markers.withdraw(one.name)
        if stage.tasks is None:
            for later in after:
                for item in self.store.markers.items(later.name):
                    self.store.markers.withdraw(later.name, item)


@dataclass(frozen=True)
class _ItemTask:
    """An item of a stage, picklable; `after`: the stages that follow from it."""

    stage: Stage
    job: Job
    key: str
    after: tuple[str, ...]
    redo: bool
    thorough: bool


def _perform(task: _ItemTask) -> Any:
    """Perform one item in a worker process, or return what it made before if that is current."""
    stage, job, markers = task.stage, task.job, task.job.store.markers
    if stage.part is None:
        return stage.save(job, stage.work(job, stage.load(job)))
    if not task.redo:
        marker = markers.current(stage.name, job.item, task.key, thorough=task.thorough)
        if marker is not None:
            return result_from_json(stage.part, marker.result)
    made = stage.work(job, stage.load(job))
    for name in (stage.name, *task.after):
        markers.withdraw(name, job.item)
    with job.store.recording() as written:
        part = stage.save(job, made)
    markers.finish(stage.name, job.item, Marker(task.key, result_to_json(part)), written)
    return part


@cache
def code_hash(packages: tuple[str, ...]) -> str:
    """Return a fingerprint of the source of packages and modules ("studies/score.py") of Frontage.

    Results of other code are not current.
    """
    root = Path(frontage.__file__).parent
    digest = hashlib.sha256(frontage.__version__.encode())
    for package in sorted(packages):
        place = root / package
        for source in [place] if place.is_file() else sorted(place.rglob("*")):
            if source.suffix in (".py", ".html", ".css"):
                digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _identity(file: InputFile) -> list[str]:
    """What a result depends on: the name of a file, which names photos and scans, and its contents."""
    return [Path(file.path).name, file.sha256]


def _item_key(key: str, item: str) -> str:
    return fingerprint(key, item)


def _option(project: Project, name: str) -> Any:
    """Return an entry of the project as JSON, with file names instead of paths: contents are hashed."""
    value: Any = project
    for part in name.split("."):
        value = None if value is None else getattr(value, part)
    return _unplaced(_plain(value))


def _plain(value: Any) -> Any:
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    return [_plain(v) for v in value] if isinstance(value, tuple) else value


def _unplaced(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _unplaced(entry) for name, entry in value.items()}
    if isinstance(value, list):
        return [_unplaced(entry) for entry in value]
    return Path(value).name if isinstance(value, str) and Path(value).is_absolute() else value
