"""What a stage is: its work, and what that depends on.

A stage divides its work into items (one per building, or a single one for the whole run). Every item goes
through three functions of the stage::

    load(job)          files -> nouns          reads the run folder; an unreadable file ends the stage
    work(job, loaded)  nouns -> nouns          calls one room; touches no file
    save(job, made)    nouns -> files          writes the run folder and tells what was made (an `ItemResult`)

and `join(job, parts)` turns the parts into the result of the stage; its payload is what `tasks` returned.
Items run in worker processes; a stage without `tasks` has one item, which runs in the main process.
"""

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

from frontage.errors import FileError, FrontageError
from frontage.model import Failed
from frontage.pipeline.progress import Progress, Silent
from frontage.pipeline.project import Project
from frontage.pipeline.store.results import ItemResult, StageResult, StageWarning
from frontage.pipeline.store.store import Store

T = TypeVar("T")
logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Job:
    """What a stage works with: the run folder, the project, and the item at hand.

    item      id of the item, "" where the whole run is one
    payload   what `tasks` handed to this item
    progress  who is told; only in the main process
    """

    store: Store
    project: Project
    item: str = ""
    payload: Any = None
    stage: str = ""
    progress: Progress = field(default_factory=Silent)

    def each(self, items: Sequence[T]) -> Iterator[T]:
        """Yield the items and tell the progress."""
        self.progress.begin(self.stage, len(items))
        for item in items:
            yield item
            self.progress.advance(self.stage)


@dataclass(frozen=True)
class After:
    """A stage whose results another stage reads.

    optional  they are used where they exist, and may be absent or out of date when a stage runs alone
    when      tells for a run whether they are read at all
    """

    stage: str
    optional: bool = False
    when: Callable[[Store, Project], bool] | None = None


@dataclass(frozen=True, kw_only=True)
class Stage:
    """A step of the chain. All fields but the last three say what it does, those say what it depends on.

    name     in the manifest and in the markers
    after    the stages whose results it reads
    tasks    items with what each is handed; None: one item in the main process
    load, work, save, join   see the module
    part     type of what `save` returns; None: parts are not kept, the whole stage is done again
    result   type of what `join` returns
    commands further commands that run it, besides the one of its name
    table    the project's table that this command may change, by default the name
    applies  tells whether a project has any work for it
    rooms    the packages whose code it runs, besides `BASE`
    inputs   groups of input files that it reads ("scans", "photos", "model")
    options  names of the project's entries that its result depends on, such as "ortho" or "project.seed"
    """

    name: str
    after: tuple[str | After, ...] = ()
    tasks: Callable[[Job], Mapping[str, Any]] | None = None
    load: Callable[[Job], Any]
    work: Callable[[Job, Any], Any]
    save: Callable[[Job, Any], Any]
    join: Callable[[Job, list[Any]], StageResult]
    part: type | None = None
    result: type[StageResult] = StageResult
    commands: tuple[str, ...] = ()
    table: str = ""
    applies: Callable[[Project], bool] | None = None
    rooms: tuple[str, ...] = ()
    inputs: tuple[str, ...] = ()
    options: tuple[str, ...] = ()

    def follows(self, store: Store, project: Project) -> list[After]:
        """Return the stages that this one reads in this run."""
        edges = [After(edge) if isinstance(edge, str) else edge for edge in self.after]
        return [edge for edge in edges if edge.when is None or edge.when(store, project)]

    def needed(self, project: Project) -> bool:
        """Tell whether the project has any work for this stage."""
        return self.applies is None or self.applies(project)


def per_building(job: Job) -> dict[str, Any]:
    """Return one item per building of the run, with nothing to hand over."""
    return {record.id: None for record in job.store.building_records()}


def gather(job: Job, parts: Sequence[ItemResult]) -> StageResult:
    """Return the result of a stage whose items are the facades of its parts."""
    items = sum(len(part.facades) for part in parts)
    return StageResult(items=items, warnings=tuple(w for part in parts for w in part.warnings))


def attempt(item: str, function: Callable[[], T]) -> T | Failed:
    """Return what `function` returns, or why it failed.

    Unreadable files are raised again, because all items would meet them.
    """
    try:
        return function()
    except FileError:
        raise
    except FrontageError as error:
        return Failed(error.code, str(error))
    except Exception as error:
        logger.info("%s failed", item, exc_info=error)
        text = f"unexpected {type(error).__name__}: {error}"
        return Failed("E999", text, "this is a bug in Frontage; run with -v for the traceback and report it")


def warned(item: str, made: T | Failed) -> tuple[StageWarning, ...]:
    """Return the warning of a failure as a tuple, empty for anything else."""
    return (StageWarning.of(item, made),) if isinstance(made, Failed) else ()
