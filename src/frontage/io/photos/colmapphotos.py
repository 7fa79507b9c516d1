"""Picture files with the cameras and poses of a COLMAP model."""

from frontage.io.colmap import read_colmap
from frontage.io.photos.match import photo_set
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.request import PhotoRequest


def read_colmap_photos(request: PhotoRequest) -> PhotoSet:
    """The photos of a COLMAP model, each matched to its picture file and checked against it.

    The ids are the names in the model. Raises FileError as `read_photos` does.
    """
    assert request.cameras is not None
    model = read_colmap(request.cameras)
    posed = [(i.name, model.cameras[i.camera], i.camera_from_world.inverse) for i in model.images]
    return photo_set(request, posed)
