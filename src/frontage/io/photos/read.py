"""Photographs with their cameras and poses, and their pixels when they are asked for."""

import glob
from collections import defaultdict
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from frontage.errors import FileError, InputError
from frontage.geometry.arrays import Array
from frontage.geometry.rigid import Rigid3
from frontage.io.colmap import ColmapImage, read_colmap
from frontage.io.files import reading, require_file
from frontage.io.photos.e57photos import EmbeddedPhoto, embedded_bytes, embedded_photos
from frontage.io.photos.imagefile import decode, image_header, parse_header, upright
from frontage.io.poses import given_pose
from frontage.model import Camera, Photo, WorldRef

_PICTURES = (".jpg", ".jpeg", ".png", ".tif", ".tiff")


class PhotoSource(BaseModel):
    """The photos of a project."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    path: str | tuple[str, ...] = Field(
        description="folder, file or glob(s); an E57 file with embedded photos"
    )
    cameras: str | None = Field(default=None, description="COLMAP model folder, text or binary")
    offset: tuple[float, float, float] = Field(
        default=(0.0, 0.0, 0.0), description="m, added to camera positions"
    )
    pose: Literal["trusted", "approximate", "none"] = Field(
        default="trusted", description="how far poses may be trusted"
    )
    sigma_position: float = Field(default=2.0, gt=0, description="m, of an approximate pose")
    sigma_angle: float = Field(default=5.0, gt=0, le=180, description="degrees, of an approximate pose")

    @property
    def sigmas(self) -> tuple[float, ...] | None:
        """Six sigmas of a pose, m and rad; None when poses are trusted."""
        if self.pose != "approximate":
            return None
        return (self.sigma_position,) * 3 + (float(np.radians(self.sigma_angle)),) * 3


@dataclass(frozen=True)
class _Pixels:
    """Where a photo's pixels are: a file, or a blob of an E57 file; orientation to apply after decoding."""

    path: str
    orientation: int = 1
    embedded: int | None = None


@dataclass(frozen=True, eq=False)
class PhotoSet:
    """Photos and the way to their pixels; picklable, holds no pixels itself."""

    photos: tuple[Photo, ...]
    pixels: dict[str, _Pixels]
    notes: tuple[str, ...] = ()

    def image(self, photo_id: str) -> Array:
        """Pixels (h, w, 3) uint8 RGB in the camera's orientation and size.

        Raises FileError when the picture has gone or is damaged; KeyError for an unknown id.
        """
        where = self.pixels[photo_id]
        if where.embedded is not None:
            return decode(embedded_bytes(where.path, where.embedded), where.path)
        p = require_file(where.path)
        with reading(p, "picture"):
            data = p.read_bytes()
            parse_header(data, p)  # a truncated JPEG would decode into grey
            return upright(decode(data, p), where.orientation)


def read_photos(source: PhotoSource, world: WorldRef) -> PhotoSet:
    """The photos with cameras and poses, checked against their files.

    The ids are the names in the camera file. A picture whose stored size is its camera's is used as stored;
    one that has it once its EXIF orientation is applied is turned.

    Raises FileError: no pictures, cameras naming absent photos, a photo of another size than its camera.
    """
    files = picture_files(source.path)
    if len(files) == 1 and files[0].suffix.lower() == ".e57":
        return _embedded(files[0], source, world)
    if source.cameras is None:
        raise InputError(
            '[photos] need cameras = "..." (a COLMAP folder); to orient photos is not yet possible',
            code="I111",
        )
    model = read_colmap(source.cameras)
    matched = _matched(model.images, files, Path(source.cameras))
    photos, pixels = [], {}
    for image in model.images:
        camera = model.cameras[image.camera]
        pixels[image.name] = _checked(matched[image.name], camera)
        photos.append(_photo(image, camera, source, world))
    extra = len(files) - len(photos)
    notes = (f"{extra} pictures have no pose in {source.cameras} and were left out",) if extra > 0 else ()
    return PhotoSet(tuple(photos), pixels, notes)


