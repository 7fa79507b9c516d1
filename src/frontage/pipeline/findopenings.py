"""The openings of one building's facades: a picklable task, like those of `tasks`."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from frontage.catalog import number_building
from frontage.model import Building, Elements, Facade, Failed, Scan
from frontage.openings.find import find_openings
from frontage.openings.options import OpeningOptions
from frontage.pipeline.elements import check_elements, remove_elements, save_elements
from frontage.pipeline.openingpictures import remove_pictures, save_pictures
from frontage.pipeline.records import failed_record
from frontage.pipeline.tasks import Task, as_failed, load_cloud
from frontage.pipeline.workspace import Workspace

_NAMED = 4  # facades that a shared note names


@dataclass(frozen=True)
class OpeningsTask(Task):
    """Find the openings of one building's facades."""

    options: OpeningOptions


def openings_task(task: OpeningsTask) -> dict[str, Any]:
    """Openings of one building's facades to their folders.

    Returns `{"facades": [id, ...], "openings": [id, ...], "protrusions": [id, ...], "notes": {facade: [...]},
    "pictures": {facade: [...]}, "warnings": [...]}`; `facades` are those that were judged.
    """
    workspace = Workspace(task.out)
    if not task.redo and (marker := workspace.done("openings", task.id, task.key)):
        return dict(marker["result"])
    names = workspace.facades_of(task.id)
    result: dict[str, Any] = {"facades": [], "openings": [], "protrusions": [], "warnings": []}
    result |= {"notes": {}, "pictures": {}}
    if names:
        scan, building = load_cloud(task, workspace)
        workspace.begin("openings", task.id)
        judged: list[tuple[Facade, Elements]] = []
        for name in names:
            remove_elements(workspace.facade_folder(name))
            remove_pictures(workspace.facade_folder(name))
            facade = workspace.load_facade(name)
            elements = _find(facade, scan, options_at(facade, building, task.options))
            if isinstance(elements, Failed):
                result["warnings"].append(failed_record(name, elements))
            else:
                judged.append((facade, elements))
        for facade, elements in _numbered(judged, building, task.options):
            save_elements(workspace.facade_folder(facade.id), facade, elements)
            _tell(elements, result)
            _picture(task, workspace, facade, elements, scan, result)
    workspace.finish("openings", task.id, task.key, result)
    return result


def _numbered(
    judged: list[tuple[Facade, Elements]], building: Building, options: OpeningOptions
) -> list[tuple[Facade, Elements]]:
    """Floors, bays and ids, with floors that agree between the facades."""
    facades = [facade for facade, _ in judged]
    ground = building.ground_z
    if facades and options.ground_z is not None:
        frame = facades[0].frame
        ground = float(frame.t[2] + frame.R[2, 2] * options.ground_z)
    return list(zip(facades, number_building(facades, [e for _, e in judged], ground), strict=True))


def _tell(elements: Elements, result: dict[str, Any]) -> None:
    """Add what was found on one facade."""
    result["facades"].append(elements.facade)
    result["openings"] += [o.id for o in elements.openings]
    result["protrusions"] += [p.id for p in elements.protrusions]
    result["notes"][elements.facade] = list(elements.notes)


def _picture(
    task: OpeningsTask,
    workspace: Workspace,
    facade: Facade,
    elements: Elements,
    scan: Scan,
    result: dict[str, Any],
) -> None:
    """The facade's pictures; openings without them are better than none."""
    try:
        pictures = save_pictures(workspace, facade, elements, scan, task.options)
        result["pictures"][facade.id] = pictures
    except Exception as error:
        result["warnings"].append(failed_record(facade.id, as_failed(error, facade.id)))


def _find(facade: Facade, scan: Scan, options: OpeningOptions) -> Elements | Failed:
    try:
        found = find_openings(facade, scan, options)
        return found if isinstance(found, Failed) else check_elements(found)
    except Exception as error:
        return as_failed(error, facade.id)


def options_at(facade: Facade, building: Building, options: OpeningOptions) -> OpeningOptions:
    """The options with the building's ground height, where it is known and none was given.

    In the facade's frame: the z of its z axis at that height, for x is horizontal.
    """
    if options.ground_z is not None or not np.isfinite(building.ground_z):
        return options
    rise = float(facade.frame.R[2, 2])
    return options.model_copy(update={"ground_z": (building.ground_z - float(facade.frame.t[2])) / rise})


def shared_notes(results: Iterable[dict[str, Any]]) -> list[str]:
    """What was noted of the facades: each note once, with the facades that it was noted of."""
    facades: dict[str, list[str]] = defaultdict(list)
    for result in results:
        for name, notes in result["notes"].items():
            for note in notes:
                facades[note.removeprefix(f"facade {name}: ")].append(name)
    return [f"{_names(names)}: {note}" for note, names in facades.items()]


def _names(names: list[str]) -> str:
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return "openings of " + ", ".join(names[:_NAMED]) + more
