"""The registry of formats that bring the cameras and poses of photos.

A new format is one module with a reader, and one entry here.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from frontage.errors import InputError
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.request import PhotoRequest

_EXCHANGE = "frontage.io.photos.interchange"


@dataclass(frozen=True)
class PoseFormat:
    """A source of cameras and poses.

    name    as users know it
    holds   what it brings
    reader  "module:function" that reads the photos of a request
    fits    "module:function" that tells whether a path, as `[photos] cameras` names it, is of this format
    files   "module:function" that lists the files that the reader opens for such a path

    embeds  whether the photos are embedded in the file that also states their cameras
    needs_orienting   whether its poses and cameras are only good enough to start from

    The functions are imported when they are first used. A format without `fits` and `files` takes cameras
    and poses from the pictures themselves.
    """

    name: str
    holds: str
    reader: str
    fits: str | None = None
    files: str | None = None
    embeds: bool = False
    needs_orienting: bool = False

    def matches(self, request: PhotoRequest) -> bool:
        """Whether a request is of this format."""
        if is_one_e57(request.files) or request.cameras is None:
            return (
                self.fits is None
                and self.embeds == is_one_e57(request.files)
                and not (self.needs_orienting and request.trusted)
            )
        return self.fits is not None and bool(_function(self.fits)(Path(request.cameras)))

    def read(self, request: PhotoRequest) -> PhotoSet:
        """The photos of a request of this format."""
        found: PhotoSet = _function(self.reader)(request)
        return found

    def camera_files(self, request: PhotoRequest) -> tuple[Path, ...]:
        """The files that state the cameras and poses of a request. Raises FileError when they are missing."""
        if self.files is None or request.cameras is None:
            return ()
        found: tuple[Path, ...] = _function(self.files)(Path(request.cameras))
        return found


def _function(name: str) -> Callable[..., Any]:
    module, function = name.split(":")
    found: Callable[..., Any] = getattr(import_module(module), function)
    return found


def is_one_e57(files: Sequence[Path]) -> bool:
    """Whether the files are a single E57 file, which brings its own cameras."""
    return len(files) == 1 and files[0].suffix.lower() == ".e57"


def may_be_colmap(path: Path) -> bool:
    """Whether a path can be meant as a COLMAP model: any that is not of another format."""
    return True


FORMATS = (
    PoseFormat(
        "E57 images2D",
        "pinhole photos that an E57 file embeds, with their cameras and poses",
        "frontage.io.photos.e57photos:read_e57_photos",
        embeds=True,
    ),
    PoseFormat(
        "EXIF",
        "focal length, GPS position and compass heading that cameras note in their pictures",
        "frontage.io.photos.exifphotos:read_exif_photos",
        needs_orienting=True,
    ),
    PoseFormat(
        "Metashape XML",
        "cameras and poses of picture files, with the CRS of the chunk",
        f"{_EXCHANGE}.metashape:read_metashape",
        f"{_EXCHANGE}.metashape:looks_like_metashape",
        f"{_EXCHANGE}.metashape:metashape_files",
    ),
    PoseFormat(
        "RealityScan CSV",
        "internal and external parameters of the cameras of picture files",
        f"{_EXCHANGE}.realityscan:read_realityscan",
        f"{_EXCHANGE}.realityscan:looks_like_realityscan",
        f"{_EXCHANGE}.realityscan:realityscan_files",
    ),
    PoseFormat(
        "OPK table",
        "positions and omega, phi, kappa of picture files, with their cameras in a file beside it",
        f"{_EXCHANGE}.opk:read_opk",
        f"{_EXCHANGE}.opk:looks_like_opk",
        f"{_EXCHANGE}.opk:opk_files",
    ),
    PoseFormat(
        "OpenSfM reconstruction",
        "cameras, poses and rigs of picture files, of OpenSfM and OpenDroneMap projects",
        f"{_EXCHANGE}.opensfm:read_opensfm",
        f"{_EXCHANGE}.opensfm:looks_like_opensfm",
        f"{_EXCHANGE}.opensfm:opensfm_files",
    ),
    PoseFormat(
        "COLMAP model",
        "cameras, poses and rigs of picture files, text or binary",
        "frontage.io.photos.colmapphotos:read_colmap_photos",
        "frontage.io.photos.formats:may_be_colmap",
        "frontage.io.photos.colmapphotos:colmap_photo_files",
    ),
)
"""Every format, in the order in which they are tried."""


def pose_format(request: PhotoRequest) -> PoseFormat:
    """The format of a request. Raises InputError when nothing states the cameras."""
    found = next((f for f in FORMATS if f.matches(request)), None)
    if found is None:
        raise InputError(
            'the photos have no cameras; state cameras = "..." (a COLMAP folder, or a file of Metashape, '
            'OpenSfM, Pix4D or RealityScan) in [photos], or pose = "approximate" or "none" to orient them',
            code="I111",
        )
    return found
