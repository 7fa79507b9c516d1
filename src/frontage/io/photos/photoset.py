"""Photos together with the way to their pixels."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

from frontage.geometry.arrays import Array, Float
from frontage.io.files import reading, require_file
from frontage.io.photos.cache import PIXELS
from frontage.io.photos.decoder import decode
from frontage.io.photos.e57blobs import embedded_bytes
from frontage.io.photos.imagefile import parse_header, upright
from frontage.model import Photo, Rig


@dataclass(frozen=True)
class PixelSource:
    """Where the pixels of a photo are.

    path         the picture file, or the E57 file that holds the picture
    orientation  EXIF orientation 1..8 to apply after decoding
    embedded     number of the picture in an E57 file's images2D; None for a picture file
    doubtful     EXIF orientation that the camera file may have taken into account or not; 1 = none
    """

    path: str
    orientation: int = 1
    embedded: int | None = None
    doubtful: int = 1


@dataclass(frozen=True, eq=False)
class PhotoSet:
    """Photos, the sources of their pixels by photo id, and notes for the user; pixels are not kept.

    `camera_sigmas` holds the standard errors (k,) of camera parameters by photo id, where they are not exact.
    `rigs` tells which photos were taken at the same time by cameras that are fixed to one another; no photo
    is in two of them.
    """

    photos: tuple[Photo, ...]
    pixels: dict[str, PixelSource]
    notes: tuple[str, ...] = ()
    camera_sigmas: dict[str, Float] = field(default_factory=dict)
    rigs: tuple[Rig, ...] = ()

    @property
    def turns(self) -> dict[str, Callable[[Array], Array]]:
        """The photos of doubtful orientation, each with the function that turns its pixels upright."""
        return {
            name: partial(upright, orientation=source.doubtful)
            for name, source in self.pixels.items()
            if source.doubtful != 1
        }

    def image(self, photo_id: str) -> Array:
        """Read the pixels (h, w, 3) uint8 RGB of a photo, in the orientation and size of its camera.

        Raises FileError when the picture is missing or damaged, and KeyError for an unknown id.
        """
        source = self.pixels[photo_id]
        p = require_file(source.path)
        found = p.stat()
        return PIXELS.get((source, found.st_mtime_ns, found.st_size), lambda: self._decoded(photo_id))

    def _decoded(self, photo_id: str) -> Array:
        source = self.pixels[photo_id]
        if source.embedded is not None:
            data = embedded_bytes(source.path, source.embedded)
            return decode(data, f"{source.path}: embedded photo {photo_id}")
        p = require_file(source.path)
        with reading(p, "picture"):
            data = p.read_bytes()
            parse_header(data, p)  # refuses a truncated JPEG, which would decode into grey
            return upright(decode(data, p), source.orientation)
