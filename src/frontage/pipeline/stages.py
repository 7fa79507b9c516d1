"""The order of work, in one place.

scans -> register -> buildings -> facades -> ortho -> openings -> model -> export -> report

Every stage is a function of the run folder: load, call one room, save, say what it made. What it returns is
kept in its marker and in the manifest: `items` (how many), `warnings` (what failed, with codes), `notes`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from frontage.buildings import BuildingSplit, find_buildings
from frontage.errors import InputError
from frontage.exports import facade_mesh
from frontage.io.citymodels.footprints import read_footprints
from frontage.io.meshes.textured import write_glb, write_obj
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.read import read_photos
from frontage.io.scans.laswrite import write_las
from frontage.io.scans.npz import load_scan, save_scan
from frontage.io.scans.read import read_scans
from frontage.model import Scan, WorldRef, merge_scans
from frontage.pipeline.clouds import Neighbourhoods, around, thin_to, working_cloud
from frontage.pipeline.context import Run
from frontage.pipeline.facadepicture import facade_picture
from frontage.pipeline.files import fingerprint, write_array, write_bytes, write_json
from frontage.pipeline.findopenings import OpeningsTask, openings_task, shared_notes
from frontage.pipeline.modelling import make_model
from frontage.pipeline.project import Project
from frontage.pipeline.records import building_record, world_from_record, world_record
from frontage.pipeline.registering import approximate, register_scans, save_parts
from frontage.pipeline.sightlines import run_photos
from frontage.pipeline.summary import report_data
from frontage.pipeline.tasks import FacadesTask, OrthoTask, facades_task, ortho_task
from frontage.report import render_report

Result = dict[str, Any]
_MAP_OFF = 20.0  # m: further than maps are off; buildings beyond are left unread


@dataclass(frozen=True)
class Stage:
    """A stage: its work, the code it depends on, the inputs and options that its result follows from.

    `needed` tells whether a project has any work for it; `exact`: done alone, it takes nothing that was made
    with other options. `table`: the project's table of its options, where that has another name. `follows`:
    the stage that its tasks follow from, where not from the one before, of whose results they only tell.
    """

    name: str
    work: Callable[[Run], Result]
    packages: tuple[str, ...]
    inputs: tuple[str, ...]
    options: Callable[[Project], Any]
    needed: Callable[[Project], bool] = lambda project: True
    exact: bool = False
    table: str = ""
    follows: str = ""


def scans(run: Run) -> Result:
    """Read every scan into one local frame, merge them, and keep the cloud in a form that loads fast."""
    parts = _read(run)
    merged = merge_scans([scan for _, scan in parts])
    if not len(merged):
        names = ", ".join(str(source.path) for source in run.project.scans)
        raise InputError(f"{names}: no points; give a scan that has some")
    world = merged.world
    if run.project.photos is not None:
        _photos(run, world)  # unusable photos are told now, not after the long work
    run.workspace.begin("scans")
    run.workspace.cloud_path.parent.mkdir(exist_ok=True)
    save_scan(run.workspace.cloud_path, merged)
    kept = save_parts(run, parts) if approximate(run.project) else []
    low, high = world.to_world(merged.xyz.min(0)), world.to_world(merged.xyz.max(0))
    return {
        "items": len(merged),
        "world": world_record(world),
        "extent": [low.tolist(), high.tolist()],
        "rays": merged.has_origins,
        "looks": merged.intensity is not None or merged.rgb is not None,
        "parts": kept,
        "notes": list(merged.notes),
        "warnings": [],
    }


def register(run: Run) -> Result:
    """Scans with approximate poses onto the city model (paper B, section 2.1)."""
    return register_scans(run)


def buildings(run: Run) -> Result:
    """Split the street into buildings (paper A, section 2.1) and cut out a working cloud for each."""
    workspace = run.workspace
    scan = load_scan(workspace.registered_path if approximate(run.project) else workspace.cloud_path)
    model = run.project.model
    near = around([scan], _MAP_OFF)
    footprints = read_footprints(model.path, scan.world, model.crs, near) if model else ()
    split = find_buildings(scan, run.project.buildings, footprints)
    before = workspace.building_records()
    workspace.begin("buildings")
    _save_split(run, scan, split)
    for stale in {b["id"] for b in before} - {b.id for b in split.buildings}:
        workspace.remove_building(stale)
    return {
        "items": len(split.buildings),
        "spacing": split.spacing,
        "points": {"ground": len(split.ground), "occluders": len(split.occluders), "rest": len(split.rest)},
        "notes": list(split.notes),
        "warnings": [],
    }


def facades(run: Run) -> Result:
    """Every building's main facades: plane, frame, outline, layers (paper A, section 2.2)."""
    options, seed = run.project.facades, run.project.project.seed
    tasks = [
        FacadesTask(run.workspace.out, record, run.item_key(record["id"]), run.redo, options, seed)
        for record in run.workspace.building_records()
    ]
    return _gathered(run.map("facades", facades_task, tasks), "facades")


