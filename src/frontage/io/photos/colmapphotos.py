"""Picture files with the cameras and poses of a COLMAP model."""

from dataclasses import replace
from pathlib import Path

from frontage.io.colmap import colmap_files, read_colmap
from frontage.io.colmaprigs import colmap_rig_files, read_colmap_rigs
from frontage.io.photos.match import photo_set
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.request import PhotoRequest


def read_colmap_photos(request: PhotoRequest) -> PhotoSet:
    """The photos of a COLMAP model with its rigs, each matched to its picture file and checked against it.

    The ids are the names in the model. Raises FileError as `read_photos` does.
    """
    assert request.cameras is not None
    model = read_colmap(request.cameras)
    posed = [(i.name, model.cameras[i.camera], i.camera_from_world.inverse) for i in model.images]
    return replace(photo_set(request, posed), rigs=read_colmap_rigs(model))


def colmap_photo_files(folder: Path) -> tuple[Path, ...]:
    """The files that `read_colmap_photos` opens. Raises FileError when there is no model, or only a part."""
    files = colmap_files(folder)
    return *files, *colmap_rig_files(files[0].parent)
