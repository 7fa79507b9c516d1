"""Which picture file belongs to which name of a file with poses, and whether its size fits its camera."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path

from frontage.errors import FileError
from frontage.geometry.rigid import Rigid3
from frontage.io.photos.imagefile import SUFFIXES, image_header
from frontage.io.photos.photoset import PhotoSet, PixelSource
from frontage.io.photos.request import PhotoRequest
from frontage.model import Camera

_SHOWN = 3  # names in a message
_QUARTER_TURN = 5  # EXIF orientations from here on exchange width and height

Posed = tuple[str, Camera, Rigid3]
"""A photo as a file states it: its name, its camera, and its pose in the coordinates of the file."""


def photo_set(request: PhotoRequest, posed: Sequence[Posed], notes: Iterable[str] = ()) -> PhotoSet:
    """The photos of a file with poses, each matched to its picture file and checked against it.

    The ids are the names in the file. Raises FileError for names without a picture, with several or with the
    same one, and for pictures of another size than their camera.
    """
    assert request.cameras is not None
    matched = matched_files([name for name, _, _ in posed], request.files, Path(request.cameras))
    pixels = {name: pixel_source(matched[name], camera) for name, camera, _ in posed}
    photos = tuple(request.photo(name, camera, pose) for name, camera, pose in posed)
    extra = len(request.files) - len(photos)
    left = (f"{extra} pictures have no pose in {request.cameras} and were left out",) if extra > 0 else ()
    return PhotoSet(photos, pixels, (*notes, *left))


def matched_files(names: Sequence[str], files: Sequence[Path], cameras: Path) -> dict[str, Path]:
    """The picture file of every name: by its relative path, else its base name, else that without suffix.

    Some programs write names without the suffix of the picture. Raises FileError naming the photos that are
    missing, ambiguous or stated twice.
    """
    by_name: dict[str, list[Path]] = defaultdict(list)
    by_stem: dict[str, list[Path]] = defaultdict(list)
    for f in files:
        by_name[f.name].append(f)
        by_stem[f.stem].append(f)
    found: dict[str, Path] = {}
    missing: list[str] = []
    ambiguous: list[str] = []
    twice: list[str] = []
    for stated in names:
        pick = _candidates(stated.replace("\\", "/"), by_name, by_stem)
        if stated in found:
            twice.append(stated)
        elif len(pick) == 1:
            found[stated] = pick[0]
        else:
            (ambiguous if pick else missing).append(stated)
    owner = {file: name for name, file in found.items()}
    twice += [name for name, file in found.items() if owner[file] != name]
    for wrong, problem in (
        (missing, "names photos that are not there"),
        (ambiguous, "names photos that several files could be"),
        (twice, "names photos twice"),
    ):
        if wrong:
            more = f" and {len(wrong) - _SHOWN} more" if len(wrong) > _SHOWN else ""
            shown = ", ".join(wrong[:_SHOWN])
            raise FileError(cameras, f"{problem}: {shown}{more}", "check [photos] path", code="I112")
    return found


def _candidates(name: str, by_name: dict[str, list[Path]], by_stem: dict[str, list[Path]]) -> list[Path]:
    """The files that a name, which may hold folders, can mean."""
    base = name.rsplit("/", 1)[-1]
    if base in by_name or base.lower().endswith(SUFFIXES):
        candidates = {f: f for f in by_name.get(base, [])}
    else:
        candidates = {f: f.with_suffix("") for f in by_stem.get(base, [])}
    whole = [f for f, known in candidates.items() if known.as_posix().endswith("/" + name)]
    return whole or list(candidates)


def pixel_source(path: Path, camera: Camera) -> PixelSource:
    """How to turn a picture so that it fits its camera.

    A picture whose stored size is the camera's is used as stored; one that has this size once its EXIF
    orientation is applied is turned. Where both have it, as after half a turn, the size does not tell which
    of the two the camera means, and the orientation is doubtful. Raises FileError for any other size.
    """
    h = image_header(path)
    if (h.width, h.height) == (camera.width, camera.height):
        either = h.orientation < _QUARTER_TURN or h.width == h.height
        return PixelSource(str(path), doubtful=h.orientation if either else 1)
    if h.orientation >= _QUARTER_TURN and (h.height, h.width) == (camera.width, camera.height):
        return PixelSource(str(path), h.orientation)
    raise FileError(
        path,
        f"is {h.width} x {h.height} px but its camera is {camera.width} x {camera.height}",
        "use the photos that the cameras were computed from",
        code="I113",
    )


def stored_size(path: Path) -> tuple[int, int]:
    """Width and height in px of a picture whose camera file states no size.

    Raises FileError for a picture with an EXIF quarter turn: nothing tells which of the two sizes the camera
    means.
    """
    h = image_header(path)
    if h.orientation >= _QUARTER_TURN and h.width != h.height:
        raise FileError(
            path,
            "has an EXIF orientation that turns it, and its camera file does not state the size of photos",
            "store the photo as the cameras mean it, without EXIF orientation",
            code="I113",
        )
    return h.width, h.height