def ortho(run: Run) -> Result:
    """Every facade's ortho-image, from the photos or from the scan (paper A, section 2.3)."""
    photos = _photos(run, _world(run)) if run.project.photos is not None else None
    tasks = [
        OrthoTask(run.workspace.out, record, run.item_key(record["id"]), run.redo, run.project.ortho, photos)
        for record in run.workspace.building_records()
    ]
    made = _gathered(run.map("ortho", ortho_task, tasks), "orthos")
    return made | {"notes": list(photos.notes) if photos else []}


def openings(run: Run) -> Result:
    """Every facade's openings and protrusions, from the beams of the scan (paper B, sections 3.1 and 3.2)."""
    options = run.project.openings
    photos, unread = run_photos(run.project.photos, run.workspace)
    pictured = bool(photos) and not _scans_of(run)["looks"]
    key = partial(_pictured_key, run) if pictured else run.item_key
    tasks = [
        OpeningsTask(run.workspace.out, record, key(record["id"]), run.redo, options, photos, pictured)
        for record in run.workspace.building_records()
    ]
    results = run.map("openings", openings_task, tasks)
    protrusions = sum(len(result["protrusions"]) for result in results)
    notes = [*shared_notes(results), *([unread] if unread else [])]
    return _gathered(results, "openings") | {"protrusions": protrusions, "notes": notes}


def model(run: Run) -> Result:
    """Every building as a closed LoD3 solid with its openings cut in (paper B, section 3.2)."""
    return make_model(run, _world(run))


def export(run: Run) -> Result:
    """The textured model of paper A: OUT/model/facades.glb and facades.obj."""
    workspace = run.workspace
    names = workspace.ortho_ids()
    pictures = [facade_picture(workspace.facade_folder(n), workspace.load_facade(n)) for n in names]
    meshes = [facade_mesh(p) for p in pictures]
    folder = workspace.out / "model"
    before = workspace.done("export")
    workspace.begin("export")
    folder.mkdir(exist_ok=True)
    world = _world(run)
    write_glb(folder / "facades.glb", meshes, world)
    write_obj(folder / "facades.obj", meshes, world)
    textures = [mesh.file_stem for mesh in meshes]
    for stale in set(before["result"].get("textures", []) if before else ()) - set(textures):
        (folder / "textures" / f"{stale}.jpg").unlink(missing_ok=True)
    return {"items": len(meshes), "textures": textures, "notes": [], "warnings": []}


def report(run: Run) -> Result:
    """OUT/report.html: one file, no network."""
    manifest = run.manifest()
    manifest["stages"].pop("report", None)  # the page does not tell of its own making
    page = render_report(report_data(run.workspace, manifest))
    run.workspace.begin("report")
    write_bytes(run.workspace.out / "report.html", page.encode())
    return {"items": 1, "notes": [], "warnings": []}


def _registration(project: Project) -> Any:
    return [_model_crs(project), *_dump([project.registration])] if approximate(project) else None


