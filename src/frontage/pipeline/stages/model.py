"""The stage `model`: measured facades and the city model become LoD3 buildings (paper B, section 3.2)."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np

from frontage.catalog.addressbook import known_addresses
from frontage.exports import (
    FacadePicture,
    building_mesh,
    city_buildings,
    limit_texture,
    model_triangles,
    painted,
    render_model,
    texture_path,
)
from frontage.exports.tiles import building_tile
from frontage.geometry.arrays import Float
from frontage.io.citymodels.read import read_city_model
from frontage.model import Building, Elements, Facade, Failed
from frontage.model.citymodel import CityBuilding, Shell
from frontage.pipeline.gaps import BEFORE_MODEL, gaps
from frontage.pipeline.groundplans import ground_plans
from frontage.pipeline.modelfiles import Made, write_model
from frontage.pipeline.pictures import street_looks, wall_picture
from frontage.pipeline.products import without
from frontage.pipeline.stage import After, Job, Stage, attempt
from frontage.pipeline.store.records import BuildingRecord
from frontage.pipeline.store.results import StageResult, StageWarning
from frontage.solids import (
    Assembled,
    BuildOptions,
    ModelMatch,
    assemble,
    facades_of_matches,
    match_model,
)

_MARGIN_M = 20.0  # around the scan: buildings of the city model beyond are not read
# Farther than the options let a wall lie from its facade: oriels and recesses show pictures, too.
_BEYOND_OFFSET_M = 1.0
_NAMED = 3  # messages of one code that a warning quotes

Front = tuple[Facade, Elements]


@dataclass(frozen=True, kw_only=True)
class ModelResult(StageResult):
    """The buildings of the model; `items` counts them."""

    buildings: tuple[str, ...]


@dataclass(frozen=True)
class BuildingTask:
    """What one building is built from: records of what was measured, and its shells in the city model.

    facades  ids of those that stand on it; a neighbour's points may hold one of them
    owners   ids of the city model's buildings that the shells are of, with their addresses
    looks    by facade: by how much its picture is brightened, so that the street has one look
    """

    records: tuple[BuildingRecord, ...]
    facades: tuple[str, ...]
    shells: tuple[Shell, ...]
    owners: dict[str, str | None]
    looks: dict[str, Float]


@dataclass(frozen=True, eq=False)
class Measured:
    """The facades of a building with what was found on them, and their pictures."""

    fronts: tuple[Front, ...]
    pictures: tuple[FacadePicture, ...]


def tasks(job: Job) -> dict[str, BuildingTask]:
    """Return the buildings to build: those that stand on one building of the city model are one."""
    store, project = job.store, job.project
    records = {r.id: r for r in store.building_records()}
    known, _ = _addresses(job)
    records = {n: replace(r, address=next(iter(known[n]), None)) for n, r in records.items()}
    city = _city_model(job)
    facades = {name: [store.facade(f) for f in store.facades_of(name)] for name in records}
    found: dict[str, BuildingTask] = {}
    looks = street_looks(store, project.ortho)
    groups = match_model(facades, city, project.solids)
    on_groups = facades_of_matches(facades, groups, city, project.solids)
    for group, names in zip(groups, on_groups, strict=True):
        own = tuple(records[name] for name in group.measured)
        owners = {b.id: b.address for b in city if b.id in group.model}
        found[own[0].id] = BuildingTask(own, names, _shells(group, city), owners, looks)
    return found


def _addresses(job: Job) -> tuple[dict[str, list[str]], dict[str, str]]:
    """Return every building's addresses, and why an address of the project file is nobody's."""
    entries = job.project.addresses
    plans = ground_plans(job.store) if any(entry.at for entry in entries) else {}
    return known_addresses({r.id: r.address for r in job.store.building_records()}, plans, entries)


def load(job: Job) -> Measured:
    """Read the facades of a building, what was found on them, and their pictures."""
    store, task = job.store, job.payload
    fronts = tuple((store.facade(name), store.elements(name) or Elements(name, ())) for name in task.facades)
    pictures = (wall_picture(store, facade, task.looks.get(facade.id)) for facade, _ in fronts)
    return Measured(fronts, tuple(picture for picture in pictures if picture is not None))


def work(job: Job, measured: Measured) -> Made:
    """Build one building."""
    task, options = job.payload, job.project.solids
    building, names = _joined(task.records), tuple(record.id for record in task.records)
    if not measured.fronts:
        return Made(building.id, measured=names)

    def build() -> Made | Failed:
        world = measured.fronts[0][0].world
        found = assemble(building, measured.fronts, task.shells, world, options)
        return found if isinstance(found, Failed) else _made(building, found, measured, task, options)

    made = attempt(building.id, build)
    if isinstance(made, Failed):
        return Made(building.id, failed=(made,), measured=names)
    return replace(made, measured=names)


def save(job: Job, made: Made) -> Made:
    """Hand the building over: all buildings go into the same files."""
    return made


def join(job: Job, parts: list[Made]) -> ModelResult:
    """Write all files of the model; without any building, none."""
    built = [made for made in parts if made.buildings]
    lost = [made for made in parts if not made.buildings]
    failed = [f"{made.id}: {f.message} [{f.code}]" for made in lost for f in made.failed]
    if built:
        write_model(job.store, built, (*gaps(job.store, BEFORE_MODEL), *failed))
    bare = [made.id for made in lost if not made.failed]
    return ModelResult(
        items=sum(len(made.buildings) for made in parts),
        buildings=tuple(b.id for made in parts for b in made.buildings),
        notes=(
            *_notes(parts),
            *without(bare, "Without a facade, and so not in the model"),
            *_addresses(job)[1].values(),
        ),
        warnings=tuple(warning for made in parts for warning in _warnings(made)),
    )


def _made(
    building: Building, found: Assembled, measured: Measured, task: BuildingTask, options: BuildOptions
) -> Made:
    fronts, reach = measured.fronts, options.max_offset + _BEYOND_OFFSET_M
    inward = np.array([(f.extent[2] - f.extent[0]) * f.frame.R[:, 1] for f, _ in fronts])
    image = render_model(model_triangles(found), inward[np.linalg.norm(inward, axis=1).argmax()], inward)
    png = cv2.imencode(".png", image[..., ::-1])[1].tobytes()
    whole = city_buildings(building, found, fronts, task.owners)
    pictures = {texture_path(p.facade.id): limit_texture(p.jpeg) for p in measured.pictures}
    return Made(
        building.id,
        tuple(painted(one, measured.pictures, reach) for one in whole),
        pictures,
        building_mesh(found, measured.pictures, reach),
        building_tile(found, measured.pictures, fronts, reach, fronts[0][0].world),
        png,
        _about(found, fronts),
        found.failed,
    )


def _about(found: Assembled, fronts: Sequence[Front]) -> dict[str, Any]:
    """Return what report.json says of a building."""
    faces = [f for b in found.built for f in b.solid.faces]
    offsets = {k: round(v, 4) for b in found.built for k, v in b.offsets.items()}
    return {
        "host": found.coarse.source,
        "lod": "3" if any(found.fine) else "2",
        "facades": [f.id for f, _ in fronts],
        "openings_found": sum(len(e.openings) for _, e in fronts),
        "openings_built": len({f.opening for f in faces if f.semantics in ("Window", "Door")}),
        "installations": [i.id for i in found.installations],
        "window_frames": len({f.opening for f in found.frames}),
        "offsets": offsets,
        "refused": [{"code": f.code, "message": f.message, "hint": f.hint} for f in found.failed],
        "notes": list(found.notes),
    }


def _city_model(job: Job) -> tuple[CityBuilding, ...]:
    """Read the buildings of the project's city model near the scan."""
    source = job.project.model
    if source is None:
        return ()
    scans = job.store.scans()
    low, high = np.array(scans.extent)
    box = (*(low[:2] - _MARGIN_M).tolist(), *(high[:2] + _MARGIN_M).tolist())
    return read_city_model(source.path, scans.world_ref, box, source.crs).buildings


