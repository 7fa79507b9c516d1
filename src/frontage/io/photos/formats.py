"""The registry of formats that bring the cameras and poses of photos.

A new format is one module with a reader, and one entry here.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from frontage.errors import InputError
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.request import PhotoRequest

Reader = Callable[[PhotoRequest], PhotoSet]


@dataclass(frozen=True)
class PoseFormat:
    """A source of cameras and poses.

    name    as users know it
    holds   what it brings
    fits    whether a request is of this format
    reader  "module:function", imported when it is first used
    """

    name: str
    holds: str
    fits: Callable[[PhotoRequest], bool]
    reader: str

    def read(self, request: PhotoRequest) -> PhotoSet:
        """The photos of a request of this format."""
        module, function = self.reader.split(":")
        reader: Reader = getattr(import_module(module), function)
        return reader(request)


def is_one_e57(files: Sequence[Path]) -> bool:
    """Whether the files are a single E57 file, which brings its own cameras."""
    return len(files) == 1 and files[0].suffix.lower() == ".e57"


def _embeds_photos(request: PhotoRequest) -> bool:
    return is_one_e57(request.files)


def _has_cameras(request: PhotoRequest) -> bool:
    return request.cameras is not None


FORMATS = (
    PoseFormat(
        "E57 images2D",
        "pinhole photos that an E57 file embeds, with their cameras and poses",
        _embeds_photos,
        "frontage.io.photos.e57photos:read_e57_photos",
    ),
    PoseFormat(
        "COLMAP model",
        "cameras and poses of picture files, text or binary",
        _has_cameras,
        "frontage.io.photos.colmapphotos:read_colmap_photos",
    ),
)
"""Every format, in the order in which they are tried."""


def pose_format(request: PhotoRequest) -> PoseFormat:
    """The format of a request. Raises InputError when nothing states the cameras."""
    found = next((f for f in FORMATS if f.fits(request)), None)
    if found is None:
        raise InputError(
            'the photos have no cameras; state cameras = "..." (a COLMAP folder) in [photos], because photos '
            "cannot be oriented yet",
            code="I111",
        )
    return found
