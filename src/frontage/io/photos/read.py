"""Photographs with their cameras and poses: the one entry for photos."""

import glob
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from frontage.errors import FileError
from frontage.io.files import require_file
from frontage.io.photos.formats import is_one_e57, pose_format
from frontage.io.photos.imagefile import SUFFIXES
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.request import PhotoRequest
from frontage.io.photos.rigs import with_mount_sigmas, with_stated_rigs
from frontage.model import WorldRef

OFFSET_FILE = "offset.txt"
"""The name of the file beside the cameras that states their offset: x y z in metres."""


class PhotoSource(BaseModel):
    """The photos of a project, and what the user states about them."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    path: str | tuple[str, ...] = Field(
        description="folder, file or glob(s); an E57 file with embedded photos"
    )
    cameras: str | None = Field(
        default=None,
        description="COLMAP folder, OpenSfM or ODM folder, Metashape XML, OPK table or RealityScan CSV",
    )
    offset: tuple[float, float, float] = Field(
        default=(0.0, 0.0, 0.0), description="m, added to camera positions"
    )
    pose: Literal["trusted", "approximate", "none"] = Field(
        default="trusted", description="how far poses may be trusted"
    )
    sigma_position: float = Field(default=2.0, gt=0, description="m, of an approximate pose")
    sigma_angle: float = Field(default=5.0, gt=0, le=180, description="degrees, of an approximate pose")
    rig: str | None = Field(
        default=None, description="file with the relative poses of cameras on a vehicle: rig_config.json"
    )
    rig_sigma_position: float = Field(
        default=0.0, ge=0, description="m, of the relative poses in a rig; 0 = exact"
    )
    rig_sigma_angle: float = Field(
        default=0.0, ge=0, le=180, description="degrees, of the relative poses in a rig; 0 = exact"
    )

    @property
    def sigmas(self) -> tuple[float, ...] | None:
        """Six sigmas of a pose, m and rad; None when poses are trusted."""
        if self.pose != "approximate":
            return None
        return (self.sigma_position,) * 3 + (float(np.radians(self.sigma_angle)),) * 3


def read_photos(source: PhotoSource, world: WorldRef) -> PhotoSet:
    """Read the cameras and poses of photos and check them against the picture files; no pixels are decoded.

    Poses come back in local metres of `world`. The photos' ids are their names in the file with the cameras.

    Raises FileError when there are no pictures, when the cameras name photos that are missing, or when a
    photo has another size than its camera, and for a rig file that is damaged or belongs to other photos;
    InputError without cameras; MissingExtra for E57 without pye57.
    """
    request = _request(source, world)
    photos = pose_format(request).read(request)
    if source.rig is not None:
        photos = with_stated_rigs(photos, source.rig, estimated=bool(photos.camera_sigmas))
    if source.rig_sigma_position or source.rig_sigma_angle:
        angle = float(np.radians(source.rig_sigma_angle))
        photos = with_mount_sigmas(photos, source.rig_sigma_position, angle)
    return photos


def _request(source: PhotoSource, world: WorldRef) -> PhotoRequest:
    return PhotoRequest(
        tuple(picture_files(source.path)),
        source.cameras,
        world,
        offset=source.offset,
        sigmas=source.sigmas,
        posed=source.pose != "none",
    )


def photo_inputs(source: PhotoSource) -> tuple[Path, ...]:
    """Every file that reading the photos of a source opens, and the pictures that it finds, each once.

    These are the pictures or the E57 file, the files of the format with the cameras where they really lie,
    the offset.txt in their folder, and the rig. Raises FileError as `read_photos` does when there are none.
    """
    request = _request(source, WorldRef(np.zeros(3, np.int64)))
    files = list(request.files)
    if source.cameras is not None and not is_one_e57(files):
        files += pose_format(request).camera_files(request)
        offset = Path(source.cameras) / OFFSET_FILE
        files += [offset] if offset.is_file() else []
    if source.rig is not None:
        files.append(require_file(source.rig))
    return tuple(dict.fromkeys(files))


def picture_files(path: str | tuple[str, ...]) -> list[Path]:
    """The sorted picture files of folders, names and globs. Raises FileError when there are none."""
    found: set[Path] = set()
    for pattern in (path,) if isinstance(path, str) else path:
        p = Path(pattern)
        if p.is_dir():
            found |= {f for f in p.rglob("*") if f.suffix.lower() in SUFFIXES}
        elif p.is_file():
            found.add(p)
        else:
            found |= {Path(f) for f in glob.glob(pattern, recursive=True) if Path(f).is_file()}
    if not found:
        raise FileError(
            path if isinstance(path, str) else ", ".join(path),
            "no photos were found here",
            "check the path or the glob",
            code="I101",
        )
    return sorted(found)
