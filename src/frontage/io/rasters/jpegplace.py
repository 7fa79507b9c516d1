"""What stands beside a JPEG so that other programs know its place and size: world file, GDAL's `.aux.xml`."""

from pathlib import Path

from frontage.io.files import whole_file
from frontage.io.rasters.gdalxml import place_xml
from frontage.io.rasters.geotiff import PRINT_SCALE, Georeference

_DOTS_PER_CM = 2  # unit of the density in a JFIF header
_DENSITY = slice(13, 18)  # its place: unit, horizontal and vertical density
_MOST = 65535


def write_place(jpeg: Path, about: Georeference) -> None:
    """Write `ortho.jgw` and `ortho.jpg.aux.xml` beside `ortho.jpg`. Raises FileError when that fails.

    about  of the JPEG itself: its gsd is larger than that of the ortho-image if the picture was reduced
    """
    (x, z), gsd = about.corner, about.gsd
    rows = (gsd, 0.0, 0.0, -gsd, x + gsd / 2, z - gsd / 2)  # a world file gives the first pixel's centre
    with whole_file(jpeg.with_suffix(".jgw")) as temporary:
        temporary.write_bytes("".join(f"{v!r}\n" for v in rows).encode())
    with whole_file(jpeg.with_name(f"{jpeg.name}.aux.xml")) as temporary:
        temporary.write_bytes(_pam(about).encode())


def with_density(jpeg: bytes, gsd: float) -> bytes:
    """Return a JPEG whose header states the density at which it prints to 1:50, in whole dots per cm."""
    if jpeg[6:11] != b"JFIF\0":
        return jpeg
    dots = min(max(round(PRINT_SCALE * 0.01 / gsd), 1), _MOST).to_bytes(2, "big")
    header = bytearray(jpeg)
    header[_DENSITY] = bytes([_DOTS_PER_CM]) + dots + dots
    return bytes(header)


def _pam(about: Georeference) -> str:
    place = place_xml(about.crs_name, "z", about.corner, about.gsd, about.metadata)
    return f"<PAMDataset>\n{place}</PAMDataset>\n"
