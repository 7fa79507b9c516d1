"""What a stage works with: the run folder, the project, where tasks run, and who is told of progress."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar

from frontage.pipeline.files import fingerprint
from frontage.pipeline.project import Project
from frontage.pipeline.workspace import Workspace
from frontage.scale import Executor

Item = TypeVar("Item")
Out = TypeVar("Out")


class Progress(Protocol):
    """Who is told what happens; every method may be called often and must be cheap."""

    def begin(self, stage: str, total: int) -> None:
        """A stage starts with `total` items (0 = unknown)."""

    def advance(self, stage: str) -> None:
        """One item is finished."""

    def end(self, stage: str, seconds: float, kept: bool, result: dict[str, Any]) -> None:
        """A stage is finished; `kept` = nothing had to be done."""


class Silent:
    """Tells nobody."""

    def begin(self, stage: str, total: int) -> None:
        """See `Progress.begin`."""

    def advance(self, stage: str) -> None:
        """See `Progress.advance`."""

    def end(self, stage: str, seconds: float, kept: bool, result: dict[str, Any]) -> None:
        """See `Progress.end`."""


@dataclass
class Run:
    """One run, shared by its stages; `key` = that of the stage's tasks, `redo` = finished ones too."""

    workspace: Workspace
    project: Project
    executor: Executor
    progress: Progress
    inputs: dict[str, Any]
    key: str = ""
    redo: bool = False
    stages: dict[str, Any] = field(default_factory=dict)
    manifest: Callable[[], dict[str, Any]] = dict

    def item_key(self, item: str) -> str:
        """The key of one task of the current stage."""
        return fingerprint(self.key, item)

    def each(self, stage: str, items: Sequence[Item]) -> Iterator[Item]:
        """The items, telling progress."""
        self.progress.begin(stage, len(items))
        for item in items:
            yield item
            self.progress.advance(stage)

    def map(self, stage: str, task: Callable[[Item], Out], items: Sequence[Item]) -> list[Out]:
        """Run tasks on the executor, telling progress; results in the order of the items."""
        self.progress.begin(stage, len(items))
        return self.executor.map(task, items, lambda _: self.progress.advance(stage))