def picture_files(path: str | tuple[str, ...]) -> list[Path]:
    """Sorted pictures of folders, files and globs. Raises FileError when there are none."""
    found: set[Path] = set()
    for pattern in (path,) if isinstance(path, str) else path:
        p = Path(pattern)
        if p.is_dir():
            found |= {f for f in p.rglob("*") if f.suffix.lower() in _PICTURES}
        elif p.is_file():
            found.add(p)
        else:
            found |= {Path(f) for f in glob.glob(pattern, recursive=True) if Path(f).is_file()}
    if not found:
        raise FileError(
            path if isinstance(path, str) else ", ".join(path),
            "no photos here",
            "check path and glob",
            code="I101",
        )
    return sorted(found)


def _photo(image: ColmapImage, camera: Camera, source: PhotoSource, world: WorldRef) -> Photo:
    """Pose from the model's world to local: the centre moves by offset - origin."""
    if source.pose == "none":
        return Photo(image.name, camera)
    inverse = image.camera_from_world.inverse
    pose = Rigid3("local", "camera", inverse.R, inverse.t + (np.asarray(source.offset) - world.origin))
    return Photo(image.name, camera, given_pose(pose, source.sigmas))


def _matched(images: tuple[ColmapImage, ...], files: list[Path], cameras: Path) -> dict[str, Path]:
    """Name in the model -> file: by the whole relative name, else by the base name where that is unique.

    Raises FileError naming the photos that are absent or ambiguous.
    """
    by_name: dict[str, list[Path]] = defaultdict(list)
    for f in files:
        by_name[f.name].append(f)
    found: dict[str, Path] = {}
    absent: list[str] = []
    twice: list[str] = []
    for image in images:
        name = image.name.replace("\\", "/")
        candidates = by_name.get(name.rsplit("/", 1)[-1], [])
        whole = [f for f in candidates if f.as_posix().endswith("/" + name)]
        pick = whole or candidates
        if len(pick) == 1:
            found[image.name] = pick[0]
        else:
            (twice if pick else absent).append(image.name)
    for names, what in (
        (absent, "names photos that are not there"),
        (twice, "names photos that are there twice"),
    ):
        if names:
            more = f" and {len(names) - 3} more" if len(names) > 3 else ""
            raise FileError(
                cameras, f"{what}: {', '.join(names[:3])}{more}", "check [photos] path", code="I112"
            )
    return found


def _checked(path: Path, camera: Camera) -> _Pixels:
    """How to turn a picture so that it fits its camera. Raises FileError when it does not."""
    h = image_header(path)
    if (h.width, h.height) == (camera.width, camera.height):
        return _Pixels(str(path))
    if h.orientation >= 5 and (h.height, h.width) == (camera.width, camera.height):
        return _Pixels(str(path), h.orientation)
    raise FileError(
        path,
        f"is {h.width} x {h.height} px but its camera is {camera.width} x {camera.height}",
        "use the photos that the cameras were made for",
        code="I113",
    )


def _embedded(path: Path, source: PhotoSource, world: WorldRef) -> PhotoSet:
    """The pinhole photos inside an E57 file."""
    found, notes = embedded_photos(path)
    if not found:
        raise FileError(path, "holds no pinhole photos", "give pictures and cameras", code="I105")
    move = np.asarray(source.offset) - world.origin
    return PhotoSet(
        tuple(_embedded_photo(e, source, move) for e in found),
        {e.id: _Pixels(str(path), embedded=e.number) for e in found},
        tuple(notes),
    )


def _embedded_photo(e: EmbeddedPhoto, source: PhotoSource, move: Array) -> Photo:
    pose = replace(e.file_from_camera, to="local", t=e.file_from_camera.t + move)
    return Photo(e.id, e.camera, None if source.pose == "none" else given_pose(pose, source.sigmas))
