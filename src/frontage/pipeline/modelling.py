"""The stage `model`: facades, what was found on them and the city model become LoD3 buildings in files."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from frontage.exports import FacadePicture, building_mesh, city_buildings, drawn, picture
from frontage.io.citymodels.citygml.write import write_citygml
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.io.citymodels.read import read_city_model
from frontage.io.meshes.glb import GlbMesh, glb_of
from frontage.model import Building, Elements, Facade, Failed, WorldRef
from frontage.model.citymodel import CityBuilding, Shell
from frontage.pipeline.addressbook import known_addresses
from frontage.pipeline.context import Run
from frontage.pipeline.elements import found_elements
from frontage.pipeline.facadepicture import wall_picture
from frontage.pipeline.files import write_bytes, write_json
from frontage.pipeline.records import building_from_record, failed_record
from frontage.pipeline.tasks import as_failed
from frontage.pipeline.workspace import Workspace
from frontage.solids import Assembled, BuildOptions, assemble
from frontage.solids.matching import Group, match_model

FILES = ("lod3.city.json", "lod3.gml", "lod3_citygml3.gml", "lod3.glb", "report.json")
"""What the stage leaves in OUT/model, beside a picture per building in `pictures/`."""

_MARGIN = 20.0  # m around the scan: buildings of the model beyond are not read
_NAMED = 3  # messages of one code that a warning quotes

Result = dict[str, Any]


@dataclass(frozen=True)
class ModelTask:
    """One building to build: records of what was measured, and its shells in the city model.

    `owners`: ids of the model's buildings that the shells are of, with their addresses.
    """

    out: Path
    records: tuple[dict[str, Any], ...]
    shells: tuple[Shell, ...]
    owners: dict[str, str | None]
    options: BuildOptions


@dataclass(frozen=True, eq=False)
class Made:
    """What goes into the files for one measured building; `failed`: what does not, and why."""

    id: str
    buildings: tuple[CityBuilding, ...] = ()
    mesh: GlbMesh | None = None
    picture: bytes = b""
    about: Mapping[str, Any] | None = None
    failed: tuple[Failed, ...] = ()


def make_model(run: Run, world: WorldRef) -> Result:
    """Build every building, write OUT/model; see docs/model.md."""
    workspace, options = run.workspace, run.project.solids
    known, _ = known_addresses(workspace, run.project.addresses)
    records = {
        r["id"]: r | {"address": next(iter(known[r["id"]]), None)} for r in workspace.building_records()
    }
    city = _city_model(run, world)
    facades = {name: [workspace.load_facade(f) for f in workspace.facades_of(name)] for name in records}
    groups = match_model(facades, city, options)
    tasks = [
        ModelTask(
            workspace.out,
            tuple(records[n] for n in g.measured),
            _shells(g, city),
            {b.id: b.address for b in city if b.id in g.model},
            options,
        )
        for g in groups
    ]
    made = run.map("model", model_task, tasks)
    workspace.begin("model")
    _write(workspace, [m for m in made if m.buildings], world)
    warnings = [w for m in made for w in _warnings(m)]
    return {
        "items": sum(len(m.buildings) for m in made),
        "buildings": [b.id for m in made for b in m.buildings],
        "notes": _notes(made, groups),
        "warnings": warnings,
    }


def model_task(task: ModelTask) -> Made:
    """Build one building from the files of its facades."""
    workspace = Workspace(task.out)
    building = _joined(task.records)
    try:
        fronts = [_front(workspace, f) for r in task.records for f in workspace.facades_of(r["id"])]
        if not fronts:
            return Made(building.id)
        found = assemble(building, fronts, task.shells, fronts[0][0].world, task.options)
        if isinstance(found, Failed):
            return Made(building.id, failed=(found,))
        return _made(building, found, fronts, workspace, task)
    except Exception as error:
        return Made(building.id, failed=(as_failed(error, building.id),))


def _made(
    building: Building,
    found: Assembled,
    fronts: Sequence[tuple[Facade, Elements]],
    workspace: Workspace,
    task: ModelTask,
) -> Made:
    pictures = [p for f, _ in fronts if (p := _picture(workspace, f)) is not None]
    inward = np.array([(f.extent[2] - f.extent[0]) * f.frame.R[:, 1] for f, _ in fronts])
    image = picture(drawn(found), inward[np.linalg.norm(inward, axis=1).argmax()], inward)
    png = cv2.imencode(".png", image[..., ::-1])[1].tobytes()
    return Made(
        building.id,
        city_buildings(building, found, fronts, task.owners),
        building_mesh(found, pictures, task.options.max_offset + 1.0),
        png,
        _about(found, fronts),
        found.failed,
    )


def _about(found: Assembled, fronts: Sequence[tuple[Facade, Elements]]) -> dict[str, Any]:
    """What report.json says of a building."""
    faces = [f for b in found.built for f in b.solid.faces]
    offsets = {k: round(v, 4) for b in found.built for k, v in b.offsets.items()}
    return {
        "host": found.coarse.source,
        "lod": "3" if any(found.fine) else "2",
        "facades": [f.id for f, _ in fronts],
        "openings_found": sum(len(e.openings) for _, e in fronts),
        "openings_built": len({f.opening for f in faces if f.semantics in ("Window", "Door")}),
        "installations": [i.id for i in found.installations],
        "offsets": offsets,
        "refused": [{"code": f.code, "message": f.message, "hint": f.hint} for f in found.failed],
        "notes": list(found.notes),
    }


def _city_model(run: Run, world: WorldRef) -> tuple[CityBuilding, ...]:
    """The buildings of the project's city model near the scan."""
    source = run.project.model
    if source is None:
        return ()
    marker = run.workspace.done("scans")
    low, high = np.array(marker["result"]["extent"] if marker else [[-np.inf] * 3, [np.inf] * 3])
    box = (*(low[:2] - _MARGIN).tolist(), *(high[:2] + _MARGIN).tolist())
    return read_city_model(source.path, world, box, source.crs).buildings


