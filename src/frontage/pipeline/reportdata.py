"""What the report shows, gathered from a run folder."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from frontage.exports import limit_texture
from frontage.geometry.arrays import Array, Float
from frontage.model import Facade
from frontage.pipeline.clouds import thin_to
from frontage.pipeline.pictures import facade_picture
from frontage.pipeline.store import orientation, registration
from frontage.pipeline.store.manifest import Manifest
from frontage.pipeline.store.records import BuildingRecord
from frontage.pipeline.store.results import EvidencePicture, StageWarning
from frontage.pipeline.store.store import Store
from frontage.report import (
    BuildingView,
    FacadeView,
    OrientationView,
    OrthoView,
    PictureView,
    RegistrationView,
    ReportData,
    WindowView,
)
from frontage.report.windows import fitted

_PICTURE_PX = 1500  # sharp on the page, and a street of 50 facades stays below 30 MB
_WINDOWS_BYTES = 8_000_000  # of all pictures of windows on the page
_PLAN_POINTS = 400_000
_PLAN_CELL_M = 0.1
_FILES = ("ortho.tif", "ortho.json", "depth.tif", "sources.tif", "ortho.jpg",
          "openings.json", "protrusions.json", "openings.png", "evidence.png")  # fmt: skip
_MODEL_SUFFIXES = (".json", ".gml", ".glb", ".obj")


def report_data(store: Store, manifest: Manifest) -> ReportData:
    """Gather everything on the page; pictures are read and shrunk here, because the report opens no file."""
    warnings = [warning for _, warning in manifest.warnings]
    views, streets, groups = [], [], []
    room = _room(store)
    for k, record in enumerate(store.building_records()):
        plan = _plan(store, record.id)
        views.append(_building(store, record, plan, warnings, room))
        streets.append(plan)
        groups.append(np.full(len(plan), k, np.int64))
    ground = _surroundings(store)
    street = np.vstack([ground, *streets])
    group = np.concatenate([np.full(len(ground), -1, np.int64), *groups])
    model = (p for p in store.model_folder.glob("*") if p.suffix in _MODEL_SUFFIXES)
    files = tuple(f"model/{path.name}" for path in sorted(model))
    return ReportData(
        manifest.to_json(),
        tuple(views),
        street,
        group,
        _registration(store, manifest),
        files,
        _orientation(store, manifest),
    )


def _building(
    store: Store, record: BuildingRecord, plan: Float, warnings: Sequence[StageWarning], room: int
) -> BuildingView:
    facades = tuple(_facade(store, name, warnings, room) for name in store.facades_of(record.id))
    picture, about = _model(store, record.id)
    return BuildingView(record.to_json(), plan, facades, _of(record.id, warnings), picture, about)


def _of(item: str, warnings: Sequence[StageWarning]) -> tuple[dict[str, str], ...]:
    return tuple(asdict(warning) for warning in warnings if warning.item == item)


def _model(store: Store, building: str) -> tuple[bytes, dict[str, Any] | None]:
    """Return the picture of a building's model and what is known of it; nothing if there is none."""
    picture = store.model_folder / "pictures" / f"{building}.png"
    about = store.model().get(building)
    return (b"", None) if about is None or not picture.is_file() else (picture.read_bytes(), about)


def _registration(store: Store, manifest: Manifest) -> RegistrationView | None:
    """Return what the stage `register` left, if it had something to do."""
    if manifest.world is None or "register" not in manifest.stages:
        return None
    table, plan = registration.load_report(store.registration_folder)
    origin = np.array(manifest.world["origin"], np.float64)
    return RegistrationView(table, origin, plan["walls"], plan["before"], plan["after"])


def _orientation(store: Store, manifest: Manifest) -> OrientationView | None:
    """Return what the stage `orient` left, if it had something to do."""
    if manifest.world is None or "orient" not in manifest.stages:
        return None
    origin = np.array(manifest.world["origin"], np.float64)
    return OrientationView(orientation.load_report(store.orientation_folder), origin)


def _facade(store: Store, name: str, warnings: Sequence[StageWarning], room: int) -> FacadeView:
    facade, folder = store.facade(name), store.facade_folder(name)
    return FacadeView(
        facade,
        _ortho(store, facade),
        f"facades/{folder.name}",
        _of(name, warnings),
        files=tuple(file for file in _FILES if (folder / file).is_file()),
        windows=_windows(store, facade, room),
        **_openings(store, facade),
    )


def _ortho(store: Store, facade: Facade) -> OrthoView | None:
    sidecar, picture = store.sidecar(facade.id), facade_picture(store, facade)
    if sidecar is None or picture is None:
        return None
    jpeg = limit_texture(picture.jpeg, _PICTURE_PX)
    return OrthoView(jpeg, picture.gsd, picture.size, picture.corner, sidecar.sources)


def _openings(store: Store, facade: Facade) -> dict[str, Any]:
    """Return what is known of the openings of a facade, by the names of the view; nothing if not judged."""
    elements = store.elements(facade.id)
    if elements is None:
        return {}
    told = store.openings_item(facade.building)
    return {
        "elements": elements,
        "evidence": tuple(_picture(store, facade, p) for p in told.pictures.get(facade.id, ())),
        "notes": told.notes.get(facade.id, ()),
    }


def _room(store: Store) -> int:
    """Return how many bytes the picture of a window may have, so that the page stays small enough to send."""
    items = (store.crossbars_item(record.id) for record in store.building_records())
    count = sum(len(own) for item in items for own in item.pictures.values())
    return _WINDOWS_BYTES // max(count, 1)


def _windows(store: Store, facade: Facade, room: int) -> tuple[WindowView, ...]:
    """Return the pictures that window bars were found from, each of at most `room` bytes."""
    folder = store.facade_folder(facade.id)
    pictures = store.crossbars_item(facade.building).pictures.get(facade.id, ())
    shrunk = (fitted((folder / p.file).read_bytes(), room) for p in pictures)
    return tuple(
        WindowView(p.opening, jpeg, p.file, p.panels) for p, jpeg in zip(pictures, shrunk, strict=True)
    )


def _picture(store: Store, facade: Facade, picture: EvidencePicture) -> PictureView:
    png = (store.facade_folder(facade.id) / f"{picture.name}.png").read_bytes()
    return PictureView(png, picture.extent, picture.caption)


def _plan(store: Store, building: str) -> Float:
    """Return a building's own points in plan (k, 2) m local, one per 10 cm."""
    cloud, found = store.surveyed(building)
    return _from_above(cloud.xyz[found.index])


def _surroundings(store: Store) -> Float:
    scan = store.surroundings()
    return _from_above(np.empty((0, 3)) if scan is None else scan.xyz)


def _from_above(xyz: Float) -> Float:
    flat = np.column_stack([xyz[:, :2], np.zeros(len(xyz))])
    kept: Array = thin_to(flat, _PLAN_CELL_M, _PLAN_POINTS)
    return flat[kept, :2]
