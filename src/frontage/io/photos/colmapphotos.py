"""Picture files with the cameras and poses of a COLMAP model."""

from collections import defaultdict
from pathlib import Path

from frontage.errors import FileError
from frontage.io.colmap import ColmapImage, read_colmap
from frontage.io.photos.imagefile import image_header
from frontage.io.photos.photoset import PhotoSet, PixelSource
from frontage.io.photos.request import PhotoRequest
from frontage.model import Camera

_SHOWN = 3  # names in a message


def read_colmap_photos(request: PhotoRequest) -> PhotoSet:
    """The photos of a COLMAP model, each matched to its picture file and checked against it.

    The ids are the names in the model. Raises FileError as `read_photos` does.
    """
    assert request.cameras is not None
    model = read_colmap(request.cameras)
    matched = _matched(model.images, request.files, Path(request.cameras))
    photos, pixels = [], {}
    for image in model.images:
        camera = model.cameras[image.camera]
        pixels[image.name] = _checked(matched[image.name], camera)
        photos.append(request.photo(image.name, camera, image.camera_from_world.inverse))
    extra = len(request.files) - len(photos)
    notes = (f"{extra} pictures have no pose in {request.cameras} and were left out",) if extra > 0 else ()
    return PhotoSet(tuple(photos), pixels, notes)


def _matched(images: tuple[ColmapImage, ...], files: tuple[Path, ...], cameras: Path) -> dict[str, Path]:
    """The file of every name in the model: by its whole relative name, else by a base name that is unique.

    Raises FileError naming the photos that are missing or ambiguous.
    """
    by_name: dict[str, list[Path]] = defaultdict(list)
    for f in files:
        by_name[f.name].append(f)
    found: dict[str, Path] = {}
    missing: list[str] = []
    ambiguous: list[str] = []
    for image in images:
        name = image.name.replace("\\", "/")
        candidates = by_name.get(name.rsplit("/", 1)[-1], [])
        whole = [f for f in candidates if f.as_posix().endswith("/" + name)]
        pick = whole or candidates
        if len(pick) == 1:
            found[image.name] = pick[0]
        else:
            (ambiguous if pick else missing).append(image.name)
    for names, problem in (
        (missing, "names photos that are not there"),
        (ambiguous, "names photos that several files could be"),
    ):
        if names:
            more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
            raise FileError(
                cameras, f"{problem}: {', '.join(names[:_SHOWN])}{more}", "check [photos] path", code="I112"
            )
    return found


def _checked(path: Path, camera: Camera) -> PixelSource:
    """How to turn a picture so that it fits its camera.

    A picture whose stored size is the camera's is used as stored; one that has this size once its EXIF
    orientation is applied is turned. Where both have it, as after half a turn, the size does not tell which
    of the two the camera means, and the orientation is doubtful. Raises FileError for any other size.
    """
    h = image_header(path)
    if (h.width, h.height) == (camera.width, camera.height):
        either = h.orientation < 5 or h.width == h.height
        return PixelSource(str(path), doubtful=h.orientation if either else 1)
    if h.orientation >= 5 and (h.height, h.width) == (camera.width, camera.height):
        return PixelSource(str(path), h.orientation)
    raise FileError(
        path,
        f"is {h.width} x {h.height} px but its camera is {camera.width} x {camera.height}",
        "use the photos that the cameras were computed from",
        code="I113",
    )
