"""The stage `elevations`: the facades of every building drawn, `products/elevations/B07.dxf` and `.pdf`."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np

from frontage.exports.elevations import draw_elevation
from frontage.exports.survey import SurveyedBuilding
from frontage.io.drawings.dxf import write_dxf
from frontage.io.drawings.elevation import Elevation, Underlay
from frontage.io.drawings.pdf import write_pdf
from frontage.model import Facade
from frontage.pipeline.pictures import facade_picture
from frontage.pipeline.products import optional, without
from frontage.pipeline.stage import After, Job, Stage
from frontage.pipeline.store.results import ItemResult, StageResult
from frontage.pipeline.store.store import Store
from frontage.pipeline.survey import addresses_of, gather_building, heights_of


@dataclass(frozen=True, kw_only=True)
class ElevationsItem(ItemResult):
    """The facades of a building that were drawn, and what could not be written."""

    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Drawn:
    """A building, what its heights refer to, and the ortho-images of its facades by their ids."""

    building: SurveyedBuilding
    datum: str
    underlays: dict[str, Underlay]


def tasks(job: Job) -> dict[str, str | None]:
    """Return the buildings with their addresses."""
    return addresses_of(job.store)


def load(job: Job) -> Drawn:
    """Read what was measured of a building, with the ortho-images of its facades."""
    store = job.store
    building = gather_building(store, job.item, job.payload)
    pictures = ((facade.id, _underlay(store, facade)) for facade, _ in building.fronts)
    found = {name: picture for name, picture in pictures if picture is not None}
    return Drawn(building, heights_of(store.world()), found)


def work(job: Job, drawn: Drawn) -> list[Elevation]:
    """Draw the facades."""
    return [
        draw_elevation(drawn.building, facade, elements, drawn.underlays.get(facade.id), drawn.datum)
        for facade, elements in drawn.building.fronts
    ]


def save(job: Job, elevations: list[Elevation]) -> ElevationsItem:
    """Write the drawings of a building; what an extra is missing for is told."""
    if not elevations:
        return ElevationsItem()
    folder = job.store.products_folder / "elevations"
    dxf, pdf = folder / f"{job.item}.dxf", folder / f"{job.item}.pdf"
    notes = (
        optional(job.store, [dxf], partial(write_dxf, dxf, elevations)),
        optional(job.store, [pdf], partial(write_pdf, pdf, elevations, f"Elevations of {job.item}")),
    )
    told = tuple(note for note in notes if note)
    return ElevationsItem(facades=tuple(e.facade for e in elevations), notes=told)


def join(job: Job, parts: Sequence[ElevationsItem]) -> StageResult:
    """Count the facades that were drawn, and tell of which building there is no drawing."""
    bare = [name for name, part in zip(job.payload, parts, strict=True) if not part.facades]
    notes = (
        *without(bare, "Without a facade, and so without a drawing"),
        *(note for part in parts for note in part.notes),
    )
    return StageResult(items=sum(len(part.facades) for part in parts), notes=notes)


def _underlay(store: Store, facade: Facade) -> Underlay | None:
    """Return the ortho-image of a facade as an underlay, None if there is none."""
    picture = facade_picture(store, facade)
    if picture is None:
        return None
    image = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None  # `ortho.jpg` was written by the stage `ortho`
    path = os.path.relpath(store.facade_folder(facade.id) / "ortho.jpg", store.products_folder / "elevations")
    size = (picture.gsd * picture.size[0], picture.gsd * picture.size[1])
    h, w = image.shape[:2]
    return Underlay(path.replace(os.sep, "/"), picture.jpeg, picture.corner, size, (w, h))


STAGE = Stage(
    name="elevations",
    after=("openings", "crossbars", After("ortho", optional=True)),
    tasks=tasks,
    load=load,
    work=work,
    save=save,
    join=join,
    part=ElevationsItem,
    commands=("export",),
    rooms=("exports", "catalog"),
    options=("addresses",),
)
