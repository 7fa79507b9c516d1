"""The stage `export`: the textured model of paper A, and the ortho-images for GIS programs.

It writes `model/facades.glb` and `model/facades.obj`, and `products/rasters/B07_F1.vrt` of every facade.
"""

from dataclasses import dataclass

from frontage.exports import FacadePicture, facade_mesh
from frontage.io.meshes.textured import TexturedMesh, write_glb, write_obj
from frontage.io.rasters.vrt import write_virtual
from frontage.pipeline.gaps import gaps
from frontage.pipeline.pictures import street_looks, wall_picture
from frontage.pipeline.products import without
from frontage.pipeline.stage import After, Job, Stage
from frontage.pipeline.store.results import StageResult

_SHOWN = ("buildings", "facades", "ortho")  # stages whose results are in these files


@dataclass(frozen=True, kw_only=True)
class ExportResult(StageResult):
    """The textures of the model, by file stem; `items` counts facades."""

    textures: tuple[str, ...]


def load(job: Job) -> list[FacadePicture]:
    """Read the ortho-images of all facades, in one look for the street."""
    store = job.store
    looks = street_looks(store, job.project.ortho)
    pictures = (
        wall_picture(store, store.facade(name), looks.get(name)) for name in store.facade_ids("ortho")
    )
    return [picture for picture in pictures if picture is not None]


def work(job: Job, pictures: list[FacadePicture]) -> list[TexturedMesh]:
    """Triangulate the facades."""
    return [facade_mesh(picture) for picture in pictures]


def save(job: Job, meshes: list[TexturedMesh]) -> list[TexturedMesh]:
    """Write the model in both formats, and the virtual rasters."""
    store = job.store
    folder, world = store.model_folder, store.world()
    folder.mkdir(exist_ok=True)
    left_out = gaps(store, _SHOWN)
    write_glb(folder / "facades.glb", meshes, world, left_out)
    write_obj(folder / "facades.obj", meshes, world, left_out)
    store.wrote(*(folder / f"facades.{ending}" for ending in ("glb", "obj", "mtl", "offset.json")))
    store.wrote(*(folder / "textures" / f"{mesh.file_stem}.jpg" for mesh in meshes))
    for name in store.facade_ids("ortho"):
        if (sidecar := store.sidecar(name)) is not None:
            store.wrote(*write_virtual(store.products_folder / "rasters", store.facade_folder(name), sidecar))
    return meshes


def join(job: Job, parts: list[list[TexturedMesh]]) -> ExportResult:
    """Count the facades, and tell which are left out."""
    (meshes,) = parts
    blind = [name for name in job.store.facade_ids() if not job.store.has(name, "ortho")]
    return ExportResult(
        items=len(meshes),
        textures=tuple(mesh.file_stem for mesh in meshes),
        notes=without(blind, "Without an ortho-image, and so not in model/facades.* and products/rasters"),
    )


STAGE = Stage(
    name="export",
    after=("facades", After("ortho", optional=True)),
    load=load,
    work=work,
    save=save,
    join=join,
    result=ExportResult,
    rooms=("ortho", "exports"),
)
