"""The work per building: picklable tasks that read files, call one room, and write files.

What goes wrong with one building or facade becomes a warning with its code; only bad input (a photo that
cannot be read) ends the run, with one sentence.
"""

import logging
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import FileError, FrontageError
from frontage.facades import FacadeOptions, find_facades
from frontage.io.photos.read import PhotoSet
from frontage.io.rasters.ortho import FILES as ORTHO_FILES
from frontage.io.rasters.ortho import write_ortho
from frontage.io.scans.npz import load_scan
from frontage.model import Building, Facade, Failed, OrthoImage, Scan
from frontage.ortho import OrthoOptions, make_ortho
from frontage.pipeline.elements import remove_elements
from frontage.pipeline.openingpictures import remove_pictures
from frontage.pipeline.records import building_from_record, failed_record, load_facade, save_facade
from frontage.pipeline.workspace import Workspace

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Task:
    """One building's turn in a stage: its record, its result's key, whether to redo what is finished."""

    out: Path
    building: dict[str, Any]
    key: str
    redo: bool

    @property
    def id(self) -> str:
        """The building's id."""
        return str(self.building["id"])


@dataclass(frozen=True)
class FacadesTask(Task):
    """Find the facades of one building."""

    options: FacadeOptions
    seed: int


@dataclass(frozen=True)
class OrthoTask(Task):
    """Make the ortho-images of one building's facades."""

    options: OrthoOptions
    photos: PhotoSet | None


def facades_task(task: FacadesTask) -> dict[str, Any]:
    """Facades of one building to OUT/facades; returns `{"facades": [id, ...], "warnings": [...]}`."""
    workspace = Workspace(task.out)
    if not task.redo and (marker := workspace.done("facades", task.id, task.key)):
        return dict(marker["result"])
    before = workspace.facades_of(task.id)
    found = _find(task, workspace)
    facades = [f for f in found if isinstance(f, Facade)]
    warnings = [failed_record(task.id, f) for f in found if isinstance(f, Failed)]
    result = {"facades": [f.id for f in facades], "warnings": warnings}
    workspace.begin("facades", task.id)
    workspace.begin("ortho", task.id)  # its pictures are of other planes now
    workspace.begin("openings", task.id)
    for facade in facades:
        remove_elements(workspace.facade_folder(facade.id))
        remove_pictures(workspace.facade_folder(facade.id))
        save_facade(workspace.facade_folder(facade.id), facade)
    for stale in set(before) - {f.id for f in facades}:
        shutil.rmtree(workspace.facade_folder(stale), ignore_errors=True)
    workspace.finish("facades", task.id, task.key, result)
    return result


def ortho_task(task: OrthoTask) -> dict[str, Any]:
    """Ortho-images of one building; returns `{"orthos": [facade id, ...], "warnings": [...]}`."""
    workspace = Workspace(task.out)
    if not task.redo and (marker := workspace.done("ortho", task.id, task.key)):
        return dict(marker["result"])
    names = workspace.facades_of(task.id)
    result: dict[str, Any] = {"orthos": [], "warnings": []}
    if names:
        scan, _ = load_cloud(task, workspace)
        surroundings = load_scan(workspace.surroundings_path) if task.photos is not None else None
        workspace.begin("ortho", task.id)
        for name in names:
            ortho = _ortho(task, workspace, name, scan, surroundings)
            if isinstance(ortho, Failed):
                _remove_ortho(workspace.facade_folder(name))
                result["warnings"].append(failed_record(name, ortho))
            else:
                write_ortho(workspace.facade_folder(name), ortho)
                result["orthos"].append(name)
                result["warnings"].extend(ortho_warnings(name, ortho))
    workspace.finish("ortho", task.id, task.key, result)
    return result


def _find(task: FacadesTask, workspace: Workspace) -> tuple[Facade | Failed, ...]:
    try:
        scan, building = load_cloud(task, workspace)
        return find_facades(scan, building, task.options, task.seed)
    except Exception as error:
        return (as_failed(error, task.id),)


def _ortho(
    task: OrthoTask, workspace: Workspace, name: str, scan: Scan, surroundings: Scan | None
) -> OrthoImage | Failed:
    try:
        facade = load_facade(workspace.facade_folder(name))
        photos = task.photos.photos if task.photos else ()
        image_of = task.photos.image if task.photos else None
        return make_ortho(facade, scan, photos, image_of, surroundings=surroundings, options=task.options)
    except Exception as error:
        return as_failed(error, name)


def ortho_warnings(name: str, ortho: OrthoImage) -> list[dict[str, str]]:
    """What is to be said of an ortho-image: that scan and photos put the facade at different depths."""
    found = ortho.photo_offset
    if found is None or not found.applied:
        return []
    side = "behind" if found.value > 0 else "in front of"
    text = (
        f"the photos see the facade {abs(found.value) * 1000:.1f} mm {side} the scan "
        f"(standard error {found.sigma * 1000:.1f} mm); its picture is drawn where the photos see it"
    )
    hint = "one of the two is shifted: check the scan's georeference and the poses"
    return [failed_record(name, Failed("F303", text, hint))]


def load_cloud(task: Task, workspace: Workspace) -> tuple[Scan, Building]:
    """The building's working cloud and the building, whose points index it."""
    stem = workspace.buildings_folder / task.id
    index = np.load(stem.with_suffix(".index.npy"), allow_pickle=False)
    return load_scan(stem.with_suffix(".npz")), building_from_record(task.building, index)


def as_failed(error: Exception, item: str) -> Failed:
    """An error as a warning of its item; an unreadable file is raised again: all items would meet it."""
    if isinstance(error, FileError):
        raise error
    logger.debug("%s failed", item, exc_info=error)
    if isinstance(error, FrontageError):
        return Failed(error.code, str(error))
    text = f"unexpected {type(error).__name__}: {error}"
    return Failed("E999", text, "this is a bug in Frontage; run with -v for the traceback and report it")


def _remove_ortho(folder: Path) -> None:
    for name in ORTHO_FILES:
        (folder / name).unlink(missing_ok=True)