def _shells(group: ModelMatch, city: Sequence[CityBuilding]) -> tuple[Shell, ...]:
    """Return the shells of a group, LoD2 or below; each of several buildings becomes a part."""
    own = [b for b in city if b.id in group.model]
    if len(own) == 1:
        return own[0].level("2")
    return tuple(replace(s, part=b.id) for b in own for s in b.level("2") if not s.installation)


def _joined(records: Sequence[BuildingRecord]) -> Building:
    """Join several measured buildings: the id of the first, the first address, the lowest ground."""
    parts = [record.with_points(np.zeros(0, np.int64)) for record in records]
    grounds = [p.ground_z for p in parts if np.isfinite(p.ground_z)]
    address = next((p.address for p in parts if p.address), None)
    return replace(parts[0], address=address, ground_z=min(grounds, default=parts[0].ground_z))


def _warnings(made: Made) -> list[StageWarning]:
    """Return one warning per code: the first messages, and how many more there are."""
    by_code: dict[str, list[Failed]] = defaultdict(list)
    for failed in made.failed:
        by_code[failed.code].append(failed)
    found = []
    for code, own in by_code.items():
        more = f"; and {len(own) - _NAMED} more, see model/report.json" if len(own) > _NAMED else ""
        text = "; ".join(f.message for f in own[:_NAMED]) + more
        found.append(StageWarning(made.id, code, text, own[0].hint))
    return found


def _notes(made: Sequence[Made]) -> list[str]:
    notes = []
    blocks = [m.id for m in made if m.about is not None and m.about["host"] == "cloud"]
    if blocks:
        some = ", ".join(blocks[:_NAMED]) + (
            f" and {len(blocks) - _NAMED} more" if len(blocks) > _NAMED else ""
        )
        notes.append(f"{some}: built on blocks behind their facades, for lack of a city model")
    for m in made:
        if len(m.measured) > 1:
            notes.append(
                f"{', '.join(m.measured)} stand on one building of the city model and are one in the model"
            )
    return notes


STAGE = Stage(
    name="model",
    after=("buildings", "facades", "crossbars", After("ortho", optional=True)),
    tasks=tasks,
    load=load,
    work=work,
    save=save,
    join=join,
    result=ModelResult,
    table="solids",
    rooms=("ortho", "solids", "validation", "exports", "catalog"),
    inputs=("model",),
    options=("model.crs", "solids", "addresses"),
)
