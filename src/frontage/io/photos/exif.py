"""What a camera notes of a shot in the EXIF block of its JPEG file: focal length, place and direction."""

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from PIL import ExifTags, Image
from PIL.TiffImagePlugin import IFDRational

from frontage.errors import FileError
from frontage.geometry.arrays import Array
from frontage.io.files import reading, require_file, whole_file
from frontage.io.photos.imagefile import opened

_VERSION = b"0232"  # EXIF 2.32
_GPS_VERSION = b"\x02\x03\x00\x00"
_TRUE_NORTH = "T"
_BELOW_SEA = b"\x01"
_DENOMINATOR = 100_000  # of stored fractions: keeps seconds of arc to 0.3 mm on the ground
_MARKERS = b"\xff\xd8\xff\xe1"  # start of a JPEG, start of its EXIF segment


@dataclass(frozen=True)
class Exif:
    """What a camera knows of a shot; None where it is not stated.

    focal_length       mm
    focal_length_35mm  mm, its equivalent on 35 mm film
    position           latitude and longitude in degrees (WGS 84), height above sea in m
    heading            degrees, clockwise from true north
    position_error     m, horizontal
    """

    make: str
    model: str
    focal_length: float
    focal_length_35mm: int
    position: tuple[float, float, float] | None = None
    heading: float | None = None
    position_error: float | None = None


def write_jpeg(path: str | Path, rgb: Array, exif: Exif, quality: int = 90) -> Path:
    """Write pixels (h, w, 3) uint8 RGB as JPEG with an EXIF block; equal input gives equal bytes.

    Raises FileError when the picture cannot be encoded or the file cannot be written.
    """
    p = Path(path)
    options = [cv2.IMWRITE_JPEG_QUALITY, quality]
    done, data = cv2.imencode(".jpg", np.ascontiguousarray(rgb[..., ::-1]), options)
    if not done:
        raise FileError(p, f"a picture of {rgb.shape[1]} x {rgb.shape[0]} px cannot be stored as JPEG")
    block = _block(exif).tobytes()
    with whole_file(p) as temporary:
        start = _MARKERS + struct.pack(">H", len(block) + 2) + block
        temporary.write_bytes(start + data.tobytes()[2:])
    return p


def _block(exif: Exif) -> Image.Exif:
    """The EXIF block, little-endian."""
    block = Image.Exif()
    block.endian = "<"
    block[ExifTags.Base.Make] = exif.make
    block[ExifTags.Base.Model] = exif.model
    block[ExifTags.Base.Orientation] = 1
    block[ExifTags.IFD.Exif] = {
        ExifTags.Base.ExifVersion: _VERSION,
        ExifTags.Base.FocalLength: _fraction(exif.focal_length),
        ExifTags.Base.FocalLengthIn35mmFilm: exif.focal_length_35mm,
    }
    gps = _gps(exif)
    if gps:
        block[ExifTags.IFD.GPSInfo] = {ExifTags.GPS.GPSVersionID: _GPS_VERSION, **gps}
    return block


def _gps(exif: Exif) -> dict[int, Any]:
    """The entries of the GPS directory; empty when neither place nor direction is known."""
    tag = ExifTags.GPS
    entries: dict[int, Any] = {}
    if exif.position is not None:
        latitude, longitude, height = exif.position
        entries |= {
            tag.GPSLatitudeRef: "N" if latitude >= 0 else "S",
            tag.GPSLatitude: _sexagesimal(latitude),
            tag.GPSLongitudeRef: "E" if longitude >= 0 else "W",
            tag.GPSLongitude: _sexagesimal(longitude),
            tag.GPSAltitudeRef: _BELOW_SEA if height < 0 else b"\0",
            tag.GPSAltitude: _fraction(abs(height)),
        }
    if exif.heading is not None:
        entries |= {
            tag.GPSImgDirectionRef: _TRUE_NORTH,
            tag.GPSImgDirection: _fraction(exif.heading % 360.0),
        }
    if exif.position_error is not None:
        entries[tag.GPSHPositioningError] = _fraction(exif.position_error)
    return entries


def _sexagesimal(angle: float) -> tuple[IFDRational, IFDRational, IFDRational]:
    """Degrees, minutes and seconds of the absolute angle in degrees."""
    minutes, seconds = divmod(abs(angle) * 3600.0, 60.0)
    degrees, minutes = divmod(minutes, 60.0)
    return _fraction(degrees), _fraction(minutes), _fraction(seconds)


def _fraction(value: float) -> IFDRational:
    return IFDRational(round(value * _DENOMINATOR), _DENOMINATOR)


def read_exif(path: str | Path) -> Exif:
    """Read the EXIF block of a JPEG, PNG or TIFF picture; texts are empty and numbers 0 where it states none.

    A direction from magnetic north is left out, for it cannot be compared with true north.

    Raises FileError when the file is missing, empty, damaged or not a picture.
    """
    p = require_file(path)
    with reading(p, "picture"):
        block = opened(p.read_bytes()).getexif()
        shot, gps = block.get_ifd(ExifTags.IFD.Exif), block.get_ifd(ExifTags.IFD.GPSInfo)
        tag = ExifTags.GPS
        true_north = gps.get(tag.GPSImgDirectionRef, _TRUE_NORTH) == _TRUE_NORTH
        return Exif(
            str(block.get(ExifTags.Base.Make, "")),
            str(block.get(ExifTags.Base.Model, "")),
            float(shot.get(ExifTags.Base.FocalLength, 0.0)),
            int(shot.get(ExifTags.Base.FocalLengthIn35mmFilm, 0)),
            _position(gps),
            _number(gps.get(tag.GPSImgDirection)) if true_north else None,
            _number(gps.get(tag.GPSHPositioningError)),
        )


def _position(gps: dict[int, Any]) -> tuple[float, float, float] | None:
    """Latitude and longitude in degrees and height in m; None when one of them is missing."""
    tag = ExifTags.GPS
    if not {tag.GPSLatitude, tag.GPSLongitude, tag.GPSAltitude} <= gps.keys():
        return None
    south, west = gps.get(tag.GPSLatitudeRef) == "S", gps.get(tag.GPSLongitudeRef) == "W"
    below = gps.get(tag.GPSAltitudeRef, b"\0") == _BELOW_SEA
    latitude, longitude = _degrees(gps[tag.GPSLatitude]), _degrees(gps[tag.GPSLongitude])
    height = float(gps[tag.GPSAltitude])
    return (-latitude if south else latitude, -longitude if west else longitude, -height if below else height)


def _degrees(parts: tuple[Any, Any, Any]) -> float:
    """An angle of degrees, minutes and seconds in degrees."""
    degrees, minutes, seconds = (float(v) for v in parts)
    return degrees + minutes / 60.0 + seconds / 3600.0


def _number(value: Any) -> float | None:
    return None if value is None else float(value)
