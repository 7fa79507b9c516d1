"""The whole chain, or one stage of it, on a run folder."""

import platform
import time
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import frontage
from frontage.errors import FrontageError, OptionError, WorkspaceError
from frontage.pipeline.context import Progress, Run, Silent
from frontage.pipeline.files import code_hash, fingerprint, write_json
from frontage.pipeline.inputs import hash_inputs
from frontage.pipeline.project import Project
from frontage.pipeline.stages import STAGES, Stage
from frontage.pipeline.workspace import Workspace
from frontage.scale import make_executor

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
)


@dataclass(frozen=True)
class Summary:
    """What a run made: counts per stage, the facades with an ortho-image, and all warnings."""

    out: Path
    items: dict[str, int]
    facades: tuple[str, ...]
    warnings: tuple[dict[str, str], ...]
    notes: tuple[str, ...]
    seconds: float


def run(project: Project, out: Path | str, *, workers: int = 1, progress: Progress | None = None) -> Summary:
    """Run the whole chain into the folder `out`; what is finished there and still current is kept.

    Raises FrontageError (bad input, an unusable folder, or nothing found); earlier results stay intact.
    """
    _refuse_file(Path(out))
    inputs = hash_inputs(project)
    return _perform(Workspace.create(out), project, inputs, STAGES, (), workers, progress)


def run_stage(
    out: Path | str,
    stage: str,
    *,
    options: dict[str, Any] | None = None,
    workers: int = 1,
    progress: Progress | None = None,
) -> Summary:
    """Do one stage of a run folder again, with some options of its table replaced; later stages are not run.

    Raises FrontageError when the folder is none, an earlier stage is missing, or an option is out of range.
    """
    workspace = Workspace(out)
    manifest = workspace.manifest()
    if "project" not in manifest:
        raise WorkspaceError(f"{out}: nothing has run here yet; start with `frontage run`")
    project = _with_options(manifest["project"], stage, options or {})
    position = [s.name for s in STAGES].index(stage)
    if not STAGES[position].needed(project):
        raise OptionError(f"{out}: nothing to do for {stage!r}: all scans have trusted poses")
    _require_before(workspace, project, stage, stage_keys(project, manifest["inputs"]))
    return _perform(
        workspace, project, manifest["inputs"], STAGES[: position + 1], (stage,), workers, progress
    )


def stage_keys(project: Project, inputs: dict[str, Any]) -> dict[str, str]:
    """The fingerprint of every stage: of its code, its options, its inputs and the stage before."""
    keys: dict[str, str] = {}
    last = ""
    for stage in STAGES:
        last = keys[stage.name] = _key(stage, last, project, inputs)
    return keys


def _key(stage: Stage, before: str, project: Project, inputs: dict[str, Any]) -> str:
    hashes = [[entry["sha256"] for entry in inputs.get(group, [])] for group in stage.inputs]
    return fingerprint(before, stage.name, code_hash(stage.packages), stage.options(project), hashes)


def _perform(
    workspace: Workspace,
    project: Project,
    inputs: dict[str, Any],
    stages: Sequence[Stage],
    only: tuple[str, ...],
    workers: int,
    progress: Progress | None,
) -> Summary:
    """Stages in order; with `only`, those alone and in any case, else whatever is not current."""
    start = time.perf_counter()
    keys = stage_keys(project, inputs)
    with make_executor(workers) as executor:
        context = Run(workspace, project, executor, progress or Silent(), inputs)
        context.stages = dict(workspace.manifest().get("stages", {}))
        context.manifest = lambda: _manifest(context)
        for stage in stages:
            if stage.needed(project) and (not only or stage.name in only):
                context.key, context.redo = keys[stage.name], bool(only)
                if stage.follows:
                    context.key = _key(stage, keys[stage.follows], project, inputs)
                _one(context, stage, keys[stage.name])
    summary = _summary(context, time.perf_counter() - start)
    if not only and not summary.facades:
        raise FrontageError(_nothing(summary), code="F100")
    return summary


def _one(context: Run, stage: Stage, key: str) -> None:
    """One stage: kept when its marker is current, done otherwise; then the manifest tells of it."""
    start = time.perf_counter()
    marker = None if context.redo else context.workspace.done(stage.name, key=key)
    if marker is None:
        result = stage.work(context)
        context.workspace.finish(stage.name, "", key, result)
    else:
        result = marker["result"]
    seconds = time.perf_counter() - start
    if marker is None or stage.name not in context.stages:
        context.stages[stage.name] = {"key": key, "seconds": round(seconds, 3), **result}
    write_json(context.workspace.manifest_path, _manifest(context))
    context.progress.end(stage.name, seconds, marker is not None, result)


def _manifest(context: Run) -> dict[str, Any]:
    order = [stage.name for stage in STAGES]
    stages = {name: context.stages[name] for name in order if name in context.stages}
    return {
        "frontage": frontage.__version__,
        "versions": _versions(),
        "seed": context.project.project.seed,
        "project": context.project.model_dump(mode="json"),
        "inputs": context.inputs,
        "world": stages.get("scans", {}).get("world"),
        "stages": stages,
        "warnings": [{"stage": n, **w} for n, s in stages.items() for w in s["warnings"]],
        "notes": [note for s in stages.values() for note in s["notes"]],
    }


def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for name in _LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _summary(context: Run, seconds: float) -> Summary:
    manifest = _manifest(context)
    items = {name: int(stage["items"]) for name, stage in manifest["stages"].items()}
    facades = tuple(context.workspace.ortho_ids())
    warnings = tuple(manifest["warnings"])
    return Summary(context.workspace.out, items, facades, warnings, tuple(manifest["notes"]), seconds)


def _nothing(summary: Summary) -> str:
    """Why there is no ortho-image at all, in one sentence."""
    found = f"{summary.items.get('buildings', 0)} buildings and {summary.items.get('facades', 0)} facades"
    reason = summary.warnings[0]["message"] if summary.warnings else _NO_WALL
    return (
        f"no ortho-image could be made: {found} were found in {summary.items.get('scans', 0):,} points "
        f"({reason}); see {summary.out / 'report.html'}"
    )


def _require_before(workspace: Workspace, project: Project, stage: str, keys: dict[str, str]) -> None:
    """What facades, pictures and openings are made from must be current; a report takes whatever is there."""
    needed = [s.name for s in STAGES if s.needed(project)]
    before = needed[: needed.index(stage)]
    (exact,) = [s.exact for s in STAGES if s.name == stage]
    for name in before if exact else before[:1]:
        if workspace.done(name, key=keys[name] if exact else None) is None:
            raise WorkspaceError(
                f"{workspace.out}: stage {name!r} is not finished, or was made with other options or another "
                f"version; run `frontage run` first"
            )


def _with_options(table: dict[str, Any], stage: str, options: dict[str, Any]) -> Project:
    from pydantic import ValidationError

    from frontage.pipeline.project import sentence

    (name,) = [s.table or s.name for s in STAGES if s.name == stage]
    changed = {**table, name: {**table.get(name, {}), **options}} if options else table
    try:
        return Project.model_validate(changed)
    except ValidationError as error:
        raise OptionError(sentence(error)) from None


def _refuse_file(out: Path) -> None:
    if out.exists() and not out.is_dir():
        raise WorkspaceError(f"{out} is a file; give another name for the run folder")
