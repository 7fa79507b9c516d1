"""GeoTIFF in a facade's own plane: x to the right, z up, metres, a local engineering CRS.

GDAL reads the true 4x4 matrix of a vertical picture as a degenerate affine, so the file carries a plain
two-dimensional one (pixel-is-area) and the matrix to the world as GDAL metadata.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import numpy as np
import tifffile

from frontage.errors import FileError
from frontage.geometry.arrays import Array, Float
from frontage.io.files import whole_file
from frontage.raster.tiles import allocate

_TILE = (256, 256)
_BIG = 2**32 - 2**25  # bytes: classic TIFF ends at 4 GiB
_SCALE, _TIEPOINT, _KEYS, _ASCII = 33550, 33922, 34735, 34737
_GDAL_METADATA, _GDAL_NODATA = 42112, 42113


def write_geotiff(
    path: Path,
    band: Array,
    corner: tuple[float, float],
    gsd: float,
    crs_name: str,
    metadata: Mapping[str, str],
    nodata: float | None = None,
) -> None:
    """Write a band (h, w) or (h, w, 4) RGBA as a tiled, deflated GeoTIFF; BigTIFF when it may pass 4 GiB.

    `corner` (x, z) m is the outer upper left corner, `gsd` m per pixel. The file appears under its name only
    when it is complete.

    Raises FileError when it cannot be written.
    """
    rgba = band.ndim == 3
    options: dict[str, Any] = {
        "tile": _TILE,
        "compression": "adobe_deflate",
        "photometric": "rgb" if rgba else "minisblack",
        "extratags": _tags(corner, gsd, crs_name, metadata, nodata),
        "metadata": None,
        "software": "frontage",
        "predictor": bool(band.dtype.kind == "u"),
    }
    if rgba:
        options["extrasamples"] = ["unassalpha"]
    with whole_file(path) as temporary, tifffile.TiffWriter(temporary, bigtiff=band.nbytes > _BIG) as tif:
        tif.write(band, **options)


def read_geotiff(path: Path) -> tuple[Array, tuple[float, float], float]:
    """The band, the outer upper left corner (x, z) m, and the gsd m of a file that `write_geotiff` made.

    A band larger than memory should hold is read into a scratch file, tile by tile.

    Raises FileError when the file is missing, damaged or not georeferenced.
    """
    if not path.is_file():
        raise FileError(path, "does not exist", "run the ortho step first")
    try:
        with tifffile.TiffFile(path) as tif:
            page = tif.pages[0]
            scale, tie = page.tags[_SCALE].value, page.tags[_TIEPOINT].value
            band: Array = page.asarray(out=allocate(page.shape, page.dtype))
    except KeyError as error:
        raise FileError(path, "is a TIFF without georeference", "run the ortho step again") from error
    except Exception as error:  # tifffile raises whatever its decoders do
        raise FileError(path, f"is damaged ({error})", "run the ortho step again") from error
    return band, (float(tie[3]), float(tie[4])), float(scale[0])


def matrix_text(matrix: Float) -> str:
    """A matrix, row by row, with every digit it has."""
    return " ".join(repr(float(v)) for v in np.asarray(matrix).ravel())


def _tags(
    corner: tuple[float, float], gsd: float, crs_name: str, metadata: Mapping[str, str], nodata: float | None
) -> list[tuple[int, int | str, int, Any, bool]]:
    """The GeoTIFF 1.1 tags and GDAL's two private ones."""
    name = crs_name.replace("|", "/").encode("ascii", "replace").decode() + "|"
    keys = [(1024, 0, 1, 32767), (1025, 0, 1, 1), (1026, _ASCII, len(name), 0), (3076, 0, 1, 9001)]
    directory = [1, 1, 1, len(keys), *(v for key in keys for v in key)]
    items = "".join(f"  <Item name={quoteattr(k)}>{escape(v)}</Item>\n" for k, v in metadata.items())
    xml = f"<GDALMetadata>\n{items}</GDALMetadata>".encode("ascii", "xmlcharrefreplace").decode()
    tags: list[tuple[int, int | str, int, Any, bool]] = [
        (_SCALE, "d", 3, (gsd, gsd, 0.0), True),
        (_TIEPOINT, "d", 6, (0.0, 0.0, 0.0, corner[0], corner[1], 0.0), True),
        (_KEYS, "H", len(directory), tuple(directory), True),
        (_ASCII, "s", 0, name, True),
        (_GDAL_METADATA, "s", 0, xml, True),
    ]
    if nodata is not None:
        tags.append((_GDAL_NODATA, "s", 0, f"{nodata:g}", True))
    return tags
