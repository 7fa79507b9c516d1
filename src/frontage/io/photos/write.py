"""The registry of formats that the poses of photos are written in."""

from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path

from frontage.errors import InputError
from frontage.model import Photo, WorldRef

Writer = Callable[[Path, Sequence[Photo], WorldRef], Path]

WRITERS = {
    "colmap": "frontage.io.colmapwrite:write_colmap_poses",
    "metashape": "frontage.io.photos.interchange.writers:write_metashape",
    "opensfm": "frontage.io.photos.interchange.writers:write_opensfm",
    "opk": "frontage.io.photos.interchange.writers:write_opk",
    "realityscan": "frontage.io.photos.interchange.realityscan:write_realityscan",
}
"""The names of the formats, and their functions "module:function", imported when they are first used."""


def write_poses(path: str | Path, photos: Sequence[Photo], world: WorldRef, format: str) -> Path:
    """Write the cameras and poses of oriented photos for another program; returns what was written.

    path    the file; for "colmap" the folder of the model; "opk" writes a cameras.txt beside the file
    photos  with poses in local metres of `world`
    format  one of `WRITERS`

    Raises InputError for an unknown format, no photos, a photo without a pose, names that occur twice or
    cannot be printed, and a camera that the format cannot express; CrsError; and FileError when a file cannot
    be written.
    """
    if format not in WRITERS:
        raise InputError(f"poses cannot be written as {format!r}; use one of {', '.join(WRITERS)}")
    if not photos:
        raise InputError(f"{path}: there are no photos to write; orient some first")
    names: set[str] = set()
    for photo in photos:
        if photo.local_from_camera is None:
            raise InputError(f"{path}: photo {photo.id} has no pose to write; orient it or leave it out")
        if not photo.id.strip() or not photo.id.isprintable() or photo.id in names:
            raise InputError(f"{path}: photo {photo.id!r} has no name that can be written, or occurs twice")
        names.add(photo.id)
    module, function = WRITERS[format].split(":")
    writer: Writer = getattr(import_module(module), function)
    return writer(Path(path), photos, world)
