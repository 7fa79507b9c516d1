"""The whole chain, or one stage of it, on a run folder."""

import platform
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import frontage
from frontage.errors import FrontageError, OptionError, WorkspaceError
from frontage.pipeline.graph import Graph
from frontage.pipeline.inputs import hash_inputs
from frontage.pipeline.progress import Progress, Silent
from frontage.pipeline.project import Project, project_from_table
from frontage.pipeline.stage import Stage
from frontage.pipeline.stages import STAGES
from frontage.pipeline.store.lock import locked
from frontage.pipeline.store.manifest import Manifest, StageRecord
from frontage.pipeline.store.results import StageResult, StageWarning
from frontage.pipeline.store.store import Store
from frontage.scale import Executor, make_executor

_NO_WALL = "a wall is a storey high and has some points per metre; coordinates in metres, z up"
_LIBRARIES = (
    "numpy",
    "scipy",
    "laspy",
    "lazrs",
    "pyproj",
    "opencv-python-headless",
    "shapely",
    "tifffile",
    "pye57",
    "pycolmap",
)


@dataclass(frozen=True)
class Summary:
    """What a run made: counts per stage, the facades with an ortho-image, warnings, notes, time."""

    out: Path
    items: Mapping[str, int]
    facades: tuple[str, ...]
    warnings: tuple[tuple[str, StageWarning], ...]
    notes: tuple[str, ...]
    seconds: float


def run(
    project: Project,
    out: Path | str,
    *,
    workers: int = 1,
    progress: Progress | None = None,
    verify: bool = False,
) -> Summary:
    """Run the whole chain into the folder `out`; what is finished there and still current is kept.

    verify  compare the checksums of finished results, not only their sizes, and make damaged ones again

    Raises FrontageError (bad input, an unusable folder, or nothing found); earlier results stay intact.
    """
    start, folder = time.perf_counter(), Path(out)
    if folder.exists() and not folder.is_dir():
        raise WorkspaceError(f"{folder} is a file; give another name for the run folder")
    inputs = hash_inputs(project)
    graph = Graph(STAGES, Store.create(folder), project, inputs)
    with locked(folder):
        _perform(graph, STAGES, workers, progress or Silent(), redo=False, thorough=verify)
        graph.store.markers.sweep()
    summary = _summary(graph, time.perf_counter() - start)
    if not summary.facades:
        raise FrontageError(_nothing(summary), code="F100")
    return summary


def run_stage(
    out: Path | str,
    stage: str,
    *,
    options: Mapping[str, Any] | None = None,
    workers: int = 1,
    progress: Progress | None = None,
) -> Summary:
    """Run one stage of a run folder again, with some options of its table replaced; later stages are not run.

    Results per building that follow from it, such as pictures of planes that have changed, are removed. Other
    files of later stages stay, but are out of date: the next `run` makes them again.

    Raises FrontageError if the folder is none, an earlier stage is missing, or an option is out of range.
    """
    start, store = time.perf_counter(), Store(out)
    manifest = store.manifest()
    if manifest.project is None:
        raise WorkspaceError(f"{out}: nothing has run here yet; start with `frontage run`")
    chosen = [s for s in STAGES if stage in (s.name, *s.commands)]
    table = chosen[0].table or chosen[0].name
    changed = {table: {**manifest.project.get(table, {}), **options}} if options else {}
    project = project_from_table({**manifest.project, **changed})
    if not chosen[0].needed(project):
        what = "photos" if stage == "orient" else "scans"
        raise OptionError(f"{out}: nothing to do for {stage!r}: all {what} have trusted poses")
    graph = Graph(STAGES, store, project, manifest.inputs)
    graph.require_before(chosen[0])
    with locked(store.out):
        _perform(graph, chosen, workers, progress or Silent(), redo=True)
        later = [s.name for one in chosen for s in graph.downstream(one.name, required=True)]
        store.markers.sweep(set(later) - {one.name for one in chosen})
    return _summary(graph, time.perf_counter() - start)


def _perform(
    graph: Graph,
    stages: Sequence[Stage],
    workers: int,
    progress: Progress,
    *,
    redo: bool,
    thorough: bool = False,
) -> None:
    """Perform stages in order; without `redo` those that are current are kept."""
    with make_executor(workers) as executor:
        for stage in stages:
            if stage.needed(graph.project):
                _one(graph, stage, executor, progress, redo=redo, thorough=thorough)


def _one(
    graph: Graph, stage: Stage, executor: Executor, progress: Progress, *, redo: bool, thorough: bool
) -> None:
    """Keep or perform one stage; then the manifest tells of it."""
    start = time.perf_counter()
    kept = None if redo else graph.kept(stage, thorough=thorough)
    result = kept or graph.perform(stage, executor, progress, redo=redo, thorough=thorough)
    seconds = time.perf_counter() - start
    _tell(graph, stage, result, seconds, kept is not None)
    progress.end(stage.name, seconds, kept is not None, result.items)


def _tell(graph: Graph, stage: Stage, result: StageResult, seconds: float, kept: bool) -> None:
    """Write the manifest with the result of a stage."""
    before = graph.store.manifest()
    stages = dict(before.stages)
    if not kept or stage.name not in stages:
        stages[stage.name] = StageRecord.of(graph.key(stage), seconds, result)
    manifest = Manifest(
        frontage=frontage.__version__,
        versions=_versions(),
        seed=graph.project.project.seed,
        project=graph.project.model_dump(mode="json"),
        inputs=graph.inputs,
        stages={s.name: stages[s.name] for s in graph.stages if s.name in stages and s.needed(graph.project)},
    )
    graph.store.save_manifest(manifest)


def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for name in _LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _summary(graph: Graph, seconds: float) -> Summary:
    manifest = graph.store.manifest()
    return Summary(
        graph.store.out,
        {name: stage.items for name, stage in manifest.stages.items()},
        tuple(graph.store.facade_ids("ortho")),
        tuple(manifest.warnings),
        tuple(manifest.notes),
        seconds,
    )


def _nothing(summary: Summary) -> str:
    """Say in one sentence why there is no ortho-image at all."""
    found = f"{summary.items.get('buildings', 0)} buildings and {summary.items.get('facades', 0)} facades"
    reason = summary.warnings[0][1].message if summary.warnings else _NO_WALL
    return (
        f"no ortho-image could be made: {found} were found in {summary.items.get('scans', 0):,} points "
        f"({reason}); see {summary.out / 'report.html'}"
    )