def _shells(group: Group, city: Sequence[CityBuilding]) -> tuple[Shell, ...]:
    """The group's shells of LoD2 or below; of several buildings each is one part under its own id."""
    own = [b for b in city if b.id in group.model]
    if len(own) == 1:
        return own[0].level("2")
    return tuple(replace(s, part=b.id) for b in own for s in b.level("2") if not s.installation)


def _front(workspace: Workspace, name: str) -> tuple[Facade, Elements]:
    """A facade with what was found on it; nothing where it was not judged."""
    facade = workspace.load_facade(name)
    return facade, found_elements(workspace.facade_folder(name), name) or Elements(name, ())


def _picture(workspace: Workspace, facade: Facade) -> FacadePicture | None:
    folder = workspace.facade_folder(facade.id)
    return wall_picture(folder, facade) if (folder / "ortho.json").is_file() else None


def _joined(records: Sequence[dict[str, Any]]) -> Building:
    """One building of several measured ones: the first one's id, the first address, the lowest ground."""
    parts = [building_from_record(r, np.zeros(0, np.int64)) for r in records]
    grounds = [p.ground_z for p in parts if np.isfinite(p.ground_z)]
    address = next((p.address for p in parts if p.address), None)
    return replace(parts[0], address=address, ground_z=min(grounds, default=parts[0].ground_z))


def _write(workspace: Workspace, made: Sequence[Made], world: WorldRef) -> None:
    """All files of the model; without any building, none."""
    folder = workspace.out / "model"
    folder.mkdir(exist_ok=True)
    pictures = {folder / "pictures" / f"{m.id}.png": m.picture for m in made}
    for stale in set((folder / "pictures").glob("*.png")) - set(pictures):
        stale.unlink()
    if not made:
        for name in FILES:
            (folder / name).unlink(missing_ok=True)
        return
    buildings = [b for m in made for b in m.buildings]
    write_cityjson(folder / FILES[0], buildings, world, "Frontage LoD3")
    write_citygml(folder / FILES[1], buildings, world, "Frontage LoD3", "2.0")
    write_citygml(folder / FILES[2], buildings, world, "Frontage LoD3", "3.0")
    write_bytes(folder / FILES[3], glb_of([m.mesh for m in made if m.mesh is not None], world))
    write_json(folder / FILES[4], {m.id: m.about for m in made})
    for path, png in pictures.items():
        write_bytes(path, png)


def _warnings(made: Made) -> list[dict[str, str]]:
    """One warning per code: the first messages, and how many more there are."""
    by_code: dict[str, list[Failed]] = defaultdict(list)
    for failed in made.failed:
        by_code[failed.code].append(failed)
    found = []
    for code, own in by_code.items():
        more = f"; and {len(own) - _NAMED} more, see model/report.json" if len(own) > _NAMED else ""
        text = "; ".join(f.message for f in own[:_NAMED]) + more
        found.append(failed_record(made.id, Failed(code, text, own[0].hint)))
    return found


def _notes(made: Sequence[Made], groups: Sequence[Group]) -> list[str]:
    notes = []
    blocks = [m.id for m in made if m.about is not None and m.about["host"] == "cloud"]
    if blocks:
        some = ", ".join(blocks[:_NAMED]) + (
            f" and {len(blocks) - _NAMED} more" if len(blocks) > _NAMED else ""
        )
        notes.append(f"{some}: built on blocks behind their facades, for lack of a city model")
    for g in groups:
        if len(g.measured) > 1:
            notes.append(
                f"{', '.join(g.measured)} stand on one building of the city model and are one in the model"
            )
    return notes
