"""GeoTIFF in a facade's own plane: x to the right, z up, metres, a local engineering CRS.

GDAL reads the true 4x4 matrix of a vertical picture as a degenerate affine transform. The file therefore
carries a plain two-dimensional transform (pixel-is-area) and the matrix to the world as GDAL metadata.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import numpy as np
import tifffile

from frontage.errors import FileError, InputError
from frontage.geometry.arrays import Array, Float
from frontage.io.files import whole_file
from frontage.io.rasters.cog import write_ordered
from frontage.io.rasters.overviews import overviews
from frontage.raster.tiles import Tile, allocate, tiles

_TILE = 256  # pixels
_PICTURE_LEVEL = 1  # of deflate: higher levels take four times as long for a photograph and save nothing
PRINT_SCALE = 50
"""Files state the resolution at which a print shows the facade at 1:50, the scale of detailed elevations."""
_BIG = 2**32 - 2**25  # bytes: classic TIFF ends at 4 GiB
_FIRST, _AGAIN = "run `frontage ortho` first", "run `frontage ortho` again"

# Tags of TIFF and GeoTIFF 1.1 (OGC 19-008r4), and GDAL's two private ones.
_SCALE, _TIEPOINT, _KEYS, _ASCII = 33550, 33922, 34735, 34737
_GDAL_METADATA, _GDAL_NODATA = 42112, 42113
# GeoKeys and their values.
_MODEL_TYPE, _RASTER_TYPE, _CITATION, _LINEAR_UNIT = 1024, 1025, 1026, 3076
_USER_DEFINED, _PIXEL_IS_AREA, _METRE = 32767, 1, 9001

_Tag = tuple[int, int | str, int, Any, bool]
"""Code, type, count, value, and whether only the first page has it, as tifffile takes them."""


@dataclass(frozen=True)
class Georeference:
    """Where a raster lies in its plane.

    corner    (x, z) m: outer upper left corner of pixel (0, 0)
    gsd       m per pixel
    crs_name  name of the local engineering CRS
    metadata  items for GDAL's metadata
    """

    corner: tuple[float, float]
    gsd: float
    crs_name: str
    metadata: Mapping[str, str]


def write_geotiff(
    path: Path,
    band: Array,
    about: Georeference,
    nodata: float | None = None,
    *,
    names: Sequence[str] = (),
    unit: str = "",
) -> None:
    """Write a band (h, w) or an RGBA image (h, w, 4) as a cloud-optimised GeoTIFF.

    It is tiled and deflated, and has overviews.

    names  of its bands; `unit`: of its values

    The resolution in the file is that at which a print shows the facade at 1:50. Floating-point bands have no
    predictor: it would save a sixth, but few programs without GDAL can read it.

    The file is a BigTIFF when it might pass 4 GiB. It appears under its name only when it is complete.

    Raises FileError when it cannot be written.
    """
    rgba = band.ndim == 3
    options: dict[str, Any] = {
        "tile": (_TILE, _TILE),
        "compression": "adobe_deflate",
        "compressionargs": {"level": _PICTURE_LEVEL} if rgba else {},
        "photometric": "rgb" if rgba else "minisblack",
        "metadata": None,
        "software": "frontage",
        "predictor": bool(band.dtype.kind == "u"),
    }
    if rgba:
        options["extrasamples"] = ["unassalpha"]
    dots = PRINT_SCALE * 0.01 / about.gsd
    place = {"extratags": _tags(about, nodata, names, unit), "resolution": (dots, dots)}
    own = options | place | {"resolutionunit": "CENTIMETER"}
    big = band.nbytes * 4 / 3 > _BIG  # overviews take another third
    with (
        whole_file(path) as temporary,
        NamedTemporaryFile(dir=path.parent, prefix=".", suffix=".part") as plain,
    ):
        with tifffile.TiffWriter(plain, bigtiff=big, byteorder="<") as tif:
            tif.write(_padded(band), shape=band.shape, dtype=band.dtype, **own)
            for level in overviews(band):
                options["extratags"] = _nodata(nodata)
                tif.write(_padded(level), shape=level.shape, dtype=level.dtype, subfiletype=1, **options)
        plain.seek(0)
        with open(temporary, "wb") as file:
            write_ordered(plain.file, file)


def _padded(band: Array) -> Iterator[Array]:
    """The tiles of a band, row by row; tiles at the edges are filled up. No copy of the whole is made."""
    for tile in tiles(band.shape[0], band.shape[1], _TILE):
        part = np.ascontiguousarray(band[tile.window])
        if part.shape[:2] != (_TILE, _TILE):
            whole = np.zeros((_TILE, _TILE, *band.shape[2:]), band.dtype)
            whole[: part.shape[0], : part.shape[1]] = part
            part = whole
        yield part


def read_geotiff(path: Path, window: Tile | None = None) -> tuple[Array, tuple[float, float], float]:
    """Read a file of `write_geotiff`: the band, its outer upper left corner (x, z) m, its gsd in m.

    With a `window` of pixels, only that part is read, and the corner is the window's. A whole band that is
    too large for memory is read into a scratch file, tile by tile.

    Raises FileError when the file is missing, damaged or not georeferenced, and InputError when the window
    lies outside the raster.
    """
    if not path.is_file():
        raise FileError(path, "does not exist", _FIRST)
    try:
        with tifffile.TiffFile(path) as tif:
            page = tif.pages[0]
            scale, tie = float(page.tags[_SCALE].value[0]), page.tags[_TIEPOINT].value
            band = (
                page.asarray(out=allocate(page.shape, page.dtype)) if window is None else _part(page, window)
            )
    except InputError:
        raise
    except KeyError as error:
        raise FileError(path, "is a TIFF without georeference", _AGAIN) from error
    except Exception as error:  # tifffile passes on whatever its decoders raise
        raise FileError(path, f"is damaged ({error})", _AGAIN) from error
    left, top = (0, 0) if window is None else (window.c0, window.r0)
    return band, (float(tie[3]) + left * scale, float(tie[4]) - top * scale), scale


def _part(page: Any, window: Tile) -> Array:
    """A window of a page, decoded from the tiles that it touches."""
    h, w = page.shape[:2]
    if not (0 <= window.r0 < window.r1 <= h and 0 <= window.c0 < window.c1 <= w):
        raise InputError(
            f"{page.parent.filehandle.name} has {w} x {h} px; the window {window} lies outside it",
            code="I321",
        )
    if not page.is_tiled:
        raise ValueError("it has no tiles")
    out = np.empty((*window.shape, *page.shape[2:]), page.dtype)
    file, side = page.parent.filehandle, (page.tilelength, page.tilewidth)
    across = -(-w // side[1])
    for i in range(window.r0 // side[0], -(-window.r1 // side[0])):
        for j in range(window.c0 // side[1], -(-window.c1 // side[1])):
            k = i * across + j
            file.seek(page.dataoffsets[k])
            data, _, _ = page.decode(file.read(page.databytecounts[k]), k)
            r, c = i * side[0], j * side[1]
            r0, r1 = max(r, window.r0), min(r + side[0], window.r1)
            c0, c1 = max(c, window.c0), min(c + side[1], window.c1)
            into = out[r0 - window.r0 : r1 - window.r0, c0 - window.c0 : c1 - window.c0]
            into[:] = data.reshape(-1, data.shape[-2], *page.shape[2:])[r0 - r : r1 - r, c0 - c : c1 - c]
    return out


def matrix_text(matrix: Float) -> str:
    """A matrix as text, row by row, with all its digits."""
    return " ".join(repr(float(v)) for v in np.asarray(matrix).ravel())


def _tags(about: Georeference, nodata: float | None, names: Sequence[str], unit: str) -> list[_Tag]:
    """The tags of GeoTIFF 1.1 and GDAL's two private ones."""
    (x, z), gsd = about.corner, about.gsd
    name = about.crs_name.replace("|", "/").encode("ascii", "replace").decode() + "|"
    keys = [
        (_MODEL_TYPE, 0, 1, _USER_DEFINED),
        (_RASTER_TYPE, 0, 1, _PIXEL_IS_AREA),
        (_CITATION, _ASCII, len(name), 0),
        (_LINEAR_UNIT, 0, 1, _METRE),
    ]
    directory = [1, 1, 1, len(keys), *(v for key in keys for v in key)]
    items = "".join(f"  <Item name={quoteattr(k)}>{escape(v)}</Item>\n" for k, v in about.metadata.items())
    for k, band_name in enumerate(names):
        items += f'  <Item name="DESCRIPTION" sample="{k}" role="description">{escape(band_name)}</Item>\n'
        if unit:
            items += f'  <Item name="UNITTYPE" sample="{k}" role="unittype">{escape(unit)}</Item>\n'
    xml = f"<GDALMetadata>\n{items}</GDALMetadata>".encode("ascii", "xmlcharrefreplace").decode()
    tags: list[_Tag] = [
        (_SCALE, "d", 3, (gsd, gsd, 0.0), True),
        (_TIEPOINT, "d", 6, (0.0, 0.0, 0.0, x, z, 0.0), True),
        (_KEYS, "H", len(directory), tuple(directory), True),
        (_ASCII, "s", 0, name, True),
        (_GDAL_METADATA, "s", 0, xml, True),
    ]
    return [*tags, *_nodata(nodata)]


def _nodata(nodata: float | None) -> list[_Tag]:
    return [] if nodata is None else [(_GDAL_NODATA, "s", 0, f"{nodata:g}", True)]
