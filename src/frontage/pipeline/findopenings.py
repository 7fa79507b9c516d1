"""The openings of one building's facades: a picklable task, like those of `tasks`."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from frontage.catalog import number_building
from frontage.io.rasters.ortho import read_ortho
from frontage.model import Building, Elements, Facade, Failed, OrthoImage, Photo, Scan
from frontage.openings import FoundOpenings, OpeningOptions, find_openings
from frontage.openings.duplicates import without_duplicates
from frontage.pipeline.elements import check_elements, load_elements, remove_elements, save_elements
from frontage.pipeline.openingpictures import draw_openings, remove_pictures, save_evidence
from frontage.pipeline.records import failed_record
from frontage.pipeline.sightlines import Surfaces, photo_views, scanned_surfaces
from frontage.pipeline.tasks import Task, as_failed, load_cloud
from frontage.pipeline.workspace import Workspace

_NAMED = 4  # facades that a shared note names


@dataclass(frozen=True)
class OpeningsTask(Task):
    """Find the openings of one building's facades; `photos` of the run, which may show them.

    `pictured`: closed openings are looked for in the ortho-images, as the scans do not tell how walls look.
    """

    options: OpeningOptions
    photos: tuple[Photo, ...] = ()
    pictured: bool = False


def openings_task(task: OpeningsTask) -> dict[str, Any]:
    """Openings of one building's facades to their folders, with the photos that show them, and drawn.

    Returns `{"facades": [id, ...], "openings": [id, ...], "protrusions": [id, ...], "notes": {facade: [...]},
    "pictures": {facade: [...]}, "warnings": [...]}`; `facades` are those that were judged. Unless `pictured`,
    what was found depends on neither photos nor ortho-images: it is kept where only these are new.
    """
    workspace = Workspace(task.out)
    marker = None if task.redo else workspace.done("openings", task.id, task.key)
    result = dict(marker["result"]) if marker else _search(task, workspace)
    scanned = scanned_surfaces(workspace) if task.photos and result["openings"] else None
    failed = [f for name in result["facades"] if (f := _show(task, workspace, name, scanned, result))]
    return result | {"warnings": [*result["warnings"], *failed]}


def _search(task: OpeningsTask, workspace: Workspace) -> dict[str, Any]:
    """Find the openings and write them, with the pictures of what they were found from."""
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
            ortho = _ortho(workspace, name) if task.pictured else None
            found = _find(facade, scan, options_at(facade, building, task.options), ortho)
            if isinstance(found, Failed):
                result["warnings"].append(failed_record(name, found))
            else:
                judged.append((facade, found.elements))
                _evidence(workspace, facade, found, result)
        for facade, elements in _numbered(without_duplicates(judged, scan), building, task.options):
            save_elements(workspace.facade_folder(facade.id), facade, elements)
            _tell(elements, result)
    workspace.finish("openings", task.id, task.key, result)
    return result


def _show(
    task: OpeningsTask, workspace: Workspace, name: str, scanned: Surfaces | None, result: dict[str, Any]
) -> dict[str, str] | None:
    """Tell which photos show a facade's openings, and draw them; what failed."""
    folder = workspace.facade_folder(name)
    try:
        facade, elements = workspace.load_facade(name), load_elements(folder, name)
        outlines = [(o.ring, elements.wall_y(o)) for o in elements.openings]
        views = photo_views(facade, outlines, task.photos, scanned)
        shown = [tuple(view.photo for view in own) for own in views]
        if shown != [o.photos for o in elements.openings]:
            seen = (replace(o, photos=p) for o, p in zip(elements.openings, shown, strict=True))
            elements = replace(elements, openings=tuple(seen))
            save_elements(folder, facade, elements)
        draw_openings(workspace, facade, elements, result["pictures"].get(name, []))
    except Exception as error:
        return failed_record(name, as_failed(error, name))
    return None


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


def _evidence(workspace: Workspace, facade: Facade, found: FoundOpenings, result: dict[str, Any]) -> None:
    """Pictures of what the openings were found from; openings without them are better than none."""
    try:
        result["pictures"][facade.id] = save_evidence(workspace, facade, found.evidence)
    except Exception as error:
        result["warnings"].append(failed_record(facade.id, as_failed(error, facade.id)))


def _ortho(workspace: Workspace, name: str) -> OrthoImage | None:
    folder = workspace.facade_folder(name)
    return read_ortho(folder) if name in workspace.ortho_ids() else None


def _find(
    facade: Facade, scan: Scan, options: OpeningOptions, ortho: OrthoImage | None = None
) -> FoundOpenings | Failed:
    try:
        found = find_openings(facade, scan, options, ortho)
        if not isinstance(found, Failed):
            check_elements(found.elements)
        return found
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