def _buildings(project: Project) -> Any:
    return [_model_crs(project), *_dump([project.buildings])]


def _facades(project: Project) -> Any:
    return [project.project.seed, *_dump([project.facades])]


def _solids(project: Project) -> Any:
    return [_model_crs(project), *_dump([project.solids, *project.addresses])]


def _model_crs(project: Project) -> str | None:
    return project.model.crs if project.model else None


_BASE = ("geometry", "model", "solve", "raster", "io", "pipeline")
_OPENINGS = (*_BASE, "openings", "catalog", "report")

STAGES: tuple[Stage, ...] = (
    Stage("scans", scans, ("geometry", "model", "io"), ("scans",), lambda p: [p.project.crs, _dump(p.scans)]),
    Stage("register", register, (*_BASE, "registration"), ("model",), _registration, approximate),
    Stage("buildings", buildings, (*_BASE, "buildings"), ("model",), _buildings),
    Stage("facades", facades, (*_BASE, "facades"), (), _facades, exact=True),
    Stage("ortho", ortho, (*_BASE, "ortho"), ("photos",), lambda p: _dump([p.ortho, p.photos]), exact=True),
    Stage("openings", openings, _OPENINGS, (), lambda p: _dump([p.openings]), exact=True, follows="facades"),
    Stage("model", model, (*_BASE, "solids", "exports"), ("model",), _solids, exact=True, table="solids"),
    Stage("export", export, (*_BASE, "exports"), (), lambda p: []),
    Stage("report", report, (*_BASE, "report"), (), lambda p: []),
)


def _dump(options: Sequence[Any]) -> list[Any]:
    return [None if option is None else option.model_dump(mode="json") for option in options]


def _read(run: Run) -> list[tuple[int, Scan]]:
    """Every scan in the world of the first, with the number of its source."""
    found: list[tuple[int, Scan]] = []
    for number, source in enumerate(run.each("scans", run.project.scans)):
        world = found[0][1].world if found else None
        found += [(number, scan) for scan in read_scans(source, world, run.project.project.crs)]
    return found


def _world(run: Run) -> WorldRef:
    return world_from_record(_scans_of(run)["world"])


def _scans_of(run: Run) -> Result:
    """What the first stage told."""
    marker = run.workspace.done("scans")
    if marker is None:
        raise InputError(f"{run.workspace.out}: no scan was read yet; run `frontage run` first")
    return dict(marker["result"])


def _pictured_key(run: Run, item: str) -> str:
    """The key of a task that follows from its building's ortho-images, too."""
    made = run.workspace.done("ortho", item)
    return fingerprint(run.item_key(item), made["key"] if made else None)


def _photos(run: Run, world: WorldRef) -> PhotoSet:
    assert run.project.photos is not None
    return read_photos(run.project.photos, world)


def _save_split(run: Run, scan: Scan, split: BuildingSplit) -> None:
    """Per building: its LAZ, its working cloud, its own points in it; then the list of them all."""
    folder = run.workspace.buildings_folder
    folder.mkdir(exist_ok=True)
    thinned = scan.take(thin_to(scan.xyz, max(0.05, split.spacing)))
    save_scan(folder / "surroundings.npz", replace(thinned, no_returns=()))
    neighbourhoods = Neighbourhoods(scan.xyz)
    records = []
    for building in run.each("buildings", split.buildings):
        cloud, own = working_cloud(scan, neighbourhoods, building.index)
        save_scan(folder / f"{building.id}.npz", cloud)
        write_array(folder / f"{building.id}.index.npy", own)
        write_las(folder / f"{building.id}.laz", cloud.take(own))
        records.append(building_record(building, len(own)))
    write_json(folder / "index.json", {"world": world_record(scan.world), "buildings": records})


def _gathered(results: Sequence[Result], kind: str) -> Result:
    items = [name for result in results for name in result[kind]]
    warnings = [warning for result in results for warning in result["warnings"]]
    return {"items": len(items), "notes": [], "warnings": warnings}
