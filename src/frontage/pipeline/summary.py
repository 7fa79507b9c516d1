"""What the report shows, gathered from a run folder."""

from typing import Any

import numpy as np

from frontage.exports import limit_texture
from frontage.geometry.arrays import Array, Float
from frontage.io.scans.npz import load_scan
from frontage.model import Facade
from frontage.pipeline.clouds import thin_to
from frontage.pipeline.elements import load_elements
from frontage.pipeline.files import read_json
from frontage.pipeline.openingpictures import ortho_corner
from frontage.pipeline.workspace import Workspace
from frontage.report import BuildingView, FacadeView, OrthoView, PictureView, RegistrationView, ReportData

_PICTURE = 1500  # px; sharp on the page, and a street of 50 facades stays below 30 MB
_PLAN_POINTS = 400_000
_PLAN_CELL = 0.1  # m
_FILES = ("ortho.tif", "ortho.json", "depth.tif", "sources.tif", "ortho.jpg",
          "openings.json", "protrusions.json", "openings.png", "evidence.png")  # fmt: skip
_MODEL = (".json", ".gml", ".glb", ".obj")


def report_data(workspace: Workspace, manifest: dict[str, Any]) -> ReportData:
    """Everything on the page; pictures are read and shrunk here, because the report opens no file."""
    views, streets, groups = [], [], []
    for k, record in enumerate(workspace.building_records()):
        plan = _plan(workspace, record["id"])
        views.append(_building(workspace, record, plan, manifest))
        streets.append(plan)
        groups.append(np.full(len(plan), k, np.int64))
    ground = _surroundings(workspace)
    street = np.vstack([ground, *streets])
    group = np.concatenate([np.full(len(ground), -1, np.int64), *groups])
    model = (p for p in (workspace.out / "model").glob("*") if p.suffix in _MODEL)
    files = tuple(f"model/{path.name}" for path in sorted(model))
    return ReportData(manifest, tuple(views), street, group, _registration(workspace, manifest), files)


def _building(
    workspace: Workspace, record: dict[str, Any], plan: Float, manifest: dict[str, Any]
) -> BuildingView:
    with_ortho = set(workspace.ortho_ids())
    warnings = manifest.get("warnings", [])
    facades = tuple(
        _facade(workspace, name, name in with_ortho, warnings) for name in workspace.facades_of(record["id"])
    )
    own = tuple(w for w in warnings if w["item"] == record["id"])
    return BuildingView(record, plan, facades, own, *_model(workspace, record["id"]))


def _model(workspace: Workspace, building: str) -> tuple[bytes, dict[str, Any] | None]:
    """The picture of a building's model and what is known of it; nothing where there is none."""
    folder = workspace.out / "model"
    picture, report = folder / "pictures" / f"{building}.png", folder / "report.json"
    if workspace.done("model") is None or not picture.is_file() or not report.is_file():
        return b"", None
    return picture.read_bytes(), read_json(report).get(building)


def _registration(workspace: Workspace, manifest: dict[str, Any]) -> RegistrationView | None:
    """What the register stage left, where it had something to do."""
    folder, world = workspace.registration_folder, manifest.get("world")
    if world is None or "register" not in manifest.get("stages", {}):
        return None
    with np.load(folder / "plan.npz", allow_pickle=False) as plan:
        arrays = [plan[name] for name in ("walls", "before", "after")]
    return RegistrationView(read_json(folder / "report.json"), np.array(world["origin"], np.float64), *arrays)


def _facade(workspace: Workspace, name: str, has_ortho: bool, warnings: list[dict[str, str]]) -> FacadeView:
    facade = workspace.load_facade(name)
    folder = workspace.facade_folder(name)
    ortho = None
    if has_ortho:
        sidecar = read_json(folder / "ortho.json")
        ortho = OrthoView(
            jpeg=limit_texture((folder / "ortho.jpg").read_bytes(), _PICTURE),
            gsd=float(sidecar["gsd"]),
            size=(int(sidecar["width"]), int(sidecar["height"])),
            corner=ortho_corner(sidecar, facade),
            sources=tuple(str(s) for s in sidecar["sources"]),
        )
    own = tuple(w for w in warnings if w["item"] == name)
    return FacadeView(
        facade,
        ortho,
        f"facades/{folder.name}",
        own,
        files=tuple(file for file in _FILES if (folder / file).is_file()),
        **_openings(workspace, facade),
    )


def _openings(workspace: Workspace, facade: Facade) -> dict[str, Any]:
    """What the stage `openings` left of a facade, by the names of the view; nothing where it left nothing."""
    done = workspace.done("openings", facade.building)
    if done is None or facade.id not in done["result"]["facades"]:
        return {}
    folder, result = workspace.facade_folder(facade.id), done["result"]
    pictures = [
        PictureView((folder / f"{p['name']}.png").read_bytes(), tuple(p["extent"]), p["caption"])
        for p in result["pictures"].get(facade.id, ())
    ]
    return {
        "elements": load_elements(folder, facade.id),
        "evidence": tuple(pictures),
        "notes": tuple(result["notes"].get(facade.id, ())),
    }


def _plan(workspace: Workspace, building: str) -> Float:
    """The building's own points from above (k, 2) m local, one per 10 cm."""
    folder = workspace.buildings_folder
    index = np.load(folder / f"{building}.index.npy", allow_pickle=False)
    return _from_above(load_scan(folder / f"{building}.npz").xyz[index])


def _surroundings(workspace: Workspace) -> Float:
    return _from_above(load_scan(workspace.surroundings_path).xyz)


def _from_above(xyz: Float) -> Float:
    flat = np.column_stack([xyz[:, :2], np.zeros(len(xyz))])
    kept: Array = thin_to(flat, _PLAN_CELL, _PLAN_POINTS)
    return flat[kept, :2]
