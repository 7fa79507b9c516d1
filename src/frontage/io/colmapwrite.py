"""Writing a COLMAP text model: cameras, poses, points, all with their digits, and the offset to the world."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from frontage.geometry.arrays import Array, Float, freeze
from frontage.geometry.rigid import quaternion_from_rotation
from frontage.io.files import whole_file
from frontage.model import Camera, Photo, WorldRef

_UNKNOWN_ERROR = -1.0  # px, as COLMAP writes it
_NO_COLOUR = (0, 0, 0)


@dataclass(frozen=True, eq=False)
class Tracks:
    """Where photos show points: m observations.

    point   (m,) index of the point
    photo   (m,) index of the photo
    pixels  (m, 2) column and row, first pixel centre at 0.5
    """

    point: Array
    photo: Array
    pixels: Float

    def __post_init__(self) -> None:
        freeze(self, point=((None,), np.int64), photo=((None,), np.int64), pixels=((None, 2), np.float64))
        if not len(self.point) == len(self.photo) == len(self.pixels):
            raise ValueError("the observations of tracks differ in number")


def write_colmap(
    folder: str | Path,
    photos: Sequence[Photo],
    offset: Float,
    points: Float | None = None,
    tracks: Tracks | None = None,
) -> Path:
    """Write cameras.txt, images.txt, points3D.txt and offset.txt for oriented photos.

    points  (n, 3) m, local; none are written without them
    tracks  the observations of the points

    Poses and points stay in local coordinates; adding `offset` (3,) m takes them to the world (`[photos]
    offset` in the project file). Equal cameras are written once. The numbers of photos and points count
    from 1 in the order given; points have no colour and an unknown error (-1).

    Raises ValueError for a photo without a pose, or tracks of points or photos that are not there, and
    FileError when the files cannot be written.
    """
    where = Path(folder)
    xyz = np.empty((0, 3)) if points is None else np.asarray(points, np.float64).reshape(-1, 3)
    seen = tracks or Tracks(np.empty(0, np.int64), np.empty(0, np.int64), np.empty((0, 2)))
    for at, count, what in ((seen.point, len(xyz), "point"), (seen.photo, len(photos), "photo")):
        if len(at) and (at.min() < 0 or at.max() >= count):
            raise ValueError(f"the tracks name a {what} that is not there")
    rank, texts = _observations(seen, len(photos))
    cameras: dict[str, int] = {}
    lines = []
    for number, (photo, observed) in enumerate(zip(photos, texts, strict=True), 1):
        camera = cameras.setdefault(_camera(photo.camera), len(cameras) + 1)
        pose = photo.pose.inverse
        numbers = (*quaternion_from_rotation(pose.R), *pose.t)
        lines.append(
            f"{number} {' '.join(repr(float(v)) for v in numbers)} {camera} {photo.id}\n{observed}\n"
        )
    _put(where / "cameras.txt", "".join(f"{number} {text}\n" for text, number in cameras.items()))
    _put(where / "images.txt", "".join(lines))
    _put(where / "points3D.txt", _points(xyz, seen, rank) or "# no points\n")
    _put(where / "offset.txt", " ".join(repr(float(v)) for v in np.asarray(offset)) + "\n")
    return where


def write_colmap_poses(folder: Path, photos: Sequence[Photo], world: WorldRef) -> Path:
    """Write the poses of photos as a model without points, with the origin of the world as its offset."""
    return write_colmap(folder, photos, world.origin.astype(np.float64))


def camera_lines(cameras: Iterable[Camera]) -> str:
    """The text of a cameras.txt; the cameras are numbered from 1 in the order given."""
    return "".join(f"{number} {_camera(camera)}\n" for number, camera in enumerate(cameras, 1))


def _observations(seen: Tracks, photos: int) -> tuple[Array, list[str]]:
    """The rank (m,) of every observation within its photo, and the second line of every photo."""
    order = np.argsort(seen.photo, kind="stable")
    count = np.bincount(seen.photo, minlength=photos)
    start = np.concatenate([[0], np.cumsum(count)])
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order)) - np.repeat(start[:-1], count)
    words = [
        f"{u!r} {v!r} {point + 1}"
        for (u, v), point in zip(seen.pixels[order].tolist(), seen.point[order].tolist(), strict=True)
    ]
    return rank, [" ".join(words[a:b]) for a, b in pairwise(start.tolist())]


def _points(xyz: Float, seen: Tracks, rank: Array) -> str:
    """The text of a points3D.txt."""
    order = np.argsort(seen.point, kind="stable")
    start = np.searchsorted(seen.point[order], np.arange(len(xyz) + 1))
    words = [
        f"{photo + 1} {k}" for photo, k in zip(seen.photo[order].tolist(), rank[order].tolist(), strict=True)
    ]
    colour = " ".join(map(str, _NO_COLOUR))
    return "".join(
        " ".join([str(n + 1), *map(repr, at), colour, repr(_UNKNOWN_ERROR), *words[start[n] : start[n + 1]]])
        + "\n"
        for n, at in enumerate(xyz.tolist())
    )


def _camera(camera: Camera) -> str:
    params = " ".join(repr(float(p)) for p in camera.params)
    return f"{camera.model} {camera.width} {camera.height} {params}"


def _put(path: Path, text: str) -> None:
    with whole_file(path) as temporary:
        temporary.write_text(text, "utf-8")
